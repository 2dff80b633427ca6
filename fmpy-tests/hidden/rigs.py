"""Seven rigs with random physical parameters, and their sessions: the same rig on another day.

    pi_motor    PI position loop, first-order motor                        cascade     current, speed and position loops
    flexible    LuGre friction, flexible coupling, encoder on either side  encoder     12-bit encoder, speed by difference
    logger      `cascade` with a logger that samples asynchronously        hydraulic   valve flow by the root of the pressure
    geared      geared servo, proportional, with a pendulum

Every healthy rig has reserves: its speed and its torque saturate far above the demand of the excitation.
"""

from dataclasses import dataclass

import numpy as np

from .rig_equations import CASCADE, DIGITAL, FLEXIBLE, HYDRAULIC, MOTOR, NEUTRAL, STEP_S, Rig, march

BANDWIDTH_HZ = (2.0, 15.0)
TWELVE_BITS_DEG = 360.0 / 4096.0
RESERVE = 4.0  # saturations of a healthy rig over peak speed and acceleration of the command
SETTLING_S = 1.5  # at rest at the first command before the record begins, for gravity and friction to settle
# Session to session: standard deviations, relative except for the last two.
GAIN_CHANGE, FRICTION_CHANGE, SCALE_CHANGE = 0.03, 0.06, 0.005
OFFSET_CHANGE = 0.01  # of the amplitude
MOST_CHANGE = 0.10
LATENCY_S = (0.0, 0.25)  # relative to a closed-loop time constant, and 10 % of it from session to session


@dataclass
class Drawn:
    """A rig, the effects of the library that act in it, and its excitation."""

    name: str
    plant: Rig
    bandwidth_hz: float
    amplitude_deg: float
    highest_hz: float
    latency_s: float
    inherent: tuple  # effects of the library that physically act in the healthy rig


def draw(rng, name):
    bandwidth = float(np.exp(rng.uniform(*np.log(BANDWIDTH_HZ))))
    amplitude = float(np.exp(rng.uniform(np.log(8.0), np.log(40.0))))
    highest = bandwidth * float(rng.uniform(0.5, 1.2))
    speed = 2.0 * np.pi * highest * amplitude
    w = 2.0 * np.pi * bandwidth
    reserves = {"rate": RESERVE * speed, "acceleration": RESERVE * speed * w * 4.0}
    values, inherent = RIGS[name](rng, w, amplitude, speed)
    latency = float(rng.uniform(*LATENCY_S)) / w
    return Drawn(name, NEUTRAL._replace(**(reserves | values)), bandwidth, amplitude, highest, latency, inherent)


def pi_motor(rng, w, _, speed):
    lag = rng.uniform(0.15, 0.4) / w
    return {"structure": MOTOR, "kp": w, "ki": w**2 * rng.uniform(0.03, 0.2), "lag": lag,
            "coulomb": speed * rng.uniform(0.0, 0.01) / lag}, ()  # fmt: skip


def cascade(rng, w, _, speed):
    kv = w * rng.uniform(3.0, 7.0)
    return {"structure": CASCADE, "kp": w, "kv": kv, "kvi": kv**2 * rng.uniform(0.02, 0.1), "lag": rng.uniform(0.05, 0.2) / kv,
            "viscous": w * rng.uniform(0.1, 0.6), "coulomb": speed * w * rng.uniform(0.0, 0.03)}, ()  # fmt: skip


def flexible(rng, w, amplitude, speed):
    kv = w * rng.uniform(3.0, 6.0)
    level = speed * w * rng.uniform(0.01, 0.08)
    return {"structure": FLEXIBLE, "kp": w * 0.9, "kv": kv, "viscous": w * rng.uniform(0.05, 0.3), "ratio": rng.uniform(0.1, 0.6),
            "w": w * rng.uniform(4.0, 8.0), "z": rng.uniform(0.02, 0.08), "encoder_on_load": float(rng.random() < 0.5),
            "lugre_stiffness": level / (amplitude * rng.uniform(0.002, 0.01)), "lugre_level": level,
            "lugre_excess": rng.uniform(0.0, 0.6), "stribeck": speed * rng.uniform(0.01, 0.1)}, ("coulomb_friction",)  # fmt: skip


def encoder(rng, w, _, speed):
    period = float(rng.choice([0.001, 0.002]))
    kv = min(w * rng.uniform(2.5, 5.0), 0.25 / period)
    return {"structure": DIGITAL, "kp": min(w, kv / 2.5), "kv": kv, "viscous": w * rng.uniform(0.1, 0.5), "control_period": period,
            "encoder_step": TWELVE_BITS_DEG, "speed_filter": rng.uniform(0.1, 0.3) / kv,
            "coulomb": speed * w * rng.uniform(0.0, 0.02)}, ("quantisation",)  # fmt: skip


def hydraulic(rng, w, _, speed):
    supply = speed * w * rng.uniform(5.0, 12.0)
    return {"structure": HYDRAULIC, "kp": w, "lag": rng.uniform(0.05, 0.2) / w, "w": w * rng.uniform(4.0, 8.0), "z": rng.uniform(0.2, 0.6),
            "supply": supply, "full_speed": RESERVE * speed, "rate": RESERVE * speed, "viscous": w * rng.uniform(0.0, 0.3),
            "load": supply * rng.uniform(-0.15, 0.15), "coulomb": supply * rng.uniform(0.0, 0.02)}, ("coulomb_friction",)  # fmt: skip


def geared(rng, w, _, speed):
    lag = 1.0 / (2.0 * rng.uniform(0.6, 1.0) * w)
    gravity = speed / lag * rng.uniform(0.02, 0.15)
    return {"structure": MOTOR, "kp": w**2 * lag, "lag": lag, "gravity": gravity, "zero": rng.uniform(-20.0, 20.0),
            "coulomb": speed / lag * rng.uniform(0.005, 0.04), "load_friction": rng.uniform(0.0, 0.15)}, (
                "coulomb_friction", "hinge_load", "amplitude_gain")  # fmt: skip


RIGS = {"pi_motor": pi_motor, "cascade": cascade, "flexible": flexible, "encoder": encoder, "logger": cascade, "hydraulic": hydraulic,
        "geared": geared}  # fmt: skip


@dataclass
class Session:
    """One day: factors on gain and friction, the scale and offset of the sensor, latency."""

    gain: float
    friction: float
    scale: float
    offset_deg: float
    latency_s: float


def session(rng, drawn):
    def factor(deviation):
        return float(1.0 + np.clip(deviation * rng.standard_normal(), -MOST_CHANGE, MOST_CHANGE))

    return Session(factor(GAIN_CHANGE), factor(FRICTION_CHANGE), factor(SCALE_CHANGE), (factor(OFFSET_CHANGE) - 1.0) * drawn.amplitude_deg,
                   drawn.latency_s * factor(MOST_CHANGE))  # fmt: skip


def on_the_day(plant, day):
    return plant._replace(kp=plant.kp * day.gain, ki=plant.ki * day.gain, coulomb=plant.coulomb * day.friction,
                          lugre_level=plant.lugre_level * day.friction, load_friction=plant.load_friction * day.friction)  # fmt: skip


def fine_step(rate):
    """The longest step up to `STEP_S` that divides the sampling time."""
    return 1.0 / (rate * np.ceil(1.0 / (rate * STEP_S) - 1e-9))


def move(drawn, plant, reference, h):
    """The encoder position at the ends of the steps, and the speed, after the rig has settled at the first reference."""
    settling = int(SETTLING_S / h)
    run_in = np.full(settling, reference[0])
    _, seen, speed = march(plant, h, np.concatenate([run_in, reference]), reference[0])
    return seen[settling:], speed[settling:]
