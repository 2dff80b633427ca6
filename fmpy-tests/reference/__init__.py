"""Independent reference for the actuator: simulator and describing functions. Start reading in plant.py."""

from .plant import simulate

__all__ = ["simulate"]
