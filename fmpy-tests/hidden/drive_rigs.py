"""Eight drives with random physical parameters, and their sessions: the same drive on another day.

    eha        motor, fixed pump, cylinder with leakage         harmonic   harmonic drive, encoder at the motor, sensor at the link
    spool      servo valve, over- or underlapped                cable      motor, tendon of two cables, pulley; no tachometer
    piezo      tilt stage, integral loop with windup limit      pwm        hobby servo that latches pulses at 50 Hz
    linear     linear motor on a fieldbus                       worm       DC motor, self-locking worm gear; no tachometer

Stiffnesses, inertias and loops are set relative to the bandwidth, as in design practice; speeds, torques and strokes have reserves, except in
half of the hobby servos.
"""

from dataclasses import dataclass

import numpy as np

from . import drive_sensors
from .drive_dynamics import CABLE, EHA, HARMONIC, LINEAR, NEUTRAL, PIEZO, PWM, SPOOL, WORM, Rig, linear_part, march, propagators
from .wide import logarithmic

FINE_STEP_S, STEP_S = 1e-4, 2e-4  # at more than 1000 samples per second, and otherwise
HIGHEST = 1.4  # frequency of the commands over the bandwidth
UNSTABLE = 1e3  # times the amplitude
FRICTION_CHANGE, MOST_CHANGE = 0.08, 0.2  # from session to session, rms and largest
NEAR = 8.0  # times the bandwidth: a shaft with a lower resonance is a structural mode within the excited band
FRAME_S, PULSE_STEPS = 0.02, 1000  # pulses of 1 to 2 ms, to a microsecond, for 90 degrees
PULSE_RANGE_DEG = 90.0


@dataclass
class Drawn:
    """A drive with its sensor; `inherent`: effects of the library that the healthy drive has; `outside`: features that no effect describes; `effects`
    that occur in such hardware; whether its load `coasts` through a play; the bus: set points every `bus_s`, interpolated linearly if `interpolated`."""

    name: str
    plant: Rig
    bandwidth_hz: float
    amplitude_deg: float
    highest_hz: float
    bus_s: float
    interpolated: bool
    sensor: drive_sensors.Sensor
    inherent: tuple
    outside: tuple
    effects: tuple
    coasts: bool


def draw(rng, name):
    build, amplitudes, bandwidths, sensors, effects = RIGS[name]
    amplitude, bandwidth = logarithmic(rng, amplitudes), logarithmic(rng, bandwidths)
    w = 2.0 * np.pi * bandwidth
    values, there, outside = build(rng, w, amplitude)
    bus_s, interpolated = 0.0, name == "linear"
    if name in ("pwm", "linear"):
        bus_s = FRAME_S if name == "pwm" else float(rng.choice([0.004, 0.006, 0.008, 0.01]))
    plant = NEUTRAL._replace(**{key: float(value) for key, value in values.items()})
    sensor = drive_sensors.draw(rng, str(rng.choice(sensors)), amplitude, bandwidth)
    rings = ("structural_mode",) if plant.structure >= HARMONIC and plant.shaft < NEAR * w else ()
    inherent = (*there, *rings, *drive_sensors.inherent(sensor, bool(bus_s)))
    error = ("angle_error",) if sensor.error else ()
    return Drawn(name, plant, bandwidth, amplitude, HIGHEST * bandwidth, bus_s, interpolated, sensor, inherent, (*outside, *error), effects,
                 bool(plant.structure >= HARMONIC and plant.drag < w))  # fmt: skip


def hertz(rng, low, high):
    return 2.0 * np.pi * rng.uniform(low, high)


def steps(milliseconds):
    """Steps of a control period; `move` uses twice as many where the steps are fine."""
    return round(milliseconds * 1e-3 / STEP_S)


def cylinder(rng, w, amplitude):
    oil = max(hertz(rng, 35.0, 80.0), 4.5 * w)
    return {"period": steps(1.0), "kp": w * rng.uniform(0.9, 1.1), "oil": oil, "leak": oil * rng.uniform(0.2, 0.5), "viscous": oil * rng.uniform(0.1, 0.3),
            "coulomb": amplitude * w**2 * rng.uniform(0.002, 0.02), "stribeck": rng.uniform(0.1, 0.5), "stribeck_speed": 0.03 * amplitude * w}  # fmt: skip


def eha(rng, w, amplitude):
    pump = {"lag": 1.0 / (w * rng.uniform(5.0, 10.0)), "ki": w**2 * rng.uniform(0.0, 0.04), "integral_limit": 0.2 * w * amplitude}
    return {"structure": EHA, **cylinder(rng, w, amplitude), **pump}, ("coulomb_friction",), ("stribeck",)


def spool(rng, w, amplitude):
    rest = cylinder(rng, w, amplitude)
    lap, over = amplitude * rng.uniform(0.001, 0.006), rng.random() < 0.5
    supply = amplitude * w * rng.uniform(3.0, 6.0)
    valve = {"valve": hertz(rng, 60.0, 140.0), "valve_zeta": rng.uniform(0.6, 0.95), "overlap" if over else "underlap": rest["kp"] * lap, "supply": supply}
    there = ("coulomb_friction", *(("dead_zone",) if over else ()))
    return {"structure": SPOOL, **rest, **valve}, there, ("square_root_flow", "stribeck", *(() if over else ("underlap",)))


def piezo(rng, w, amplitude):
    resonance, zeta = w * rng.uniform(18.0, 30.0), rng.uniform(0.05, 0.1)
    stage = {
        "resonance": resonance,
        "zeta": zeta,
        "lag": rng.uniform(0.0003, 0.001),
        "share": rng.uniform(0.08, 0.16),
        "reach": amplitude * rng.uniform(0.5, 1.2),
    }
    windup = amplitude * rng.uniform(1.4, 1.8)
    return {"structure": PIEZO, "period": steps(0.2), "ki": w, "lowest": -windup, "highest": windup, **stage}, (), ("hysteresis",)


def cascade(rng, w, amplitude):
    """Speed loop about a current loop, and a position loop about both."""
    kv = w * rng.uniform(4.0, 6.5)
    return {"period": steps(1.0), "kp": w, "kv": kv, "ki": kv**2 * rng.uniform(0.01, 0.05), "integral_limit": 0.5 * kv * w * amplitude,
            "lag": rng.uniform(0.0004, 0.001)}  # fmt: skip


def linear(rng, w, amplitude):
    cogging = {"cogging": amplitude * w**2 * rng.uniform(0.005, 0.05), "pitch": amplitude * rng.uniform(0.3, 1.2)}
    guide = {
        "viscous": w * rng.uniform(0.05, 0.3),
        "coulomb": amplitude * w**2 * rng.uniform(0.0, 0.01),
        "feed_forward": rng.choice([0.0, rng.uniform(0.2, 0.6)]),
    }
    return {"structure": LINEAR, **cascade(rng, w, amplitude), **cogging, **guide}, ("coulomb_friction",), ("cogging",)


def shaft(rng, w, ratio, stiffness, drag):
    """Load over motor inertia, resonance of the load at a locked motor over the bandwidth, drag of the load over the bandwidth."""
    return {"ratio": rng.uniform(*ratio), "shaft": w * rng.uniform(*stiffness), "zeta": rng.uniform(0.03, 0.1), "drag": w * logarithmic(rng, drag)}


def harmonic(rng, w, amplitude):
    link = shaft(rng, w, (0.2, 0.7), (7.0, 12.0), (0.1, 1.5))
    gear_ratio, reach = rng.choice([50.0, 80.0, 100.0, 120.0, 160.0]), amplitude * (w / link["shaft"]) ** 2 * rng.uniform(0.2, 0.8)
    gear = {"kinematic": rng.uniform(0.004, 0.02), "kinematic_per_deg": 2.0 * gear_ratio * np.pi / 180.0, "share": rng.uniform(0.1, 0.3), "reach": reach}
    wave_generator = {"viscous": w * rng.uniform(0.1, 0.5), "coulomb": amplitude * w**2 * rng.uniform(0.01, 0.06)}
    loops = cascade(rng, w, amplitude) | {"feed_forward": rng.choice([0.0, rng.uniform(0.2, 0.5)])}
    return {"structure": HARMONIC, **loops, **link, **gear, **wave_generator}, ("coulomb_friction",), ("kinematic_error", "hysteresis")


def cable(rng, w, amplitude):
    tendon = shaft(rng, w, (0.2, 0.6), (6.0, 10.0), (0.3, 2.0))
    tendon["pretension"] = amplitude * (w / tendon["shaft"]) ** 2 * rng.uniform(1.5, 4.0)
    pulleys = {"viscous": w * rng.uniform(0.1, 0.4), "coulomb": amplitude * w**2 * rng.uniform(0.01, 0.05), "stribeck": rng.uniform(0.2, 0.6),
               "stribeck_speed": amplitude * w * rng.uniform(0.01, 0.04)}  # fmt: skip
    return {"structure": CABLE, **cascade(rng, w, amplitude), **tendon, **pulleys}, ("coulomb_friction",), ("stribeck",)


def pwm(rng, w, amplitude):
    zeta, horn = rng.uniform(0.65, 1.0), shaft(rng, w, (0.1, 0.35), (7.0, 12.0), (0.2, 3.0))
    lag, hurried = 1.0 / (2.0 * zeta * w), rng.random() < 0.5
    kp = w**2 * lag
    rate = amplitude * kp * (rng.uniform(0.8, 1.2) if hurried else rng.uniform(2.5, 3.0))
    servo = {"period": steps(rng.choice([1.0, 2.0])), "kp": kp, "lag": lag, "rate": rate, "half_width": amplitude * rng.uniform(0.002, 0.008),
             "coulomb": amplitude * w**2 * rng.uniform(0.002, 0.01)}  # fmt: skip
    there = ("dead_zone", "coulomb_friction", *(("rate_limit",) if hurried else ()))
    return {"structure": PWM, **servo, **horn}, there, ("pulse_steps",)


def worm(rng, w, amplitude):
    zeta, wheel = rng.uniform(0.75, 1.1), shaft(rng, w, (0.1, 0.3), (9.0, 15.0), (0.5, 4.0))
    lag = rng.uniform(1.3, 1.8) / (2.0 * zeta * w)  # of the motor alone; the loop's speed term adds the rest
    kp = w**2 * lag
    motor = {"period": steps(rng.choice([1.0, 2.0])), "kp": kp, "kd": 2.0 * zeta * w * lag - 1.0, "lag": lag, "rate": 3.5 * amplitude * kp}
    gear = {"coulomb": amplitude * w**2 * rng.uniform(0.01, 0.04), "locking": rng.uniform(1.05, 1.4)}
    return {"structure": WORM, **motor, **gear, **wheel}, ("coulomb_friction",), ("self_locking",)


# Draws for each drive: amplitude, bandwidth in Hz, sensors, effects of its hardware.
RIGS = {
    "eha": (eha, (2.0, 15.0), (1.5, 5.0), ("lvdt", "potentiometer"), ("rate_limit", "backlash", "coulomb_friction", "acceleration_limit", "position_limit")),
    "spool": (spool, (1.0, 10.0), (2.0, 7.0), ("lvdt", "resolver"), ("dead_zone", "rate_limit", "backlash", "position_limit", "coulomb_friction")),
    "piezo": (piezo, (0.05, 0.5), (2.0, 8.0), ("capacitive",), ("rate_limit", "position_limit", "structural_mode")),
    "linear": (linear, (1.0, 20.0), (3.0, 9.0), ("encoder",),
               ("acceleration_limit", "structural_mode", "coulomb_friction", "rate_limit", "position_limit")),
    "harmonic": (harmonic, (5.0, 40.0), (1.5, 5.0), ("resolver", "encoder"),
                 ("rate_limit", "amplitude_gain", "coulomb_friction", "acceleration_limit", "position_limit")),
    "cable": (cable, (3.0, 25.0), (1.5, 5.0), ("resolver", "encoder"), ("backlash", "coulomb_friction", "rate_limit", "amplitude_gain", "acceleration_limit")),
    "pwm": (pwm, (5.0, 30.0), (1.5, 4.5), ("potentiometer",), ("backlash", "rate_limit", "dead_zone", "coulomb_friction", "position_limit")),
    "worm": (worm, (3.0, 20.0), (1.0, 3.5), ("potentiometer", "encoder"), ("backlash", "rate_limit", "coulomb_friction", "dead_zone", "position_limit")),
}  # fmt: skip


def on_a_day(rng, drawn):
    """The plant of a session."""
    change = np.clip(FRICTION_CHANGE * rng.standard_normal(), -MOST_CHANGE, MOST_CHANGE)
    return drawn.plant._replace(coulomb=drawn.plant.coulomb * (1.0 + change))


def step_s(rate_hz):
    return FINE_STEP_S if rate_hz > 1000 else STEP_S


def set_points(drawn, reference, h, phase):
    """Output of the bus, whose cycle began `phase` of a cycle ago."""
    if not drawn.bus_s:
        return reference
    cycle = round(drawn.bus_s / h)
    number = (np.arange(len(reference)) + int(phase * cycle)) // cycle
    latched = reference[np.clip(number * cycle - int(phase * cycle), 0, None)]
    if not drawn.interpolated:
        pulse = PULSE_RANGE_DEG / PULSE_STEPS
        return pulse * np.round(latched / pulse)
    within = ((np.arange(len(reference)) + int(phase * cycle)) % cycle) / cycle
    before = np.r_[np.full(cycle, reference[0]), latched[:-cycle]]
    return before + within * (latched - before)


def move(plant, reference, h, at=None):
    """The position at the sensor at the ends of the steps of the reference: that of the load, if there is one."""
    phi, held, rising = propagators(*linear_part(plant), h)
    at = at if at is not None else 2 if plant.structure >= HARMONIC else 0
    plant = plant._replace(period=plant.period * round(STEP_S / h))
    seen = march(plant, phi, held, rising, np.ascontiguousarray(reference), h, at)
    if not np.abs(seen).max() < UNSTABLE * max(np.abs(reference).max(), 1e-9):
        raise FloatingPointError("the drive is unstable")
    return seen
