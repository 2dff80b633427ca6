"""`fmi2GetRealOutputDerivatives`: derivatives of outputs at the end of a step, where the command still has its old slope."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Error

import bact
import effect_cases
from actuator_fmu import selection
from effect_cases import EFFECTS

TOLERANCE = 1e-9  # relative to the natural scale of a derivative, omega^n times the deflection's scale
AMPLITUDE_DEG = 5.0
STEPS = 40

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


def highest_order(package):
    return package.description.coSimulation.maxOutputDerivativeOrder


def derivative(actuator, name, order):
    return actuator.fmu.getRealOutputDerivatives([actuator.vr(name)], [order])[0]


def test_output_derivatives_are_offered(package):
    assert highest_order(package) >= 1


@pytest.mark.parametrize("linear", [False, True], ids=["held", "linear"])
@every_order
@every_set
def test_output_derivatives_are_those_of_the_equations(shared, rng, s, order, linear):
    """position' = rate, rate' = w^2 (x - d) - 2 z w v, and so on up to the declared order.

    Absolute tolerance 1e-9 w^n 5 deg; the pole state x and the command differ only by the lag 1/p, so from position'''
    on a difference of nearly equal numbers times p enters: its rounding is allowed for, 1e-12 p w^2 5 deg.
    """
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS)
    slopes = rng.uniform(-1, 1, STEPS) * AMPLITUDE_DEG / bact.CONTROL_PERIOD_S * linear
    shared.restart(selection(s, order))
    shared.run(commands, bact.CONTROL_PERIOD_S, slopes)
    state = bact.respond(s, order, commands, bact.CONTROL_PERIOD_S, slopes)[-1]
    at_the_end = commands[-1] + slopes[-1] * bact.CONTROL_PERIOD_S
    exact = bact.output_derivatives(s, order, state, at_the_end, slopes[-1])
    for name, lowest in (("position", 0), ("deflection", 0), ("rate", 1)):
        for n in range(1, highest_order(shared.package) + 1):
            if lowest + n >= len(exact):
                break
            total = lowest + n
            grant = TOLERANCE * s.omega**total + (1e-12 * s.p * s.omega**2 if total > 2 and order == bact.THIRD else 0)
            assert abs(derivative(shared, name, n) - exact[total]) <= grant * AMPLITUDE_DEG, (name, n)


def test_the_first_derivative_of_the_position_is_the_rate(shared, rng):
    shared.restart()
    for command in rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS):
        shared.run([command], bact.CONTROL_PERIOD_S)
        assert derivative(shared, "position", 1) == shared["rate"]


@every_order
def test_the_first_derivatives_agree_with_finite_differences(shared, rng, order):
    """Position and rate over the last microseconds of a step, one-sided; first-order truncation h/2 times the next derivative."""
    s, h = bact.SETS[0], 1e-7
    shared.restart(selection(s, order))
    shared.run(rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS), bact.CONTROL_PERIOD_S)
    before = {name: shared[name] for name in ("position", "rate")}
    shared.step(h)
    for n, name in enumerate(before, start=1):
        truncation = 2 * h * s.omega ** (n + 1) * AMPLITUDE_DEG * (s.p / s.omega if n == 2 else 1)
        rounding = 1e-15 * AMPLITUDE_DEG * s.omega ** (n - 1) * 4 / h
        assert abs(derivative(shared, name, 1) - (shared[name] - before[name]) / h) <= truncation + rounding


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name != "quantisation"])
def test_with_an_effect_the_first_derivatives_are_those_of_the_next_moment(shared, rng, effect):
    """The command continues unchanged; the same truncation and rounding as above, with a mode of 80 Hz at most.

    Not for a quantised position: between its steps the derivative is zero, and the FMU returns that of the value before rounding.
    """
    h, fastest = 1e-7, 2 * np.pi * 80.0
    for hold in (True, False):
        case = effect_cases.draw(rng, [effect], hold=hold)
        omega, p = max(case["base"][2], fastest), case["base"][1]
        shared.restart(effect_cases.start_values(case))
        effect_cases.go_on(shared, case, 0, last=int(rng.integers(20, 150)))
        before = {name: shared[name] for name in ("position", "deflection", "rate")}
        offered = {name: derivative(shared, name, 1) for name in before}
        shared.step(h)
        for name, value in before.items():
            n = 2 if name == "rate" else 1
            truncation = 2 * h * omega ** (n + 1) * 8.0 * (min(p, 1e4) / omega if n == 2 else 1)
            rounding = 1e-15 * 8.0 * omega ** (n - 1) * 4 / h
            assert abs(offered[name] - (shared[name] - value) / h) <= truncation + rounding, (name, case["effects"])


@pytest.mark.parametrize("name, order", [("position", 0), ("position", -1), ("position", 99), ("command", 1), ("custom.k", 1)])
def test_what_is_not_offered_is_refused_with_a_word(actuator, name, order):
    """Orders start at 1 and end at the declared one; inputs and parameters have no output derivative."""
    actuator.initialize()
    actuator.step(bact.CONTROL_PERIOD_S)
    with pytest.raises(FMICallException) as refusal:
        derivative(actuator, name, order)
    assert refusal.value.status == fmi2Error
    assert (str(order) if name == "position" else name) in actuator.text
