"""Commands for the six rigs of `independent_rigs.py`, of unit size, in a band around the bandwidth of the rig.

    steps, doublets, triangles    random levels; up, down, rest, smoothed by a filter; straight lines back and forth
    multisine, chirp, random      a third of the bandwidth to 1.4 times of it, noise with its rare peaks clipped
    mixed                         bursts of sines, pairs of steps and swells, with rests between

All except the multisine begin at rest.
"""

import numpy as np
from scipy import signal

from . import motions

REST_S, SHORT_REST_S = 0.7, 0.1
LEVELS = (-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0)
LINES = 14
DIGITS = 5


def command(rng, kind, time, bandwidth_hz):
    wave = COMMANDS[kind](rng, time, bandwidth_hz)
    if kind != "multisine":
        wave = np.where(time < SHORT_REST_S, 0.0, wave)
    wave[0] = 0.0
    return wave


def steps(rng, t, bandwidth_hz):
    held = motions.levels(rng, t, 2.0 / bandwidth_hz, 6.0 / bandwidth_hz, rng.choice(LEVELS, 4000))
    return np.where((t < REST_S) | (t > t[-1] - 0.5 * REST_S), 0.0, held)


def multisine(rng, t, bandwidth_hz):
    """Geometrically spaced lines with amplitudes that decrease with frequency; the period is the record."""
    count = np.unique(np.round(t[-1] * np.geomspace(0.08 * bandwidth_hz, 1.3 * bandwidth_hz, LINES)).clip(1.0))
    phases = rng.uniform(0.0, 2.0 * np.pi, len(count))
    wave = sum(np.sin(2.0 * np.pi * n * t / t[-1] + phase) / (1.0 + 2.0 * n / (t[-1] * bandwidth_hz)) for n, phase in zip(count, phases))
    return wave / np.abs(wave).max()


def chirp(rng, t, bandwidth_hz):
    method = str(rng.choice(["linear", "logarithmic"]))
    return signal.chirp(t, 0.08 * bandwidth_hz, t[-1], 1.4 * bandwidth_hz, method=method, phi=-90)


def random(rng, t, bandwidth_hz):
    wave = motions.band_limited(rng, len(t), None, 0.7 * bandwidth_hz, (len(t) - 1) / t[-1])
    return np.clip(wave / 2.5, -1.0, 1.0)


def doublets(rng, t, bandwidth_hz):
    wave, start = np.zeros(len(t)), REST_S
    while start < t[-1]:
        length, size = rng.uniform(0.5, 2.0) / bandwidth_hz, rng.choice([0.4, 0.7, 1.0]) * rng.choice([-1.0, 1.0])
        wave[(t >= start) & (t < start + length)] = size
        wave[(t >= start + length) & (t < start + 2.0 * length)] = -size
        start += 2.0 * length + rng.uniform(1.0, 4.0) / bandwidth_hz
    rate = (len(t) - 1) / t[-1]
    return signal.sosfilt(signal.butter(1, min(0.45 * rate, 3.0 * bandwidth_hz), fs=rate, output="sos"), wave)


def triangles(rng, t, bandwidth_hz):
    corners, heights = [REST_S], [0.0]
    while corners[-1] < t[-1]:
        period, size = rng.uniform(3.0, 12.0) / bandwidth_hz, rng.choice([0.35, 0.7, 1.0])
        corners += [corners[-1] + period * share for share in (0.25, 0.75, 1.0)]
        heights += [size, -size, 0.0]
    return np.interp(t, corners, heights)


def mixed(rng, t, bandwidth_hz):
    wave, start = np.zeros(len(t)), REST_S
    while start < t[-1]:
        length, size, kind = rng.uniform(6.0, 15.0) / bandwidth_hz, rng.choice([0.3, 0.6, 1.0]), rng.integers(3)
        inside = (t >= start) & (t < start + length)
        local = t[inside] - start
        if kind == 0:
            wave[inside] = size * np.sin(2.0 * np.pi * rng.uniform(0.15, 1.0) * bandwidth_hz * local)
        elif kind == 1:
            wave[inside] = size * np.where(local < 0.5 * length, 1.0, -0.5)
        else:
            wave[inside] = size * np.sin(2.0 * np.pi * 0.3 * bandwidth_hz * local) * np.sin(np.pi * local / length)
        start += length + rng.uniform(1.0, 3.0) / bandwidth_hz
    return wave


COMMANDS = {"steps": steps, "multisine": multisine, "chirp": chirp, "random": random, "doublets": doublets, "triangles": triangles, "mixed": mixed}
EVEN = ("chirp", "multisine", "random", "mixed")  # move the rig all the time: a model can be fitted to one
