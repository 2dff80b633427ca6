"""The frequency response measured by stepping the FMU agrees with the analytic one of equations (1) and (6).

A multisine through the FMU, settled, over one whole period: the discrete Fourier transform then has no leakage, and position
over command is the response at each line. The command between samples is held (or straight); `bact.account_for_hold` corrects
for it in closed form. Guaranteed: 1e-6 deg/deg in magnitude, 1e-4 deg in phase, absolute, at every frequency. Rounding alone is
1e-13, which leaves no room for an integration error. Phase errors are angles of measured times conjugate analytic: no wrapping.
"""

import numpy as np
import pytest

import bact
from frequency_sweep import FREQUENCIES_HZ, magnitude_and_phase_error, measure

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


@pytest.mark.parametrize("linear", [False, True], ids=["held", "linear"])
@every_order
@every_set
def test_the_stepped_frequency_response_is_the_analytic_one(shared, rng, s, order, linear):
    """All 17 sets, both orders, 24 frequencies from 0.5 to 12 Hz, 200 steps a second."""
    measured = measure(shared, s, order, rng, linear)
    magnitude_error, phase_error_deg = magnitude_and_phase_error(measured, bact.frequency_response(s, order, FREQUENCIES_HZ))
    assert magnitude_error.max() <= bact.MAGNITUDE_TOLERANCE
    assert phase_error_deg.max() <= bact.PHASE_TOLERANCE_DEG


@pytest.mark.parametrize("frequency_hz", [0.5, 4.0, 12.0])
def test_a_single_sine_and_a_multisine_measure_the_same(shared, rng, frequency_hz):
    """Superposition: the model is linear, so the response at one line alone is that among others."""
    s = bact.BY_NAME["te-late-unloaded"]
    alone = measure(shared, s, bact.THIRD, rng, lines=[frequency_hz])
    among = measure(shared, s, bact.THIRD, rng)[FREQUENCIES_HZ == frequency_hz]
    np.testing.assert_allclose(alone, among, rtol=1e-11)


@pytest.mark.parametrize("h", [0.001, 0.0025, 0.01])
def test_the_response_does_not_depend_on_the_step_size(shared, rng, h):
    """The hold differs and is corrected for; the actuator is the same."""
    s = bact.STIFFEST
    measured = measure(shared, s, bact.THIRD, rng, h=h)
    magnitude_error, phase_error_deg = magnitude_and_phase_error(measured, bact.frequency_response(s, bact.THIRD, FREQUENCIES_HZ))
    assert magnitude_error.max() <= bact.MAGNITUDE_TOLERANCE
    assert phase_error_deg.max() <= bact.PHASE_TOLERANCE_DEG


def test_second_and_third_order_differ_by_the_lag_of_the_pole(shared, rng):
    """The report's figure 7: they differ by p/(s + p) alone; 0.43 deg at 12 Hz for p = 10 000."""
    s = bact.BY_NAME["ls-early-unloaded"]
    ratio = measure(shared, s, bact.THIRD, rng) / measure(shared, s, bact.SECOND, rng)
    lag = s.p / (s.p + 2j * np.pi * FREQUENCIES_HZ)
    np.testing.assert_allclose(ratio, lag, rtol=1e-9)
