"""The step map by brute force: a matrix exponential in 160-digit arithmetic. Slow, but valid for any parameters.

No partial fractions, hence no special case where poles coincide, and spare digits for the loss in scaling and squaring
(about 25 of them at p h = 3e8). It verifies `bact.py`, and replaces it where `bact.py` does not apply.
"""

import functools
from decimal import Decimal, localcontext

import numpy as np

import bact

DIGITS = 160
SCALED_NORM = 2.0**-12  # norm of the matrix in the series
TAYLOR_ORDER = 40  # remainder of the series: SCALED_NORM**40 / 40! = 1e-192


@functools.lru_cache(maxsize=256)
def exact_transition(s, order, h):
    """exp of the matrix of (x, d, v, command, slope) times h, in decimal arithmetic; rows x, d, v."""
    with localcontext() as context:
        context.prec, context.Emin, context.Emax = DIGITS, -(10**9), 10**9
        k, p, w, z, t = (Decimal(float(value)) for value in (s.k, s.p, s.omega, s.zeta, h))  # exactly the doubles of the FMU
        if order == bact.THIRD:
            rows = [[-p, 0, 0, p * k, 0], [0, 0, 1, 0, 0], [w * w, -w * w, -2 * z * w, 0, 0]]
        else:
            rows = [[0] * 5, [0, 0, 1, 0, 0], [0, -w * w, -2 * z * w, k * w * w, 0]]
        matrix = np.array(rows + [[0, 0, 0, 0, 1], [0] * 5], dtype=object) * t + Decimal(0)
        norm = float(max(abs(entry) for entry in matrix.flat))
        halvings = max(0, int(np.ceil(np.log2(5 * norm / SCALED_NORM))))
        matrix = matrix / Decimal(2**halvings)
        total = term = np.array([[Decimal(int(i == j)) for j in range(5)] for i in range(5)], dtype=object)
        for n in range(1, TAYLOR_ORDER):
            term = term.dot(matrix) / Decimal(n)
            total = total + term
        for _ in range(halvings):
            total = total.dot(total)
        return total[:3].astype(float)
