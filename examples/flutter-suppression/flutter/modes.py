"""Modes of a linear system from a free response: the roots that its samples obey, by a Hankel matrix.

Samples y_k = sum c_i z_i^k. Of the matrix Y with y_{j+k} in row j, column k, the leading left singular vectors span the same
space as the columns (1, z_i, z_i^2, ...); shifting that space by a row multiplies by diag(z_i). So z_i are eigenvalues of the
least-squares solution of  U_without_last_row Z = U_without_first_row  (Kung 1978; ESPRIT, Roy and Kailath 1989), and the
roots are ln(z_i)/spacing. Exact for samples without noise.
"""

import numpy as np

SPACING_S = 0.016  # spacing of the samples used: the fastest root of the loop is at 27 Hz, below half of 1/0.016
SMALLEST = 1e-9  # relative to the largest singular value: above rounding, below every excited mode
MOST_ROOTS = 16
ROWS = 32  # rows of the Hankel matrix, twice the possible number of roots; samples without noise need no more


def roots(time, signal, spacing_s=SPACING_S):
    """Complex roots [1/s] in a free response, by decreasing real part."""
    stride = max(1, round(spacing_s / (time[1] - time[0])))
    samples = np.asarray(signal)[::stride]
    samples = samples / np.abs(samples).max()
    rows = min(ROWS, len(samples) // 2)
    hankel = np.lib.stride_tricks.sliding_window_view(samples, len(samples) - rows + 1)
    left, singular, _ = np.linalg.svd(hankel, full_matrices=False)
    space = left[:, : min(MOST_ROOTS, int((singular > SMALLEST * singular[0]).sum()))]
    shifted = np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0]
    found = np.log(np.linalg.eigvals(shifted).astype(complex)) / (stride * (time[1] - time[0]))
    return found[np.argsort(-found.real)]


def nearest(found, expected):
    """The root in question."""
    return found[np.argmin(np.abs(found - expected))]
