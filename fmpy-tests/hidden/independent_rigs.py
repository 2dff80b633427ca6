"""Six more rigs with random physical parameters, and with separate sensors and loggers.

    brushless    current, speed and position loops at 1 kHz, feed-forward, gear      rc_servo    PD loop, DC motor with its back EMF, elastic horn
    servovalve   spool, compressible oil; half of them with the root of the pressure voice_coil  one mass on a flexure, a mode in the sensor's way
    pneumatic    PI loop, slow pressure                                              stepper     profile filters, magnetic spring, worm gear

Bandwidths follow from the type of drive; where the load's damping is below the bandwidth, the load coasts through a play.
"""

from dataclasses import dataclass

import numpy as np

from . import independent_sensors, rigs
from .independent_equations import BRUSHLESS, NEUTRAL, PNEUMATIC, RC_SERVO, SERVOVALVE, STEPPER, STEP_S, VOICE_COIL, march
from .wide import logarithmic

AMPLITUDE_DEG = (0.5, 20.0)
HIGHEST = 1.4  # frequency of the commands over the bandwidth
UNSTABLE_DEG = 1e6


@dataclass
class Drawn(rigs.Drawn):
    """A rig with its sensor, features that no effect describes, effects that occur in such hardware, and whether its load coasts through a play."""

    sensor: independent_sensors.Sensor
    outside: tuple
    effects: tuple
    coasts: bool


def draw(rng, name):
    amplitude = logarithmic(rng, AMPLITUDE_DEG)
    values, inherent, outside, effects = RIGS[name](rng, amplitude)
    w = values.pop("bandwidth")
    bandwidth = w / (2.0 * np.pi)
    plant = NEUTRAL._replace(**{key: float(value) for key, value in values.items()})
    sensor = independent_sensors.draw(rng, amplitude, bandwidth)
    return Drawn(name, plant, bandwidth, amplitude, HIGHEST * bandwidth, sensor.late_samples / sensor.rate_hz,
                 (*inherent, *independent_sensors.inherent(sensor)), sensor, outside, effects, bool(plant.load_damping < w))  # fmt: skip


def coupling(share, w, z, damping):
    return {"load_share": share, "coupling_w": w, "coupling_z": z, "load_damping": damping}


def hertz(rng, low, high):
    return 2.0 * np.pi * rng.uniform(low, high)


def milliseconds(rng, choices):
    """A control period, in steps."""
    return rng.choice(choices) * 1e-3 / STEP_S


def brushless(rng, amplitude):
    w = hertz(rng, 2.0, 7.0)
    kv = w * rng.uniform(3.2, 4.5)
    loops = {"kp": w, "kv": kv, "ki": kv * kv * rng.uniform(0.02, 0.08), "feed_forward": rng.uniform(0.0, 0.5), "lag": rng.uniform(0.0003, 0.0008)}
    gear = coupling(rng.uniform(0.2, 0.5), hertz(rng, 70.0, 130.0), rng.uniform(0.05, 0.12), w * logarithmic(rng, (0.1, 2.0)))
    return {"structure": BRUSHLESS, "bandwidth": w, "period": 1e-3 / STEP_S, "integral_limit": kv * w * amplitude * 0.3, **loops, **gear}, (), (), (
        "rate_limit", "backlash", "coulomb_friction", "acceleration_limit", "position_limit", "dead_zone")  # fmt: skip


def servovalve(rng, amplitude):
    oil, z = hertz(rng, 25.0, 60.0), rng.uniform(0.25, 0.45)
    w = min(hertz(rng, 2.0, 7.0), oil * z * 0.9)
    valve = {"valve_w": hertz(rng, 80.0, 150.0), "valve_z": rng.uniform(0.6, 0.9), "w": oil, "z": z}
    root = rng.random() < 0.5
    supply = amplitude * w * w / oil * rng.uniform(2.5, 4.0) if root else 0.0
    load = coupling(rng.uniform(0.05, 0.2), hertz(rng, 90.0, 160.0), rng.uniform(0.05, 0.1), w * logarithmic(rng, (0.2, 4.0)))
    return {"structure": SERVOVALVE, "bandwidth": w, "period": 1e-3 / STEP_S, "kp": w, "supply": supply, **valve, **load}, (), (
        ("square_root_flow",) if root else ()), ("rate_limit", "dead_zone", "coulomb_friction", "backlash", "position_limit")  # fmt: skip


def pneumatic(rng, amplitude):
    w = hertz(rng, 2.0, 4.5)
    loop = {"kp": w, "motor_lag": 1.0 / (w * rng.uniform(3.0, 5.0)), "lag": rng.uniform(0.06, 0.15) / w, "ki": w * w * rng.uniform(0.02, 0.06)}
    period = milliseconds(rng, [1.0, 2.0, 5.0])
    load = coupling(rng.uniform(0.1, 0.3), hertz(rng, 80.0, 120.0), rng.uniform(0.05, 0.1), w * logarithmic(rng, (0.1, 2.0)))
    return {"structure": PNEUMATIC, "bandwidth": w, "period": period, "integral_limit": 0.5 * w * amplitude, **loop, **load}, (), (), (
        "rate_limit", "dead_zone", "coulomb_friction", "backlash", "position_limit")  # fmt: skip


def rc_servo(rng, _):
    w, z = hertz(rng, 3.0, 10.0), rng.uniform(0.5, 0.85)
    motor = rng.uniform(0.5, 0.9) * 2.0 * z * w
    loop = {"motor_lag": 1.0 / motor, "kp": w * w / motor, "kd": 2.0 * z * w / motor - 1.0, "period": milliseconds(rng, [1.0, 2.0])}
    horn = coupling(rng.uniform(0.08, 0.25), w * rng.uniform(5.0, 7.0), rng.uniform(0.03, 0.1), w * logarithmic(rng, (0.1, 2.0)))
    return {"structure": RC_SERVO, "bandwidth": w, **loop, **horn}, ("structural_mode",), (), (
        "rate_limit", "dead_zone", "coulomb_friction", "backlash", "acceleration_limit")  # fmt: skip


def voice_coil(rng, _):
    w, share = hertz(rng, 8.0, 40.0), rng.uniform(0.05, 0.4)  # share of the flexure in the stiffness
    flexure, coil, z_flexure = w * np.sqrt(share), w * w * (1.0 - share), 0.05
    z = rng.uniform(0.4, 0.8)
    loop = {"coil": coil, "gain": w * w / coil * rng.uniform(0.95, 1.05), "feedback": 1.0, "kd": 2.0 * z * w - 2.0 * z_flexure * flexure}
    mode = {"mode_w": w * rng.uniform(2.5, 5.0), "mode_z": rng.uniform(0.02, 0.06), "mode_gain": rng.uniform(-0.12, 0.12)}
    return {"structure": VOICE_COIL, "bandwidth": w, "w": flexure, "z": z_flexure, **loop, **mode}, ("structural_mode",), (), (
        "acceleration_limit", "amplitude_gain", "coulomb_friction", "position_limit")  # fmt: skip


def stepper(rng, amplitude):
    w = hertz(rng, 2.5, 8.0)
    magnet = w * rng.uniform(3.0, 5.0)
    drive = {"filter_1": w, "filter_2": w * rng.uniform(2.0, 4.0), "w": magnet, "z": rng.uniform(0.35, 0.6),
             "poles": 0.5 * np.pi / (1.2 * amplitude), "microstep": amplitude * logarithmic(rng, (1e-4, 5e-4))}  # fmt: skip
    worm = coupling(rng.uniform(0.1, 0.3), magnet * rng.uniform(3.0, 4.0), rng.uniform(0.06, 0.12), w * logarithmic(rng, (0.2, 4.0)))
    return {"structure": STEPPER, "bandwidth": w, **drive, **worm}, (), ("magnetic_spring", "microsteps"), (
        "rate_limit", "backlash", "coulomb_friction", "position_limit")  # fmt: skip


RIGS = {"brushless": brushless, "servovalve": servovalve, "pneumatic": pneumatic, "rc_servo": rc_servo, "voice_coil": voice_coil, "stepper": stepper}


def move(plant, reference):
    """The position at the sensor at the ends of the steps of the reference."""
    seen = march(plant, STEP_S, np.ascontiguousarray(reference))
    if not np.abs(seen).max() < UNSTABLE_DEG:
        raise FloatingPointError("the rig is unstable")
    return seen
