"""Limit cycles with backlash: predicted by the describing function, and simulated with the FMU's `backlash.gap`.

The play operator sits between drive and surface. For a sine of amplitude A at the drive it acts like the complex gain N(A) of
Gelb and Vander Velde, which depends on A/gap alone, so that all amplitudes here are proportional to the gap. A limit cycle is a
self-sustained sine,

    1 = N(A) L(j w) exp(-j w T),

with L of `linear`. With N frozen at A, the loop has the roots of a linear one: where their largest real part falls through
zero as A grows, the limit cycle is stable; where it rises, the limit cycle is unstable and larger motions diverge.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from flutter import linear, loop, wing
from reference import describing_functions

SMALLEST, LARGEST, POINTS = 0.501, 60.0, 240  # drive amplitudes over gap at which the frozen loop is evaluated


@dataclass(frozen=True)
class LimitCycle:
    """Amplitudes [deg] and frequency [Hz]; `stable`: small disturbances of it decay."""

    drive_deg: float
    pitch_deg: float
    frequency_hz: float
    stable: bool


def frozen_root(pressure_psf, s, amplitude_over_gap):
    """The dominant root [1/s] of the loop in which the play is the complex gain N(A)."""
    whole = linear.closed_loop(pressure_psf, s).astype(complex)
    whole[:6, 7] *= describing_functions.play(amplitude_over_gap, 1.0)
    roots = np.linalg.eigvals(whole)
    roots = roots[roots.imag > 1.0]  # the mirrored half belongs to the conjugate gain; the aperiodic root to neither
    return roots[np.argmax(roots.real)]


def predicted(pressure_psf, s, gap_deg):
    """All limit cycles of the describing function at this dynamic pressure, smallest first."""
    grid = 0.5 + np.geomspace(SMALLEST - 0.5, LARGEST, POINTS)
    growth = np.array([frozen_root(pressure_psf, s, x).real for x in grid])
    found = []
    for i in np.flatnonzero(growth[:-1] * growth[1:] < 0.0):
        x = brentq(lambda x: frozen_root(pressure_psf, s, x).real, grid[i], grid[i + 1], xtol=1e-10)
        found.append(_cycle(pressure_psf, s, x, frozen_root(pressure_psf, s, x).imag, gap_deg, bool(growth[i] > 0.0)))
    return found


def _cycle(pressure_psf, s, amplitude_over_gap, w, gap_deg, stable):
    surface = amplitude_over_gap * gap_deg * abs(describing_functions.play(amplitude_over_gap, 1.0))
    return LimitCycle(amplitude_over_gap * gap_deg, surface * abs(pitch_response(pressure_psf, w)), w / (2.0 * np.pi), stable)


def pitch_response(pressure_psf, w):
    """Pitch over deflection [deg/deg] at j w."""
    a, b = wing.wing(pressure_psf)
    return np.linalg.solve(1j * w * np.eye(4) - a, b[:, wing.DEFLECTION])[wing.PITCH]


def predicted_with_delay(pressure_psf, s, gap_deg, amplitudes_over_gap):
    """(delay [s], cycle) for each amplitude: the extra delay that sustains a limit cycle of that amplitude near 5 Hz.

    Only |N L| = 1 has to be solved: the delay is the remaining phase at the highest such frequency, over w. From the
    largest amplitude down to the one that needs no extra delay.
    """
    found = []
    for x in sorted(amplitudes_over_gap, reverse=True):
        play = describing_functions.play(x, 1.0)
        crossings = linear.crossings(pressure_psf, s, gain=abs(play))
        w, delay_s = max((2.0 * np.pi * frequency_hz, delay_s) for frequency_hz, delay_s in crossings)
        phase = (w * delay_s + np.angle(play) + np.pi) % (2.0 * np.pi) - np.pi
        if phase < 0.0:
            break
        found.append((phase / w, _cycle(pressure_psf, s, x, w, gap_deg, True)))
    return found


def measured(actuator, s, pressure_psf, gap_deg, delay_s=0.0, plunge_ft=0.02, settling_s=20.0, watched_s=2.0, bound_deg=30.0):
    """(pitch amplitude [deg], frequency [Hz], change of amplitude over the last half of the evaluated time) with the FMU."""
    parameters = {"set_number": s.number, "backlash.gap": gap_deg, "delay.time": delay_s}
    run = loop.in_turn(actuator, parameters, pressure_psf, settling_s + watched_s, plunge_ft, bound_deg=bound_deg)
    if run.time[-1] < settling_s + watched_s - 0.5 * loop.STEP_S:
        return np.inf, np.nan, np.inf
    late = run.after(settling_s)
    half = len(late.time) // 2
    first, second = (0.5 * np.ptp(part) for part in (late.pitch[:half], late.pitch[half:]))
    return second, frequency(late.time, late.pitch), second - first


def frequency(time, signal):
    """Mean frequency [Hz] between the first and the last rising passage through the mean."""
    centred = signal - signal.mean()
    rising = np.flatnonzero((centred[:-1] < 0.0) & (centred[1:] >= 0.0))
    if len(rising) < 2:
        return np.nan
    at = time[rising] - centred[rising] * (time[1] - time[0]) / (centred[rising + 1] - centred[rising])
    return (len(at) - 1) / (at[-1] - at[0])
