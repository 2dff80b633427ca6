"""Typical commands of users, at any sampling rate, within a given band; and noise of any colour.

    sweep, random_steps, multisine      system identification
    sin_sin                             a sine whose amplitude is another sine
    sin_time_square                     a sine of the square of time: slow first, fast at the end
    up_and_down                         ramps between rests
    triangle, staircase, noise_band     slow reversals, levels in order, filtered noise
"""

import numpy as np
from scipy import signal

SLOWEST_SHARE = 0.04  # start frequency of sweeps over the highest frequency
TAPER_SHARE = 0.05  # of the record: commands of kinds without jumps also begin and end without one
MOST_OF_NYQUIST = 0.8


def command(rng, kind, time, highest_hz):
    """A command with largest value 1, with content up to about `highest_hz`, that begins at 0."""
    local = time - time[0]
    wave = MOTIONS[kind](rng, local, highest_hz)
    if kind not in ("random_steps", "up_and_down", "staircase"):
        wave = wave * np.clip(local / (TAPER_SHARE * local[-1]), 0.0, 1.0)
    wave[0] = 0.0
    return wave / np.abs(wave).max()


def sweep(_, t, highest_hz):
    lowest = SLOWEST_SHARE * highest_hz
    return np.sin(2.0 * np.pi * (lowest + 0.5 * (highest_hz - lowest) * t / t[-1]) * t)


def random_steps(rng, t, highest_hz):
    """Random levels, held for one to eight times the shortest half period."""
    return levels(rng, t, 0.5 / highest_hz * 2.0, 0.5 / highest_hz * 16.0, rng.uniform(-1.0, 1.0, 4000))


def staircase(rng, t, highest_hz):
    count = int(rng.integers(3, 8))
    heights = np.r_[np.arange(count), np.arange(count)[::-1]] / count - rng.uniform(0.0, 0.5)
    return levels(rng, t, 2.0 / highest_hz, 6.0 / highest_hz, np.r_[0.0, np.tile(heights, 400)])


def multisine(rng, t, highest_hz):
    """Odd harmonics of a period of a third of the record, with random phases."""
    lines = np.arange(1, int(highest_hz * t[-1] / 3.0), 2) * 3.0 / t[-1]
    lines = rng.choice(lines, min(len(lines), 40), replace=False)
    phases = rng.uniform(0.0, 2.0 * np.pi, len(lines))
    return sum(np.sin(2.0 * np.pi * line * t + phase) for line, phase in zip(lines, phases))


def sin_sin(rng, t, highest_hz):
    carrier = highest_hz * rng.uniform(0.15, 0.5)
    return np.sin(2.0 * np.pi * carrier * t) * np.sin(2.0 * np.pi * rng.uniform(0.05, 0.15) * carrier * t)


def sin_time_square(_, t, highest_hz):
    return np.sin(np.pi * highest_hz * t**2 / t[-1])


def up_and_down(rng, t, highest_hz):
    """Ramps to a level and back, rests between; some ramps fast, some slow."""
    corners, heights = [0.0], [0.0]
    while corners[-1] < t[-1]:
        height, ramp, rest = rng.uniform(0.3, 1.0) * rng.choice([-1.0, 1.0]), rng.uniform(0.7, 6.0) / highest_hz, rng.uniform(0.5, 4.0) / highest_hz
        corners += list(corners[-1] + np.cumsum([ramp, rest, ramp, rest]))
        heights += [height, height, 0.0, 0.0]
    return np.interp(t, corners, heights)


def triangle(rng, t, highest_hz):
    corners = np.cumsum(np.r_[0.0, rng.uniform(0.7, 8.0, 4000) / highest_hz])
    return np.interp(t, corners, np.r_[0.0, rng.uniform(0.3, 1.0, 4000) * np.tile([1.0, -1.0], 2000)])


def noise_band(rng, t, highest_hz):
    rate = (len(t) - 1) / t[-1]
    return band_limited(rng, len(t), None, min(0.7 * highest_hz, 0.5 * MOST_OF_NYQUIST * rate), rate)


MOTIONS = {"sweep": sweep, "random_steps": random_steps, "multisine": multisine, "sin_sin": sin_sin, "sin_time_square": sin_time_square,
           "up_and_down": up_and_down, "triangle": triangle, "staircase": staircase, "noise_band": noise_band}  # fmt: skip


def levels(rng, t, shortest_s, longest_s, values):
    """Each value held for a time between the two limits."""
    changes = np.cumsum(rng.uniform(shortest_s, longest_s, len(values) - 1))
    return values[np.searchsorted(changes, t, side="right")]


def band_limited(rng, count, lowest_hz, highest_hz, rate):
    """Normal noise of rms 1 between two frequencies (Butterworth, order 4), without the filter's transient."""
    band, kind = (highest_hz, "lowpass") if lowest_hz is None else ((lowest_hz, highest_hz), "bandpass")
    run_in = int(5.0 / min(1.0, lowest_hz or highest_hz) * rate)
    sections = signal.butter(4, band, kind, fs=rate, output="sos")
    wave = signal.sosfilt(sections, rng.standard_normal(run_in + count))[run_in:]
    return wave / wave.std()


def draw_colour(rng):
    """White in half of the draws; otherwise AR(1) or noise below a share of the sampling rate."""
    kind = rng.choice(["white", "ar1", "band"], p=[0.5, 0.25, 0.25])
    if kind == "white":
        return {"kind": "white"}
    return {"kind": "ar1", "memory": float(rng.uniform(0.6, 0.95))} if kind == "ar1" else {"kind": "band", "share_of_rate": float(rng.uniform(0.05, 0.2))}


def noise(rng, colour, count):
    """Noise of this colour with rms 1."""
    if colour["kind"] == "ar1":
        wave = signal.lfilter([1.0], [1.0, -colour["memory"]], rng.standard_normal(count + 1000))[1000:]
        return wave * np.sqrt(1.0 - colour["memory"] ** 2)
    if colour["kind"] == "band":
        return band_limited(rng, count, None, colour["share_of_rate"], 1.0)
    return rng.standard_normal(count)
