"""One effect of the library in a rig, at its place in the hardware; one number, `severity`, sets its strength.

    reference   delay, command_limit, command_rate_limit, command_dead_zone, command_backlash     a waveform, before the rig
    rig         rate_limit, acceleration_limit, position_limit, dead_zone, coulomb_friction       in its equations
    output      backlash                                                                          behind the encoder of the loop
    sensor      chatter, sensor_bias, quantisation                                                in the measurement

Strengths are scored where the library has a counterpart. A rate limit is the saturation of the speed demanded by the controller. A torque
limit, a friction, a delay, and the speed of a valve, which depends on the load, have no exact counterpart in a model of the library, so that
their strength is not scored.
"""

from dataclasses import dataclass
from typing import Callable

import numpy as np

from .rig_equations import play, slew

HUM = (0.5, 4.0)  # of the bandwidth
DRIFT_PER_S = (0.02, 0.1)  # of the severity; the offset is up to once the severity
SPREAD = 0.35  # the two sides of a limit differ by up to this share in half of the draws


@dataclass
class Effect:
    """`parameters(severity)`, severities from `least` to `most`; which of the parameters can be scored."""

    name: str
    parameters: Callable
    least: float
    most: float
    scored: bool = True


def in_reference(name, values, reference, h):
    """The reference behind an effect of the command side, on steps of h."""
    if name == "delay":
        behind = int(round(values["time"] / h))
        return np.r_[np.full(behind, reference[0]), reference][: len(reference)]
    if name == "command_limit":
        return np.clip(reference, values["min"], values["max"])
    if name == "command_rate_limit":
        return slew(reference, values["up"] * h, reference[0])
    if name == "command_backlash":
        return play(reference, values["gap"], reference[0])
    if name == "command_dead_zone":
        return reference - np.clip(reference, -values["half_width"], values["half_width"])
    return reference


def in_rig(name, values, plant):
    """The rig with an effect in its loop."""
    if name == "rate_limit":
        return plant._replace(rate=values["up"])
    if name == "acceleration_limit":
        return plant._replace(acceleration=values["value"])
    if name == "position_limit":
        return plant._replace(lowest=values["min"], highest=values["max"])
    if name == "dead_zone":
        return plant._replace(half_width=values["half_width"])
    if name == "coulomb_friction":
        return plant._replace(coulomb=plant.coulomb + values["acceleration"])
    return plant


def at_output(name, values, position):
    return play(position, values["gap"], position[0]) if name == "backlash" else position


def at_sensor(name, values, position, time, phase):
    """The measurement before noise; a record begins at any `phase` of an oscillation. The recorder rounds position plus noise."""
    if name == "chatter":
        return position + values["amplitude"] * np.sin(2.0 * np.pi * values["frequency"] * time + phase)
    if name == "sensor_bias":
        return position + values["offset"] + values["drift"] * time
    return position


def draw(rng, name, drawn):
    """The family of one effect for this rig, sizes relative to the demand of the excitation."""
    amplitude, w = drawn.amplitude_deg, 2.0 * np.pi * drawn.bandwidth_hz
    speed = 2.0 * np.pi * drawn.highest_hz * amplitude
    low, high = two_sides(rng)

    def sides(names, size, signs):
        return lambda severity: {name: sign * side * size / severity for name, sign, side in zip(names, signs, (low, high))}

    return {
        "delay": Effect(name, lambda s: {"time": s / w}, 0.1, 3.0, scored=False),
        "command_limit": Effect(name, sides(("min", "max"), amplitude, (-1.0, 1.0)), 1.02, 5.0),
        "command_rate_limit": Effect(name, lambda s: {"up": speed / s, "down": speed / s}, 0.5, 8.0),
        "command_dead_zone": Effect(name, lambda s: {"half_width": s * amplitude}, 0.005, 0.5),
        "command_backlash": Effect(name, lambda s: {"gap": s * amplitude}, 0.01, 0.8),
        "rate_limit": Effect(name, lambda s: {"up": speed / s, "down": speed / s}, 0.5, 8.0, scored=drawn.name != "hydraulic"),
        "acceleration_limit": Effect(name, lambda s: {"value": speed * w / s}, 0.3, 10.0, scored=False),
        "position_limit": Effect(name, sides(("min", "max"), amplitude, (-1.0, 1.0)), 1.02, 5.0),
        "dead_zone": Effect(name, lambda s: {"half_width": s * amplitude}, 0.005, 0.5),
        "coulomb_friction": Effect(name, lambda s: {"acceleration": s * speed * w}, 0.01, 3.0, scored=False),
        "backlash": Effect(name, lambda s: {"gap": s * amplitude}, 0.01, 0.8),
    }[name]  # fmt: skip


NAMES = ("rate_limit", "backlash", "position_limit", "coulomb_friction", "acceleration_limit", "dead_zone", "command_limit", "delay",
         "command_rate_limit", "command_backlash", "command_dead_zone")  # fmt: skip

SENSOR_NAMES = ("chatter", "quantisation", "sensor_bias")


def draw_of_sensor(rng, name, drawn):
    """The same for an effect of the sensor."""
    amplitude, hum_hz = drawn.amplitude_deg, drawn.bandwidth_hz * rng.uniform(*HUM)
    level, per_s = rng.uniform(-1.0, 1.0), rng.uniform(*DRIFT_PER_S)
    return {
        "chatter": Effect(name, lambda s: {"amplitude": s * amplitude, "frequency": hum_hz}, 1e-3, 1.0),
        "sensor_bias": Effect(name, lambda s: {"offset": level * s * amplitude, "drift": per_s * s * amplitude}, 1e-3, 1.0),
        "quantisation": Effect(name, lambda s: {"step": s * amplitude}, 1e-3, 2.0),
    }[name]


def two_sides(rng):
    if rng.random() < 0.5:
        return 1.0, 1.0
    return tuple(1.0 + SPREAD * rng.uniform(-1.0, 1.0, 2))
