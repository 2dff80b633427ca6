"""The linear loop: flutter point, closed-loop modes, and the extra delay that the loop tolerates, with the delay exact.

The loop with the actuator's transfer function H(s) (NASA/TM-1998-208452, eq. (1)), the pitch response P(s) of the wing to the
deflection, and a delay T anywhere in the loop is on the verge of instability where

    1 = L(s) exp(-s T),      L(s) = -C(s) H(s) P(s),      s = j w.

So |L(j w)| = 1 gives the frequencies, and each has a first delay T = (arg L) / w, arg L in (0, 2 pi). The smallest of them is
the delay margin if the loop is stable without delay: as T grows from 0 no root can cross before.
"""

import functools

import numpy as np
from scipy.optimize import brentq, newton

import bact
from flutter import wing

LOWEST_HZ, HIGHEST_HZ, POINTS = 0.01, 60.0, 6_000  # the grid on which |L| = 1 is searched
FLUTTER_BETWEEN_PSF = (100.0, 200.0)


@functools.lru_cache
def flutter_point(speed_ft_s=wing.SPEED_FT_S):
    """(dynamic pressure [psf], frequency [Hz]) at which the wing alone starts to flutter."""
    pressure_psf = brentq(lambda q: np.linalg.eigvals(wing.wing(q, speed_ft_s)[0]).real.max(), *FLUTTER_BETWEEN_PSF, xtol=1e-9)
    roots = np.linalg.eigvals(wing.wing(pressure_psf, speed_ft_s)[0])
    return pressure_psf, abs(roots[np.argmax(roots.real)].imag) / (2.0 * np.pi)


def critical_damping(pressure_psf):
    """Damping ratio of the wing's less damped mode, without control."""
    return min(damping for _, damping in wing.modes(wing.wing(pressure_psf)[0]))


def closed_loop(pressure_psf, s, gain=1.0):
    """The matrix of wing, control law and actuator: z = (h, theta, h', theta', x, e, pole state, deflection, rate) [deg]."""
    a, b, command = wing.wing_with_control(pressure_psf, gain=gain)
    whole = np.zeros((9, 9))
    whole[:6, :6], whole[:6, 7] = a, b[:, wing.DEFLECTION]
    whole[6, :6], whole[6, 6] = s.p * s.k * command, -s.p
    whole[7, 8] = 1.0
    whole[8, 6:] = s.omega**2, -(s.omega**2), -2.0 * s.zeta * s.omega
    return whole


def growth(pressure_psf, s):
    """Largest real part [1/s] of the closed loop's eigenvalues: stable below zero."""
    return np.linalg.eigvals(closed_loop(pressure_psf, s)).real.max()


def open_loop(pressure_psf, s, roots, order=bact.THIRD):
    """L at these complex frequencies [1/s]."""
    a, b, command = wing.wing_with_control(pressure_psf)
    roots = np.atleast_1d(np.asarray(roots, dtype=complex))
    states = np.linalg.solve(roots[:, None, None] * np.eye(len(a)) - a, b[None, :, [wing.DEFLECTION]])
    actuator = s.k * s.omega**2 / (roots**2 + 2.0 * s.zeta * s.omega * roots + s.omega**2)  # eq. (6)
    pole = s.p / (roots + s.p) if order == bact.THIRD else 1.0  # eq. (1)
    return (states[..., 0] @ command) * actuator * pole


def crossings(pressure_psf, s, order=bact.THIRD, gain=1.0):
    """(frequency [Hz], first delay [s] that puts a root there) wherever |L| = 1; shortest delay first."""
    grid = 2.0 * np.pi * np.geomspace(LOWEST_HZ, HIGHEST_HZ, POINTS)

    def excess(w):
        return np.abs(gain * open_loop(pressure_psf, s, 1j * w, order)) - 1.0

    values, found = excess(grid), []
    for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        w = brentq(lambda x: excess(x)[0], grid[i], grid[i + 1], xtol=1e-10)
        phase = np.angle(open_loop(pressure_psf, s, 1j * w, order)[0]) % (2.0 * np.pi)
        found.append((w / (2.0 * np.pi), phase / w))
    return sorted(found, key=lambda crossing: crossing[1])


@functools.lru_cache(maxsize=4096)
def delay_margin(pressure_psf, s, order=bact.THIRD):
    """(extra delay [s] at which the loop becomes unstable, frequency [Hz] there); (0, nan) if it is unstable already."""
    if growth(pressure_psf, s) >= 0.0:
        return 0.0, np.nan
    frequency_hz, delay_s = crossings(pressure_psf, s, order)[0]
    return delay_s, frequency_hz


def root_with_delay(pressure_psf, s, delay_s, near):
    """The root of 1 = L(s) exp(-s T) next to `near`: damping and frequency of the loop with a delay, no approximation."""
    return newton(lambda root: 1.0 - open_loop(pressure_psf, s, root)[0] * np.exp(-root * delay_s), near, tol=1e-12, maxiter=100)


def followed_root(pressure_psf, s, delays_s):
    """The oscillating root that decides, followed from no delay through rising delays: the one at the margin's frequency."""
    _, frequency_hz = delay_margin(pressure_psf, s)
    roots = np.linalg.eigvals(closed_loop(pressure_psf, s))
    roots = roots[(roots.imag > 0.0)]
    near = roots[np.argmin(np.abs(roots - 2j * np.pi * frequency_hz))]
    found = []
    for delay_s in delays_s:
        near = root_with_delay(pressure_psf, s, delay_s, near)
        found.append(near)
    return np.array(found)
