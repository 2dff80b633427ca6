"""What one would write in Python: a second-order servo with one effect, compiled by numba and stepped by Runge-Kutta of order 4 in steps of
1 ms, 5 per sample at 200 samples/s."""

import numba
import numpy as np

STEP_S = 1e-3
SLOW_RATE_DEG_S = 1e-3  # Coulomb friction is smoothed below this rate
# Supported effects: index in the kernel, and start value of the strength in a search.
CANDIDATES = {
    "none": 0.0, "delay": 0.005, "command_limit": 2.0, "command_rate_limit": 60.0, "command_dead_zone": 0.05, "asymmetric_gain": 1.02,
    "dead_zone": 0.05, "amplitude_gain": 1e-3, "hinge_load": 0.02, "coulomb_friction": 0.02, "acceleration_limit": 5e3,
    "rate_limit": 60.0, "position_limit": 2.0, "backlash": 0.1,
}  # fmt: skip
KIND = {name: kind for kind, name in enumerate(CANDIDATES)}


@numba.njit(cache=True, fastmath=True)
def shaped(kind, s, c):
    if kind == 2:
        return min(max(c, -s), s)
    if kind == 4:
        return 0.0 if abs(c) < s else c - np.sign(c) * s
    if kind == 5:
        return c * s if c < 0.0 else c
    return c


@numba.njit(cache=True, fastmath=True)
def acceleration(kind, s, omega, zeta, x, position, rate):
    error = x - position
    if kind == 6:
        error = 0.0 if abs(error) < s else error - np.sign(error) * s
    drive = omega * omega * error
    if kind == 7:
        drive -= omega * omega * s * position**3
    if kind == 8:
        drive += omega * omega * s
    if kind == 10:
        drive = min(max(drive, -s), s)
    if kind == 9:
        drive -= omega * omega * s * np.tanh(rate / SLOW_RATE_DEG_S)
    return drive - 2.0 * zeta * omega * rate


@numba.njit(cache=True, fastmath=True)
def simulate(kind, s, base, command, interval, out):
    k, omega, zeta = base[0], base[2], base[3]
    steps = int(round(interval / STEP_S))
    h = interval / steps
    late = int(s / interval) if kind == 1 else 0
    share = s / interval - late if kind == 1 else 0.0
    position = rate = shifted = play = 0.0
    for n in range(len(command)):
        out[n] = play if kind == 13 else position
        for step in range(steps):
            # The pole p is far above the motion: x = k c.
            m = n - late - (1 if (step + 0.5) / steps < share else 0)
            c = shaped(kind, s, command[m] if m >= 0 else 0.0)
            if kind == 3:
                shifted += min(max(c - shifted, -s * h), s * h)
                c = shifted
            x = k * c
            a1 = acceleration(kind, s, omega, zeta, x, position, rate)
            a2 = acceleration(kind, s, omega, zeta, x, position + 0.5 * h * rate, rate + 0.5 * h * a1)
            a3 = acceleration(kind, s, omega, zeta, x, position + 0.5 * h * (rate + 0.5 * h * a1), rate + 0.5 * h * a2)
            a4 = acceleration(kind, s, omega, zeta, x, position + h * (rate + 0.5 * h * a2), rate + h * a3)
            moved = h * rate + h * h / 6.0 * (a1 + a2 + a3)
            position += min(max(moved, -s * h), s * h) if kind == 11 else moved
            rate += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            if kind == 11:
                rate = min(max(rate, -s), s)
            if kind == 12:
                position = min(max(position, -s), s)
            if kind == 13:
                play = min(max(play, position - 0.5 * s), position + 0.5 * s)
