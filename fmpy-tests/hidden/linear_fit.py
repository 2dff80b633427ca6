"""A linear model from one record, as a user would fit it before a diagnosis: order 2 or 3, least squares.

    y = k w^2 [p] / ((s^2 + 2 z w s + w^2) [(s + p)]) c + offset,   parameters in logarithms, the command held; scipy alone
"""

import numpy as np
from scipy import optimize, signal

STARTS = (1.0, 2.5, 0.4)  # omega over the expected bandwidth
START_ZETA, START_POLE = 0.8, 10.0  # the pole of order 3 in units of the bandwidth
MOST_ROWS = 3000  # longer records are thinned: a linear fit of five parameters needs no more samples
LOG_REACH = np.array([1.0, 2.0, 1.5, 4.0])  # k, omega, zeta and p stay within a factor e^REACH of their start
ITERATIONS = 25


def respond(base, order, command, sample_time_s):
    """From rest at the first command."""
    k, p, omega, zeta = base
    numerator, denominator = [k * omega**2], [1.0, 2.0 * zeta * omega, omega**2]
    if order == 3:
        numerator, denominator = [numerator[0] * p], np.polymul(denominator, [1.0, p])
    top, bottom, _ = signal.cont2discrete((numerator, denominator), sample_time_s)
    return k * command[0] + signal.lfilter(np.ravel(top), bottom, command - command[0])


def fit(time, command, position, order, bandwidth_hz, start=None, most_rows=MOST_ROWS):
    """(k, p, omega, zeta) of the smallest residual, and that residual on the (thinned) record; from `start`, or from several start values."""
    thin = max(1, len(time) // most_rows)
    sample_time = thin * (time[-1] - time[0]) / (len(time) - 1)
    command, position = command[::thin], position[::thin]
    free = 3 if order == 2 else 4
    w = 2.0 * np.pi * bandwidth_hz
    starts = [start] if start else [(1.0, START_POLE * w, factor * w, START_ZETA) for factor in STARTS]

    def descend(k, p, omega, zeta):
        centre = np.log([k, omega, zeta, p])

        def base(steps):
            k, omega, zeta, p = np.exp(centre + LOG_REACH * np.tanh(np.r_[steps, np.zeros(4 - free)] / LOG_REACH))
            return (float(k), float(p), float(omega), float(zeta))

        def residual(steps):
            gap = position - respond(base(steps), order, command, sample_time)
            return gap - gap.mean()

        found = optimize.least_squares(residual, np.zeros(free), method="lm", xtol=1e-5, ftol=1e-6, max_nfev=ITERATIONS * (free + 1))
        return found.cost, base(found.x), residual(found.x)

    _, best, left = min((descend(*each) for each in starts), key=lambda each: each[0])
    return best, left
