"""Commands that move the actuator, loads and noise, all random and of unit size unless stated otherwise."""

import numpy as np
from scipy import signal

SAMPLE_TIME_S = 0.005  # 200 samples/s, as in the report
LOWEST_HZ, HIGHEST_HZ = 0.5, 12.0
QUIET_S = 1.5  # at either end, if a record begins and ends at rest
CHECKS = ("multisine", "steps", "triangles", "doublets")
COMMAND_DIGITS = 6  # digits recorded, and thus applied to the plant


def time(duration_s):
    return SAMPLE_TIME_S * np.arange(int(round(duration_s / SAMPLE_TIME_S)))


def command(rng, kind, time, peak, quiet):
    """A command of this kind whose largest value is `peak` deg."""
    wave = np.zeros(len(time))
    inside = slice(int(QUIET_S / SAMPLE_TIME_S), -int(QUIET_S / SAMPLE_TIME_S)) if quiet else slice(None)
    local = time[inside] - time[inside][0]
    wave[inside] = KINDS[kind](rng, local)
    return np.round(peak * wave / np.abs(wave).max(), COMMAND_DIGITS)


def sweep(_, t):
    """A sine whose frequency increases linearly."""
    return np.sin(2.0 * np.pi * (LOWEST_HZ + 0.5 * (HIGHEST_HZ - LOWEST_HZ) * t / t[-1]) * t)


def random_sequence(rng, t):
    """Normal noise below 6 to 14 Hz."""
    return band_limited(rng, len(t), None, rng.uniform(6.0, 14.0))


def multisine(rng, t):
    """Sines 0.2 Hz apart from 0.5 to 12 Hz with random phases."""
    frequencies = np.arange(LOWEST_HZ, HIGHEST_HZ, 0.2)
    return np.sin(2.0 * np.pi * np.outer(t, frequencies) + rng.uniform(0.0, 2.0 * np.pi, len(frequencies))).sum(1)


def steps(rng, t):
    """Random levels, each held for 0.15 to 0.8 s."""
    return _held(rng, t, 0.15, 0.8, lambda: rng.uniform(-1.0, 1.0))


def triangles(rng, t):
    """A triangle wave of 0.2 to 3 Hz with random peaks."""
    corners = np.cumsum(rng.uniform(0.15, 2.0, int(t[-1] / 0.15) + 2))
    peaks = rng.uniform(0.3, 1.0, len(corners)) * np.where(np.arange(len(corners)) % 2, 1.0, -1.0)
    return np.interp(t, np.r_[0.0, corners], np.r_[0.0, peaks])


def doublets(rng, t):
    """Up, down by the same amount, back to zero, a rest; random amplitude and length."""
    wave = np.zeros(len(t))
    start = 0.3
    while start < t[-1]:
        length, size = rng.uniform(0.08, 0.6), rng.uniform(0.25, 1.0) * rng.choice([-1.0, 1.0])
        wave += size * ((t >= start) & (t < start + length)) - size * ((t >= start + length) & (t < start + 2.0 * length))
        start += 2.0 * length + rng.uniform(0.2, 0.8)
    return wave


KINDS = {"sweep": sweep, "random": random_sequence, "multisine": multisine, "steps": steps, "triangles": triangles, "doublets": doublets}


def hinge_load(rng, t):
    """A load that drifts and jumps, as under gusts and manoeuvres; rms 1."""
    wave = band_limited(rng, len(t), None, rng.uniform(0.5, 4.0), t[1] - t[0]) + 0.7 * _held(rng, t, 0.5, 3.0, rng.standard_normal)
    return wave / wave.std()


def band_limited(rng, count, lowest_hz, highest_hz, sample_time_s=SAMPLE_TIME_S):
    """Normal noise of rms 1 between two frequencies (Butterworth, order 4), without the filter's transient."""
    band, kind = (highest_hz, "lowpass") if lowest_hz is None else ((lowest_hz, highest_hz), "bandpass")
    run_in = int(5.0 / sample_time_s)
    sections = signal.butter(4, band, kind, fs=1.0 / sample_time_s, output="sos")
    wave = signal.sosfilt(sections, rng.standard_normal(run_in + count))[run_in:]
    return wave / wave.std()


def draw_noise_kind(rng, coloured):
    """White, or coloured: AR(1), or low-passed."""
    if not coloured:
        return {"kind": "white"}
    if rng.random() < 0.5:
        return {"kind": "ar1", "memory": float(rng.uniform(0.6, 0.95))}
    return {"kind": "band", "highest_hz": float(rng.uniform(10.0, 40.0))}


def noise(rng, kind, count):
    """Noise of this kind, of expected rms 1."""
    white = rng.standard_normal(count + 1000)
    if kind["kind"] == "ar1":
        memory = kind["memory"]
        return signal.lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white)[1000:]
    if kind["kind"] == "band":
        sections = signal.butter(2, kind["highest_hz"], fs=1.0 / SAMPLE_TIME_S, output="sos")
        impulse = signal.sosfilt(sections, np.r_[1.0, np.zeros(4000)])
        return signal.sosfilt(sections, white)[1000:] / np.sqrt(np.sum(impulse**2))
    return white[1000:]


def _held(rng, t, shortest_s, longest_s, value):
    changes = np.cumsum(rng.uniform(shortest_s, longest_s, int(t[-1] / shortest_s) + 2))
    return np.array([value() for _ in range(len(changes) + 1)])[np.searchsorted(changes, t, side="right")]
