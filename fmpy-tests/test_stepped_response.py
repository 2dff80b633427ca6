"""Stepped from one communication point to the next, the FMU gives the exact solution of equations (1) and (6).

Errors are relative to the largest deflection of the run; at a zero crossing a pointwise relative error is meaningless.
1e-9 is guaranteed. Exact transitions have errors of about 1e-13, so a failure is a wrong formula, not chance.
"""

import numpy as np
import pytest
import scipy.signal

import bact
from actuator_fmu import selection

TOLERANCE = 1e-9  # relative to the largest value of the run
AMPLITUDE_DEG = 5.0
STEPS = 200  # one second at 200 Hz
OUTPUTS = ("position", "rate")
STIFF_POLE = 1e6  # 1/s

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


def assert_exact(measured, exact):
    """|difference| <= 1e-9 of the largest exact value of each output."""
    scale = np.abs(exact).max(axis=0)
    error = (np.abs(measured - exact).max(axis=0) / scale).max()
    assert error <= TOLERANCE, f"relative error {error:.3g}"


@every_order
@every_set
def test_a_held_random_command_gives_the_exact_response(shared, rng, s, order):
    """5 ms steps; p h goes up to 1.5e6 (us-late-loaded)."""
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS)
    shared.restart(selection(s, order))
    measured = shared.run(commands, bact.CONTROL_PERIOD_S, outputs=OUTPUTS)
    assert_exact(measured, bact.respond(s, order, commands, bact.CONTROL_PERIOD_S)[:, 1:])


@every_order
@every_set
def test_a_linear_command_gives_the_exact_response(shared, rng, s, order):
    """Value and derivative set at every step: straight lines between random corners."""
    corners = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS + 1)
    slopes = np.diff(corners) / bact.CONTROL_PERIOD_S
    shared.restart(selection(s, order))
    measured = shared.run(corners[:-1], bact.CONTROL_PERIOD_S, slopes, outputs=OUTPUTS)
    assert_exact(measured, bact.respond(s, order, corners[:-1], bact.CONTROL_PERIOD_S, slopes)[:, 1:])


@every_order
@every_set
def test_random_step_sizes_give_the_exact_response(shared, rng, s, order):
    """Every step of a different size, from 1 microsecond to 0.3 s, held and linear commands mixed."""
    steps = 10 ** rng.uniform(-6, -0.5, STEPS // 2)
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, steps.size)
    slopes = np.where(rng.random(steps.size) < 0.5, 0.0, rng.uniform(-1, 1, steps.size) / steps)
    shared.restart(selection(s, order))
    measured = shared.run(commands, steps, slopes, outputs=OUTPUTS)
    assert_exact(measured, bact.respond(s, order, commands, steps, slopes)[:, 1:])


@every_order
@pytest.mark.parametrize("h", [1e-7, 1e-4, 1.0, 1000.0])
@pytest.mark.parametrize("s", [bact.SETS[0], bact.STIFFEST], ids=lambda s: s.name)
def test_tiny_and_huge_steps_are_exact(shared, rng, s, order, h):
    """Starting in mid-motion, so that a tiny step changes the state."""
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS)
    steps = np.where(np.arange(STEPS) < STEPS // 10, bact.CONTROL_PERIOD_S, h)
    shared.restart(selection(s, order))
    measured = shared.run(commands, steps, outputs=OUTPUTS)
    assert_exact(measured, bact.respond(s, order, commands, steps)[:, 1:])


@every_order
@every_set
def test_the_step_response_agrees_with_scipy(shared, s, order):
    """Unit step against `scipy.signal.step`, to 1e-9 of k.

    scipy's matrix exponential fails at p h = 1.5e6. For such a stiff pole equation (1) is equation (6) delayed by 1/p:
    y(t - 1/p) = y - y'/p, up to (w/p)^2 = 1e-13, and y' is scipy's impulse response.
    """
    times = bact.CONTROL_PERIOD_S * np.arange(STEPS + 1)
    numerator, denominator = [s.k * s.omega**2], [1, 2 * s.zeta * s.omega, s.omega**2]
    if order == bact.SECOND:
        expected = scipy.signal.step((numerator, denominator), T=times)[1]
    elif s.p > STIFF_POLE:
        slope = scipy.signal.impulse((numerator, denominator), T=times)[1]
        expected = scipy.signal.step((numerator, denominator), T=times)[1] - slope / s.p
    else:
        expected = scipy.signal.step((numerator, np.polymul([1 / s.p, 1], denominator)), T=times)[1]
    shared.restart(selection(s, order))
    error = np.abs(shared.run(np.ones(STEPS), bact.CONTROL_PERIOD_S) - expected[1:]).max()
    assert error <= TOLERANCE * s.k


@every_order
def test_at_rest_nothing_moves(shared, order):
    """Command 0 from the neutral start: exactly zero, not nearly."""
    shared.restart({"order": order})
    assert not shared.run(np.zeros(STEPS), bact.CONTROL_PERIOD_S, outputs=OUTPUTS).any()


@every_order
@every_set
def test_deflection_is_position_while_the_sensor_is_ideal(shared, rng, s, order):
    shared.restart(selection(s, order))
    both = shared.run(rng.uniform(-1, 1, STEPS), bact.CONTROL_PERIOD_S, outputs=("position", "deflection"))
    assert (both[:, 0] == both[:, 1]).all()


@every_order
def test_a_decaying_motion_never_becomes_subnormal(shared, order):
    """Twenty seconds of decay, exp(-1860): numbers below 2.2e-308 triple the cost of a step, so the motion is set to rest."""
    shared.restart({"order": order})
    shared.run([1.0], bact.CONTROL_PERIOD_S)
    decay = np.abs(shared.run(np.zeros(4000), bact.CONTROL_PERIOD_S, outputs=OUTPUTS))
    assert ((decay == 0) | (decay >= np.finfo(float).tiny)).all()
