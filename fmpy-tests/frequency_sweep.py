"""Measures the frequency response of the FMU by stepping it through a multisine; for the tests, the pictures and the demo."""

import numpy as np

import bact
from actuator_fmu import selection

PERIOD_S = 2.0  # one line every 0.5 Hz, a whole number of steps
SETTLING_S = 1.0  # the slowest mode decays with exp(-46 t), to 1e-20 of its initial value
AMPLITUDE_DEG = 0.5  # of each line; the model is linear, so the value is arbitrary
FREQUENCIES_HZ = np.arange(1, 25) / PERIOD_S  # 0.5 to 12 Hz
assert FREQUENCIES_HZ[0] == bact.LOWEST_HZ and FREQUENCIES_HZ[-1] == bact.HIGHEST_HZ


def multisine(lines_hz, times, rng):
    """Cosines of equal amplitude and random phase: all lines at once, without a common peak."""
    phases = rng.uniform(0, 2 * np.pi, len(lines_hz))
    return AMPLITUDE_DEG * np.cos(2 * np.pi * np.outer(times, lines_hz) + phases).sum(axis=1)


def measure(actuator, s, order, rng, linear=False, h=bact.CONTROL_PERIOD_S, lines=FREQUENCIES_HZ):
    """The continuous frequency response [deg/deg] at `lines` [Hz]: stepped, Fourier-transformed, corrected for the hold."""
    lines = np.asarray(lines, dtype=float)
    settling, period = round(SETTLING_S / h), round(PERIOD_S / h)
    command = multisine(lines, h * np.arange(settling + period + 1), rng)
    slopes = np.diff(command) / h if linear else None
    actuator.restart(selection(s, order))
    position = actuator.run(command[:-1], h, slopes)
    # `position[i]` is taken at the end of step i, when sample i + 1 of the command is due
    spectra = [np.fft.rfft(signal) for signal in (position[settling - 1 : -1], command[settling:-1])]
    bins = np.rint(lines * PERIOD_S).astype(int)
    sampled = spectra[0][bins] / spectra[1][bins]
    return sampled * bact.account_for_hold(s, order, lines, h, linear)


def magnitude_and_phase_error(measured, analytic):
    """(|deg/deg|, |deg|) at each frequency."""
    return np.abs(np.abs(measured) - np.abs(analytic)), np.abs(np.degrees(np.angle(measured * np.conj(analytic))))
