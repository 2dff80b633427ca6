"""Closed forms and comparisons shared by the tests: partial fractions of the linear plant, and tolerances for equality.

The response of a linear plant with distinct poles to a unit step is  final + sum r_i exp(pole_i t),
r_i = numerator(pole_i) / (pole_i prod_{j != i} (pole_i - pole_j)),  and to a held command the sum of its steps.
"""

import numpy as np

# Relative to the peak position. Closed forms themselves have rounding errors of this size.
EXACT = 1e-11
W = 170.0  # rad/s, omega of most tests
UNDAMPED = (1.0, 1e5, W, 0.0)


def grid(duration=0.5, step=0.005):
    return np.arange(round(duration / step) + 1) * step


def constant(value, time):
    return np.full(len(time), float(value))


def close(found, expected, tolerance=EXACT):
    expected = np.asarray(expected, float)
    return np.abs(found - expected).max() < tolerance * max(1e-3, np.abs(expected).max())


def responses(poles, numerator):
    """Unit step and ramp response of numerator(s) / prod(s - pole), distinct poles, zero for t < 0."""
    poles = np.array(poles, complex)
    others = [np.prod([a - b for j, b in enumerate(poles) if j != i]) for i, a in enumerate(poles)]
    residues = np.array([numerator(a) / (a * other) for a, other in zip(poles, others)])
    final = (numerator(0.0) / np.prod(-poles)).real

    def step(t):
        t = np.asarray(t)[..., None]
        value = final + (residues * np.exp(poles * np.maximum(t, 0.0))).sum(-1).real
        return np.where(t[..., 0] > 0.0, value, 0.0)

    def ramp(t):
        t = np.asarray(t)[..., None]
        value = final * t[..., 0] + (residues / poles * (np.exp(poles * np.maximum(t, 0.0)) - 1.0)).sum(-1).real
        return np.where(t[..., 0] > 0.0, value, 0.0)

    return step, ramp


def base_responses(p, omega, zeta, order=3):
    pair = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2 + 0j))
    second = [pair, -2.0 * zeta * omega - pair]
    return responses([-p, *second], lambda s: p * omega**2) if order == 3 else responses(second, lambda s: omega**2)


def superposed(time, command, response, hold=True):
    """Response to the samples held (sum of steps) or linear (a first step, then changes of slope)."""
    step, ramp = response
    ages = time[:, None] - time
    if hold:
        return (np.diff(command, prepend=0.0) * step(ages)).sum(1)
    slopes = np.r_[np.diff(command) / np.diff(time), 0.0]
    return command[0] * step(time) + (np.diff(slopes, prepend=0.0) * ramp(ages)).sum(1)
