"""The linear part of the reference against partial fractions and lsim: base, delay, mode, lag, drift, hinge load."""

import numpy as np
import pytest
from scipy import signal

from .closed_forms import W, base_responses, close, constant, grid, responses, superposed
from .plant import simulate

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("p", [40.0, 900.0, 6898.0, 1e5, 3e6, 2.97e8])
@pytest.mark.parametrize("hold", [True, False])
@pytest.mark.parametrize("omega, zeta", [(60.0, 0.3), (170.0, 0.56), (400.0, 1.4)])
def test_linear_response_at_all_magnitudes_of_the_pole(p, hold, omega, zeta):
    time = grid()
    command = np.random.default_rng(3).standard_normal(len(time)) * 4.0
    found = simulate((0.9, p, omega, zeta), {}, time, command, hold=hold)
    assert close(found["position"], 0.9 * superposed(time, command, base_responses(p, omega, zeta), hold))
    assert np.array_equal(found["position"], found["deflection"])
    assert not found["saturated"].any()


@pytest.mark.parametrize("hold", [True, False])
def test_second_order_and_uneven_sampling(hold):
    random = np.random.default_rng(4)
    time = np.cumsum(random.uniform(0.0005, 0.03, 120))
    command = random.standard_normal(120)
    found = simulate((1.2, 1.0, W, 0.5), {}, time, command, hold=hold, order=2)
    time = time - time[0]
    assert close(found["position"], 1.2 * superposed(time, command, base_responses(1.0, W, 0.5, 2), hold))


@pytest.mark.parametrize("delay", [0.0123456, 0.02, 1e-9, 0.7])
def test_delay_that_is_not_a_multiple_of_the_sample(delay):
    time = grid()
    command = np.random.default_rng(5).standard_normal(len(time))
    step, _ = base_responses(9e3, W, 0.6)
    expected = (np.diff(command, prepend=0.0) * step(time[:, None] - time - delay)).sum(1)
    assert close(simulate((1, 9e3, W, 0.6), {"delay": {"time": delay}}, time, command)["position"], expected)


def test_a_rest_away_from_zero_stays_and_delay_holds_its_command():
    time = grid(0.1)
    found = simulate((0.8, 7e3, W, 0.6), {"delay": {"time": 1.0}}, time, constant(9.0, time), initial_position=2.0)
    assert close(found["position"], constant(2.0, time)) and close(found["rate"], 0.0 * time)


@pytest.mark.parametrize("lag", [1e-6, 1e-4, 0.003, 0.2])
@pytest.mark.parametrize("frequency", [5.0, 20.0, 300.0])
def test_structural_mode_and_lag_by_partial_fractions(lag, frequency):
    p, zeta, z, gain, wm = 3e5, 0.6, 0.05, 0.4, 2.0 * np.pi * frequency
    time = grid()
    command = np.random.default_rng(6).standard_normal(len(time))
    pair = W * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    mode = wm * (-z + 1j * np.sqrt(1.0 - z**2))
    poles = [-p, pair, pair.conjugate(), mode, mode.conjugate()]

    def numerator(s):
        return p * W**2 * ((1.0 - gain) * (s * s + 2.0 * z * wm * s + wm**2) + gain * wm**2)

    found = simulate((1, p, W, zeta), {"sensor_lag": {"time": lag}, "structural_mode": {
        "frequency": frequency, "damping": z, "gain": gain}}, time, command)
    assert close(found["deflection"], superposed(time, command, responses(poles, numerator)), 1e-10)
    lagged = responses([*poles, -1.0 / lag], lambda s: numerator(s) / lag)
    assert close(found["position"], superposed(time, command, lagged), 1e-10)


def test_structural_mode_and_lag_by_lsim():
    p, zeta, wm, z, gain, lag = 6898.0, 0.56, 2.0 * np.pi * 20.0, 0.02, 0.3, 0.004
    # States x, d, v, m, m', s.
    a = np.array([[-p, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [W**2, -W**2, -2 * zeta * W, 0, 0, 0],
                  [0, 0, 0, 0, 1, 0], [0, wm**2, 0, -wm**2, -2 * z * wm, 0],
                  [0, (1 - gain) / lag, 0, gain / lag, 0, -1 / lag]])
    b, c = np.array([[p], [0], [0], [0], [0], [0]]), np.array([[0, 0, 0, 0, 0, 1.0], [0, 0, 1, 0, 0, 0]])
    time = grid(1.0)
    command = np.random.default_rng(7).standard_normal(len(time))
    _, expected, _ = signal.lsim((a, b, c, np.zeros((2, 1))), command, time, interp=False)
    found = simulate((1, p, W, zeta), {"sensor_lag": {"time": lag}, "structural_mode": {"gain": gain}}, time, command)
    assert close(found["position"], expected[:, 0], 1e-9) and close(found["rate"], expected[:, 1], 1e-9)


@pytest.mark.parametrize("order", [2, 3])
def test_gain_drift_on_a_constant_command_is_a_ramp(order):
    time = grid()
    step, ramp = base_responses(500.0, W, 0.6, order)
    found = simulate((1.1, 500.0, W, 0.6), {"gain_drift": {"rate": -0.3}}, time, constant(2.0, time), order=order)
    assert close(found["position"], 1.1 * 2.0 * (step(time) - 0.3 * ramp(time)))


def test_hinge_load_shifts_and_stiffens():
    time = grid()
    load = np.random.default_rng(8).standard_normal(len(time))
    effects = {"hinge_load": {"stiffness": 0.3, "bias": 0.7}}
    found = simulate((1, 1e4, W, 0.5), effects, time, constant(1.5, time), load=load, order=2)
    stiff = base_responses(1.0, W * np.sqrt(1.3), 0.5 / np.sqrt(1.3), 2)
    assert close(found["position"], superposed(time, 1.5 + 0.7 + load, stiff) / 1.3)
