"""Chebyshev collocation: a smooth stretch of trajectory is one polynomial of degree 20.

Why not solve_ivp: a record of 1000 held samples needs some 10 000 restarts (each sample, each event, and the
boundary layer of the pole after each jump) of 3 ms each; and its dense output is of lower order than its steps,
so that events are less accurate than the end points. Here a stretch is solved at all of its nodes at once, the
polynomial is equally accurate everywhere, and events are roots of polynomials: 1 s instead of half a minute.
test_convergence.py compares the two where both are available.

    values on the nodes f_i = f(x_i),  x_i = (1 - cos(pi i / N)) / 2 on [0, 1]
    int_0^{x_i} f dx = (INTEGRAL f)_i,    f'(x_i) = (DERIVATIVE f)_i

The integral form of collocation is used throughout, because its matrices are well conditioned; source:
L. N. Trefethen, Spectral Methods in Matlab, SIAM 2000, chapters 5-6 (nodes, derivative, barycentric weights);
L. Greengard, SIAM J. Numer. Anal. 28 (1991) 1071 (integral form).
"""

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

DEGREE = 20
# A factor exp(-a x) or sin(a x) on [0, 1] is represented to (a/4)^20 / 20!: 4e-13 at a = 8, 4e-19 at a = 4.
LARGEST_DECAY = 8.0
LARGEST_PHASE = 4.0

NODES = (1.0 - np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)) / 2.0
NODES[DEGREE // 2] = 0.5
GAPS = np.diff(NODES)
WEIGHTS = (-1.0) ** np.arange(DEGREE + 1)
WEIGHTS[[0, -1]] *= 0.5
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(2.0 * NODES - 1.0, DEGREE))


def _operator(transform):
    """The matrix on node values of a linear map that takes Chebyshev coefficients to Chebyshev coefficients."""
    columns = [chebyshev.chebval(2.0 * NODES - 1.0, transform(c)) for c in TO_COEFFICIENTS.T]
    return np.array(columns).T


INTEGRAL = _operator(lambda c: 0.5 * chebyshev.chebint(c, lbnd=-1.0))
INTEGRAL[0] = 0.0
INTEGRAL_TWICE = INTEGRAL @ INTEGRAL
DERIVATIVE = _operator(lambda c: 2.0 * chebyshev.chebder(c))
IDENTITY = np.eye(DEGREE + 1)
HIGHEST_COEFFICIENTS = TO_COEFFICIENTS[-2:]


def interpolation_row(x):
    """Row that maps node values to the value at x in [0, 1] (barycentric formula)."""
    difference = x - NODES
    nearest = np.argmin(np.abs(difference))
    if difference[nearest] == 0.0:
        return IDENTITY[nearest]
    quotient = WEIGHTS / difference
    return quotient / quotient.sum()


def interpolate(values, x):
    """Value at x of the polynomial with these node values (last axis)."""
    return values @ interpolation_row(x)


def restriction(start, end):
    """Matrix that maps node values on [0, 1] to the values on the nodes of [start, end]."""
    if start == 0.0 and end == 1.0:
        return IDENTITY
    difference = (start + (end - start) * NODES)[:, None] - NODES
    at_node = difference == 0.0
    quotient = WEIGHTS / np.where(at_node, 1.0, difference)
    rows = quotient / quotient.sum(axis=1, keepdims=True)
    hit = at_node.any(axis=1)
    rows[hit] = at_node[hit]
    return rows


def root_between(values, lower, upper):
    """Root of the polynomial between two points where its signs differ; `lower` if they do not differ because of rounding."""
    def function(x):
        return float(interpolate(values, x))

    at_lower, at_upper = function(lower), function(upper)
    if at_lower == 0.0 or at_lower * at_upper > 0.0:
        return lower
    return brentq(function, lower, upper, xtol=1e-16, rtol=8.9e-16)


def sign_changes(values):
    """All x inside (0, 1) at which the polynomial changes sign, in order; also those in pairs between nodes."""
    if not values.any():
        return []
    roots = []
    slopes = DERIVATIVE @ values
    for i in range(DEGREE):
        left, right = values[i], values[i + 1]
        if i > 0 and left == 0.0:
            roots.append(NODES[i])
        elif left * right < 0.0:
            roots.append(root_between(values, NODES[i], NODES[i + 1]))
        elif left * slopes[i] < 0.0 < right * slopes[i + 1] and abs(left) < abs(slopes[i]) * GAPS[i]:
            turn = root_between(slopes, NODES[i], NODES[i + 1])
            if interpolate(values, turn) * left < 0.0:
                roots += [root_between(values, NODES[i], turn), root_between(values, turn, NODES[i + 1])]
    return roots


def first_violation(guards, tolerances):
    """Earliest x in [0, 1] at which one of the guards (rows of node values) falls below zero, and its row.

    A guard is a quantity that is >= 0 as long as the present mode holds. It counts as violated when it goes below
    -tolerance, and the event is then its last zero before that, so that rounding neither creates nor moves an event.
    A dip below zero between two nodes is found from the tangents: a convex stretch lies above its left tangent.
    Returns (None, None) when all hold.
    """
    floor = -tolerances[:, None]
    below = guards < floor
    slopes = guards @ DERIVATIVE.T
    dips = (slopes[:, :-1] < 0.0) & (slopes[:, 1:] > 0.0) & (guards[:, :-1] + slopes[:, :-1] * GAPS < floor)
    if not below.any() and not dips.any():
        return None, None
    earliest, earliest_row = None, None
    for row in range(len(guards)):
        values = guards[row]
        violations = [(NODES[i], i) for i in np.flatnonzero(below[row])[:1]]
        for i in np.flatnonzero(dips[row]):
            bottom = root_between(slopes[row], NODES[i], NODES[i + 1])
            if interpolate(values, bottom) < -tolerances[row]:
                violations.append((bottom, i + 1))
                break
        if not violations:
            continue
        where, index = min(violations)
        positive = np.flatnonzero(values[:index] > 0.0)
        x = root_between(values, NODES[positive[-1]], where) if len(positive) else 0.0
        if earliest is None or x < earliest:
            earliest, earliest_row = x, row
    return earliest, earliest_row
