"""Position sensors and loggers of the eight drives.

    potentiometer   conformity error over its travel, RC filter, contact noise that is larger while the wiper moves, ADC
    resolver        error once or twice a revolution, ADC            lvdt          demodulation filter (Butterworth, order 2), ADC
    encoder         counts, or a fraction of them                    capacitive    one-pole filter, ADC, noise of low frequency

The logger has a separate clock, in error by some parts in 10^4, with recorded jitter; it may lose rows; it records the command ahead of
the bus (early) or behind it (late). Offset and gain change from session to session, the gain with the temperature.
"""

from dataclasses import dataclass

import numpy as np
from scipy import signal

from . import motions
from .wide import logarithmic

RATES_HZ = (50, 100, 125, 200, 250, 500, 1000, 2000)
SAMPLES_PER_BANDWIDTH = 20.0
NOISE_SHARE = (0.0004, 0.004)  # of the amplitude
WIPER = 3.0  # ratio of the contact noise at full speed to that at rest
FULL_SCALE = 3.0  # of an ADC and of a potentiometer, over the amplitude
BITS = {"potentiometer": (10, 13), "resolver": (12, 15), "lvdt": (12, 15), "capacitive": (14, 17)}
COUNTS = (400.0, 8000.0)  # of an encoder, over the amplitude
JITTER, MOST_JITTER = 0.02, 0.3  # of a sampling period; rms and largest
TIME_DIGITS = 7
ORDERS = {"potentiometer": 1, "resolver": 0, "lvdt": 2, "encoder": 0, "capacitive": 1}


@dataclass
class Sensor:
    kind: str
    rate_hz: int
    noise_rms: float
    colour: dict
    step: float
    filter_hz: float
    error: float  # of angle, largest
    error_per_deg: float  # its phase over the position
    gain: float
    offset: float
    session_gain: float  # rms
    session_offset: float  # rms
    logged_late: int  # samples, of the command in the record
    clock: float  # recorded seconds per second
    jitter: float
    lost: float  # share of rows
    start_s: float
    digits: int  # digits recorded, of command and position


def draw(rng, kind, amplitude, bandwidth_hz):
    rate = int(rng.choice([rate for rate in RATES_HZ if rate >= SAMPLES_PER_BANDWIDTH * bandwidth_hz]))
    noise_rms = amplitude * logarithmic(rng, NOISE_SHARE)

    def sometimes(share, low, high):
        return float(rng.uniform(low, high)) if rng.random() < share else 0.0

    if kind == "encoder":
        step = amplitude / logarithmic(rng, COUNTS)
        noise_rms = min(noise_rms, step * rng.uniform(0.1, 0.5))
    else:
        step = 2.0 * FULL_SCALE * amplitude / 2.0 ** int(rng.integers(*BITS[kind]))
    error, per_deg = {
        "potentiometer": (amplitude * rng.uniform(0.001, 0.006), np.pi / (FULL_SCALE * amplitude)),
        "resolver": (rng.uniform(0.02, 0.12), rng.choice([1.0, 2.0]) * np.pi / 180.0),
    }.get(kind, (0.0, 0.0))
    colour = {"kind": "ar1", "memory": float(rng.uniform(0.5, 0.95))} if kind == "capacitive" or rng.random() < 0.25 else {"kind": "white"}
    filter_hz = max(bandwidth_hz * 12.0, rng.uniform(0.25, 0.45) * rate) if ORDERS[kind] else 0.0
    return Sensor(
        kind, rate, float(noise_rms), colour, float(step), float(filter_hz), float(error), float(per_deg), 1.0 + sometimes(0.5, -0.02, 0.02),
        amplitude * sometimes(0.5, -0.02, 0.02), sometimes(0.7, 0.002, 0.008), amplitude * sometimes(0.6, 0.001, 0.005),
        int(rng.choice([0, 0, 0, -1, 1])), 1.0 + sometimes(0.4, -3e-4, 3e-4), JITTER if rng.random() < 0.3 else 0.0, sometimes(0.25, 0.001, 0.01),
        round(sometimes(0.4, 3.0, 900.0), 2), int(max(4, np.ceil(-np.log10(amplitude * 1e-4)))),
    )  # fmt: skip


def inherent(sensor, is_late):
    """Effects of the library that sensor and logger have, on a drive with or without a delay. A filter is a lag, and equivalent to a delay far
    below its corner; an early recorded command makes the drive appear late."""
    there = {"quantisation": sensor.step > 0.0, "sensor_bias": sensor.offset != 0.0 or sensor.session_offset > 0.0,
             "sensor_lag": sensor.filter_hz > 0.0, "delay": is_late or sensor.filter_hz > 0.0 or sensor.logged_late < 0}  # fmt: skip
    return tuple(name for name, acts in there.items() if acts)


def record(rng, sensor, command, seen, h, effect=None):
    """Columns of one record: `command` at the samples, `seen` at the ends of the steps h of the drive, `effect` of the sensor."""
    name, values = effect or ("", {})
    count = len(command)
    held = np.arange(count) / sensor.rate_hz  # instants at which the command changes
    gain, offset = 1.0 + sensor.session_gain * rng.standard_normal(), sensor.session_offset * rng.standard_normal()
    angle = seen + sensor.error * (np.sin(sensor.error_per_deg * seen + 1.0) - np.sin(1.0))
    if sensor.filter_hz:
        angle = signal.sosfilt(signal.butter(ORDERS[sensor.kind], sensor.filter_hz, fs=1.0 / h, output="sos"), angle)
    if name == "sensor_lag":
        angle = signal.lfilter([decay := -np.expm1(-h / values["time"])], [1.0, decay - 1.0], angle)
    period = 1.0 / sensor.rate_hz
    time = held + np.clip(sensor.jitter * rng.standard_normal(count), -MOST_JITTER, MOST_JITTER) * period
    time[0] = 0.0
    noise = sensor.noise_rms * motions.noise(rng, sensor.colour, count)
    if sensor.kind == "potentiometer":
        speed = np.abs(np.gradient(np.interp(time, h * np.arange(len(angle)), angle)))
        noise *= 1.0 + (WIPER - 1.0) * speed / max(speed.max(), 1e-12)
    kept = rng.random(count) >= sensor.lost
    kept[[0, -1]] = True
    position = sensor.gain * gain * np.interp(time, h * np.arange(1, len(angle) + 1), angle, left=0.0)
    position = position * (1.0 + values["rate"] * time if name == "gain_drift" else 1.0) + sensor.offset + offset
    position += (values["drift"] * time if name == "sensor_bias" else 0.0) + noise
    step = max(sensor.step, values["step"]) if name == "quantisation" else sensor.step
    if step:
        position = step * np.round(position / step)
    late = sensor.logged_late
    logged = np.r_[command[:1], command[:-1]] if late > 0 else np.r_[command[1:], command[-1:]] if late < 0 else command
    # A command that is sampled too early because of clock jitter is still the previous one.
    logged = logged[np.clip(np.floor(time * sensor.rate_hz + 1e-6).astype(int), 0, count - 1)]
    rows = {"time": np.round(sensor.clock * time + sensor.start_s, TIME_DIGITS), "command": np.round(logged, sensor.digits)}
    rows["position"] = np.round(position, sensor.digits)
    return {key: values[kept] for key, values in rows.items()}
