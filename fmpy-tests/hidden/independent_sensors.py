"""Sensor and logger of one of the six rigs: filter, gain, offset, noise, quantiser, clock.

    filter   Bessel of order 4 ahead of the sampler, or none        noise   white, coloured (a first-order low-pass), or of a coarse quantiser
    gain     error up to 3 %; offset, redrawn for each record       clock   recorded jitter, arbitrary first instant
    logger   command recorded a sample early or late; the rig itself may be a sample or two late
"""

from dataclasses import dataclass

import numpy as np
from scipy import signal

from .independent_equations import STEP_S
from .wide import logarithmic

RATES_HZ = (100, 125, 200, 250, 400, 500, 1000)
SAMPLES_PER_BANDWIDTH = 22.0
NOISE_SHARE = (0.0005, 0.005)  # of the amplitude
JITTER, MOST_JITTER = 0.01, 0.2  # of a sampling period; rms and largest
FULL_SCALE, BITS = 5.0, (9, 12)  # of a quantiser, over the amplitude
CORNER = 0.25  # corner of coloured noise over the Nyquist frequency
TIME_DIGITS = 6


@dataclass
class Sensor:
    rate_hz: int
    noise_rms: float
    colour: str
    step: float
    bessel_hz: float
    gain: float
    offset: float
    offset_spread: float  # rms, from record to record
    late_samples: int  # of the rig behind its command
    logged_late: int  # samples, of the command in the record
    jitter: float
    start_s: float
    digits: int  # digits recorded, of command and position


def draw(rng, amplitude, bandwidth_hz):
    rate = int(rng.choice([rate for rate in RATES_HZ if rate >= max(RATES_HZ[0], SAMPLES_PER_BANDWIDTH * bandwidth_hz)]))
    noise_rms, step = amplitude * logarithmic(rng, NOISE_SHARE), 0.0
    colour = str(rng.choice(["white", "coloured", "quantised"]))
    if colour == "quantised":
        step = float(amplitude * FULL_SCALE / 2.0 ** int(rng.integers(BITS[0], BITS[1] + 1)))
        noise_rms = float(min(noise_rms, step * rng.uniform(0.2, 0.8)))

    def sometimes(share, low, high):
        return float(rng.uniform(low, high)) if rng.random() < share else 0.0

    return Sensor(
        rate, noise_rms, colour, step, rate * sometimes(0.5, 0.15, 0.4), 1.0 + sometimes(0.5, -0.03, 0.03), amplitude * sometimes(0.5, -0.02, 0.02),
        amplitude * sometimes(0.35, 0.0003, 0.003), int(rng.choice([0, 0, 1, 2])), int(rng.choice([0, 0, 0, -1, 1])),
        JITTER if rng.random() < 0.35 else 0.0, round(sometimes(0.4, 5.0, 4000.0), 2),
        int(max(rng.integers(3, 6), np.ceil(-np.log10(amplitude * 2e-4)))),
    )  # fmt: skip


def inherent(sensor):
    """Effects of the library that the sensor and the logger have. The group delay of a Bessel filter is flat up to its corner: a delay, and a lag beside it."""
    there = {"quantisation": sensor.step > 0.0, "sensor_bias": sensor.offset != 0.0 or sensor.offset_spread > 0.0,
             "sensor_lag": sensor.bessel_hz > 0.0, "delay": sensor.bessel_hz > 0.0 or sensor.late_samples > sensor.logged_late}  # fmt: skip
    return tuple(name for name, acts in there.items() if acts)


def record(rng, sensor, command, seen, gain_drift=0.0):
    """Columns of one record: `command` at the samples, `seen` (the position at the sensor) at the ends of the steps of the rig."""
    count = len(command)
    time = np.arange(count) / sensor.rate_hz
    if sensor.bessel_hz:
        seen = signal.sosfilt(signal.bessel(4, sensor.bessel_hz, fs=1.0 / STEP_S, norm="mag", output="sos"), seen)
    if sensor.jitter:
        period = 1.0 / sensor.rate_hz
        time += np.clip(rng.normal(0.0, sensor.jitter * period, count), -MOST_JITTER * period, MOST_JITTER * period)
        time[0] = 0.0
    position = sensor.gain * np.interp(time, STEP_S * np.arange(len(seen)), seen) * (1.0 + gain_drift * time) + sensor.offset
    if sensor.offset_spread:
        position += rng.normal(0.0, sensor.offset_spread)
    position += sensor.noise_rms * noise(rng, sensor.colour, count)
    if sensor.step:
        position = sensor.step * np.round(position / sensor.step)
    late = sensor.logged_late
    logged = np.r_[command[:1], command[:-1]] if late > 0 else np.r_[command[1:], command[-1:]] if late < 0 else command
    columns = {"time": np.round(time + sensor.start_s, TIME_DIGITS)}
    return columns | {"command": np.round(logged, sensor.digits), "position": np.round(position, sensor.digits)}


def noise(rng, colour, count):
    white = rng.normal(0.0, 1.0, count)
    if colour != "coloured":
        return white
    low = signal.lfilter(*signal.butter(1, CORNER), white)
    return low / low.std()
