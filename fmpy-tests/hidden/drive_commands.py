"""Commands for the eight drives of `drive_rigs.py`, of unit size, around the bandwidth of the drive.

    manoeuvres   3-2-1-1 and doublets, as in flight tests            staircase   up and down in equal steps
    chirp        up to the highest frequency and back                bursts      single sines of several frequencies and amplitudes
    multisine    Schroeder's phases, flat                            noise       filtered, with varying amplitude
    pilot        slow targets, corrections, pauses

All except the multisine begin and end at rest.
"""

import numpy as np
from scipy import signal

from . import motions

REST_S = 0.4
LINES = 24
AMPLITUDES = (0.15, 0.3, 0.6, 1.0)


def command(rng, kind, time, bandwidth_hz):
    wave = COMMANDS[kind](rng, time, bandwidth_hz)
    if kind != "multisine":
        wave = np.where((time < REST_S) | (time > time[-1] - REST_S), 0.0, wave)
    wave = wave - wave[0]
    return wave / np.abs(wave).max()


def manoeuvres(rng, t, bandwidth_hz):
    wave, start = np.zeros(len(t)), REST_S
    while start < t[-1]:
        unit, size = rng.uniform(0.3, 1.0) / bandwidth_hz, rng.choice(AMPLITUDES[1:]) * rng.choice([-1.0, 1.0])
        for length, sign in ((3, 1), (2, -1), (1, 1), (1, -1)) if rng.random() < 0.5 else ((1, 1), (1, -1)):
            wave[(t >= start) & (t < start + length * unit)] = sign * size
            start += length * unit
        start += rng.uniform(1.0, 3.0) / bandwidth_hz
    return wave


def chirp(rng, t, bandwidth_hz):
    half, lowest, highest = 0.5 * t[-1], rng.uniform(0.05, 0.12) * bandwidth_hz, rng.uniform(1.0, 1.4) * bandwidth_hz
    return signal.chirp(half - np.abs(t - half), lowest, half, highest, "quadratic", phi=-90)


def multisine(rng, t, bandwidth_hz):
    """Schroeder: phase -pi n^2/N of line n of N; lines of a period of half the record, which begins where the signal is closest to 0."""
    spacing = 2.0 / t[-1]
    harmonics = np.unique(np.round(np.linspace(0.1, rng.uniform(0.9, 1.3), LINES) * bandwidth_hz / spacing).clip(1.0))
    wave = sum(np.cos(2.0 * np.pi * n * spacing * t - np.pi * k**2 / len(harmonics)) for k, n in enumerate(harmonics))
    return np.roll(wave, -np.argmin(np.abs(wave[: len(wave) // 2])))


def staircase(rng, t, bandwidth_hz):
    count = int(rng.integers(2, 6))
    up = np.arange(1, count + 1) / count
    once = np.r_[up, up[-2::-1], 0.0, -up, -up[-2::-1], 0.0]
    return motions.levels(rng, t, 1.5 / bandwidth_hz, 4.0 / bandwidth_hz, np.r_[0.0, np.tile(once, 200)])


def bursts(rng, t, bandwidth_hz):
    wave, start = np.zeros(len(t)), REST_S
    while start < t[-1]:
        frequency, size = bandwidth_hz * np.exp(rng.uniform(np.log(0.1), np.log(1.2))), rng.choice(AMPLITUDES)
        length = int(rng.integers(2, 6)) / frequency
        inside = (t >= start) & (t < start + length)
        wave[inside] = size * np.sin(2.0 * np.pi * frequency * (t[inside] - start))
        start += length + rng.uniform(0.3, 1.5) / bandwidth_hz
    return wave


def noise(rng, t, bandwidth_hz):
    wave = motions.band_limited(rng, len(t), None, rng.uniform(0.4, 0.9) * bandwidth_hz, (len(t) - 1) / t[-1])
    swell = 0.6 + 0.4 * np.sin(2.0 * np.pi * rng.uniform(1.0, 3.0) * t / t[-1])
    return np.clip(wave * swell, -2.0, 2.0)


def pilot(rng, t, bandwidth_hz):
    """Targets that are approached in a ramp, held with small corrections, and left again."""
    corners, heights = [REST_S], [0.0]
    while corners[-1] < t[-1]:
        corners += list(corners[-1] + np.cumsum(rng.uniform([0.3, 1.0], [1.5, 4.0]) / bandwidth_hz))
        heights += 2 * [rng.uniform(-1.0, 1.0)]
    corrections = motions.band_limited(rng, len(t), None, 0.5 * bandwidth_hz, (len(t) - 1) / t[-1])
    return np.interp(t, corners, heights) + 0.12 * corrections * (np.sin(2.0 * np.pi * 4.0 * t / t[-1]) > 0.0)


COMMANDS = {"manoeuvres": manoeuvres, "chirp": chirp, "multisine": multisine, "staircase": staircase, "bursts": bursts, "noise": noise, "pilot": pilot}
EVEN = ("chirp", "multisine", "noise", "bursts")  # move the drive all the time: a model can be fitted to one
