"""Strengths of effects: for each, a random family of parameters along one number, `severity`, with which the gap grows.

`Situation` describes the motion of the actuator, so that limits lie inside its range. A family is drawn once per case (signs,
asymmetry, frequencies); `cases.py` then searches for the severity that gives the wanted gap.
"""

from dataclasses import dataclass
from typing import Callable

import numpy as np

from .excitation import HIGHEST_HZ


@dataclass
class Situation:
    """The operating conditions of an effect: largest command and position [deg], omega [rad/s], length of the records [s], end of the excited band."""

    command: float
    position: float
    omega: float
    duration_s: float
    highest_hz: float = HIGHEST_HZ


@dataclass
class Family:
    """`parameters(severity)` between the two severities; `needs_load`: the records contain a load."""

    parameters: Callable
    least: float
    most: float
    needs_load: bool = False
    # a refit of the base would leave no gap, so that the gap relative to the given model counts
    seen_before_refit: bool = False


def sign(rng):
    return float(rng.choice([-1.0, 1.0]))


def two_sided(rng, names, value, least_ratio=0.6, most_ratio=1.6, signs=(1.0, 1.0)):
    """Symmetric in half of the cases; otherwise the second is the first times a ratio."""
    ratio = 1.0 if rng.random() < 0.5 else float(np.exp(rng.uniform(np.log(least_ratio), np.log(most_ratio))))
    if rng.random() < 0.5:
        names, signs = names[::-1], signs[::-1]
    return lambda severity: {names[0]: signs[0] * value / severity, names[1]: signs[1] * ratio * value / severity}


def proportional(name, least, most, factor=1.0, around=0.0):
    return Family(lambda severity: {name: around + factor * severity}, least, most)


def hinge_load(rng, _):
    kind = rng.choice(["bias", "stiffness", "both", "stiffness unseen"], p=[0.3, 0.35, 0.25, 0.1])
    bias, stiffness = sign(rng) * rng.uniform(0.3, 1.0), sign(rng) * rng.uniform(0.3, 1.0)
    stiffness = max(stiffness, -0.5)  # negative stiffness beyond 1 diverges
    if kind == "bias":
        return Family(lambda severity: {"bias": bias * severity}, 0.01, 1.5, needs_load=bool(rng.random() < 0.4))
    if kind == "both":
        return Family(lambda severity: {"bias": bias * severity, "stiffness": stiffness * severity}, 0.01, 0.8, needs_load=True)
    unseen = kind == "stiffness unseen"
    return Family(lambda severity: {"stiffness": stiffness * severity}, 0.01, 0.8, not unseen, unseen)


def sensor_bias(rng, situation):
    kind = rng.choice(["offset", "drift", "both"])
    offset, drift = sign(rng), sign(rng) * rng.uniform(0.5, 3.0) / situation.duration_s
    chosen = {"offset": (1, 0), "drift": (0, 1), "both": (1, 1)}[kind]
    parameters = [(name, value) for name, value, used in zip(("offset", "drift"), (offset, drift), chosen) if used]
    return Family(lambda severity: {name: value * severity for name, value in parameters}, 0.003, 1.5)


def structural_mode(rng, _):
    frequency, damping = float(rng.uniform(4.0, 25.0)), float(np.exp(rng.uniform(np.log(0.01), np.log(0.08))))
    upright = sign(rng) if rng.random() < 0.3 else 1.0
    return Family(lambda severity: {"frequency": frequency, "damping": damping, "gain": upright * severity}, 0.005, 0.6)


def chatter(rng, _):
    frequency, phase = float(rng.uniform(3.0, 40.0)), float(rng.uniform(-3.0, 3.0))
    return Family(lambda severity: {"amplitude": severity, "frequency": frequency, "phase": phase}, 0.002, 2.0)


def amplitude_gain(rng, situation):
    direction = sign(rng)
    most = (0.05 if direction < 0 else 0.6) / situation.position**2  # with a softer spring the motion could diverge
    return proportional("cubic", 1e-3 * most, most, direction)


def parameter_shift(rng, _):
    """Factors on k, omega and zeta, one, two or all of them."""
    used = rng.permutation([True, rng.random() < 0.6, rng.random() < 0.6])
    directions = np.where(used, rng.uniform(0.3, 1.0, 3) * rng.choice([-1.0, 1.0], 3), 0.0) * [0.4, 1.0, 1.5]
    names = ("k", "omega", "zeta")
    return Family(lambda severity: {name: float(np.exp(d * severity)) for name, d in zip(names, directions)}, 0.003, 0.25,
                  seen_before_refit=True)  # fmt: skip


def distributed_play(rng, situation):
    first = float(rng.uniform(0.05, 0.3)) * situation.position
    values = {"first": first, "last": first * float(rng.uniform(3.0, 6.0)), "count": int(rng.integers(4, 8))}
    return Family(lambda severity: {**values, "share": severity}, 0.01, 0.8)


def bouc_wen(rng, situation):
    reach = float(rng.uniform(0.1, 0.5)) * situation.position
    return Family(lambda severity: {"hysteresis": severity, "reach": reach}, 0.01, 1.5)


def drifting_omega(rng, situation):
    if rng.random() < 0.5:
        return Family(lambda severity, way=sign(rng): {"drift": way * severity / situation.duration_s}, 0.02, 0.6)
    period = float(rng.uniform(0.15, 0.8)) * situation.duration_s
    return Family(lambda severity: {"swing": severity, "period": period}, 0.02, 0.5)



def fastest(s):
    """[rad/s]"""
    return 2.0 * np.pi * s.highest_hz


FAMILIES = {
    "delay": lambda rng, s: proportional("time", 3e-4, 0.03),
    "command_limit": lambda rng, s: Family(two_sided(rng, ("max", "min"), s.command, 0.6, 1.2, (1.0, -1.0)), 1.02, 5.0),
    "command_rate_limit": lambda rng, s: Family(two_sided(rng, ("up", "down"), fastest(s) * s.command), 0.7, 8.0),
    "command_dead_zone": lambda rng, s: proportional("half_width", 0.005, 0.6),
    "command_backlash": lambda rng, s: proportional("gap", 0.01, 0.8),
    "asymmetric_gain": lambda rng, s: proportional("ratio", 0.004, 0.3, sign(rng), 1.0),
    "gain_drift": lambda rng, s: proportional("rate", 0.004, 0.4, sign(rng) / s.duration_s),
    "parameter_shift": parameter_shift,
    "dead_zone": lambda rng, s: proportional("half_width", 0.005, 0.5),
    "amplitude_gain": amplitude_gain,
    "hinge_load": hinge_load,
    "coulomb_friction": lambda rng, s: proportional("level", 0.005, 0.5),
    "acceleration_limit": lambda rng, s: Family(lambda severity: {"value": fastest(s) * s.omega * s.position / severity}, 0.7, 15.0),
    "rate_limit": lambda rng, s: Family(two_sided(rng, ("up", "down"), fastest(s) * s.position), 0.7, 8.0),
    "position_limit": lambda rng, s: Family(two_sided(rng, ("max", "min"), s.position, 0.6, 1.2, (1.0, -1.0)), 1.02, 5.0),
    "backlash": lambda rng, s: proportional("gap", 0.01, 0.8),
    "structural_mode": structural_mode,
    "sensor_lag": lambda rng, s: proportional("time", 3e-4, 0.03),
    "sensor_bias": sensor_bias,
    "chatter": chatter,
    "quantisation": lambda rng, s: proportional("step", 0.003, 1.0),
}
OUTSIDE_FAMILIES = {
    "distributed_play": distributed_play,
    "bouc_wen": bouc_wen,
    "drifting_omega": drifting_omega,
    "turbulence": lambda rng, s: proportional("rms", 0.005, 1.5),
}
