"""The truth of `bact.py` is correct: checked against formulations that share only equations (1) and (6) with it."""

import numpy as np
import pytest
import scipy.signal

import bact
from decimal_truth import exact_transition

ROUNDING = 2e-13  # relative to the largest entry of a row: some thousand roundings of double precision
ALIASES = 3000  # on either side; the neglected ones decrease with the third power, 1e-12 in total
FREQUENCIES_HZ = np.linspace(bact.LOWEST_HZ, bact.HIGHEST_HZ, 24)


@pytest.mark.parametrize("order", bact.ORDERS)
@pytest.mark.parametrize("s", [bact.SETS[0], bact.BY_NAME["te-late-loaded"], bact.STIFFEST], ids=lambda s: s.name)
@pytest.mark.parametrize("h", [1e-7, 1e-3, bact.CONTROL_PERIOD_S, 1.0])
def test_the_step_map_is_the_matrix_exponential(s, order, h):
    """State after a step = exp(A h) applied to (x, d, v, command, slope), for p h from 1e-3 to 3e8."""
    exact = exact_transition(s, order, h)
    mine = np.column_stack(
        [bact.advance(s, order, unit, 0.0, h) for unit in np.eye(3)]
        + [bact.advance(s, order, np.zeros(3), 1.0, h), bact.advance(s, order, np.zeros(3), 0.0, h, 1.0)]
    )
    rows = slice(0, 3) if order == bact.THIRD else slice(1, 3)  # eq. (6) has no pole state
    scale = np.abs(exact[rows]).max(axis=1, keepdims=True)
    assert np.abs(mine[rows] - exact[rows]).max() <= (ROUNDING * scale).max()
    assert (np.abs(mine[rows] - exact[rows]) <= ROUNDING * scale).all()


@pytest.mark.parametrize("linear", [False, True], ids=["held", "linear"])
@pytest.mark.parametrize("order", bact.ORDERS)
@pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
def test_the_sampled_response_is_the_sum_over_the_aliases(s, order, linear):
    """sum over m of H(j w_m) hold(w_m), w_m = w + 2 pi m / h, is `sampled_response` in closed form."""
    h = bact.CONTROL_PERIOD_S
    shifted_hz = FREQUENCIES_HZ + np.arange(-ALIASES, ALIASES + 1)[:, None] / h
    jwh = 2j * np.pi * shifted_hz * h
    hold = (1 - np.exp(-jwh)) / jwh
    terms = bact.frequency_response(s, order, shifted_hz) * (np.abs(hold) ** 2 if linear else hold)
    np.testing.assert_allclose(terms.sum(axis=0), bact.sampled_response(s, order, FREQUENCIES_HZ, h, linear), rtol=0, atol=1e-11)


@pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
def test_the_frequency_response_agrees_with_scipy(s):
    """Equation (6) through scipy's transfer functions; equation (1) times the first-order lag."""
    w = 2 * np.pi * FREQUENCIES_HZ
    _, second = scipy.signal.freqs([s.k * s.omega**2], [1, 2 * s.zeta * s.omega, s.omega**2], w)
    _, lag = scipy.signal.freqs([s.p], [1, s.p], w)
    np.testing.assert_allclose(bact.frequency_response(s, bact.SECOND, FREQUENCIES_HZ), second, rtol=1e-14)
    np.testing.assert_allclose(bact.frequency_response(s, bact.THIRD, FREQUENCIES_HZ), second * lag, rtol=1e-14)


def test_the_residues_rebuild_the_transfer_function():
    """sum r_i / (s - s_i) is H(s) again, relative to the largest term."""
    for s in bact.SETS:
        for order in bact.ORDERS:
            jw = 2j * np.pi * FREQUENCIES_HZ[:, None]
            terms = bact.residues(s, order) / (jw - bact.poles(s, order))
            error = np.abs(terms.sum(axis=1) - bact.frequency_response(s, order, FREQUENCIES_HZ))
            assert (error <= 1e-14 * np.abs(terms).max()).all(), s.name


def test_there_are_17_sets_numbered_in_the_order_of_the_tables():
    assert [s.number for s in bact.SETS] == list(range(1, 18))
    assert len(bact.BY_NAME) == len(bact.SETS)
    assert bact.NOT_IN_THE_REPORT not in {(s.surface, s.stage, s.load_case) for s in bact.SETS}
