"""`fmi2GetDirectionalDerivative`: sensitivity of outputs to the command, and of initial values to parameters.

In step mode (section 4.1 of the FMI 2.0 standard) it is the derivative of the outputs at the end of the last step with
respect to the command held over that step. Without effects the model is linear, so a finite difference is exact up to rounding,
whatever its size. In initialization mode it is the derivative of initial unknowns with respect to parameters and start values.
"""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Error

import bact
import effect_cases
from actuator_fmu import selection
from effect_cases import EFFECTS

TOLERANCE = 1e-9  # relative to the largest sensitivity of the output: k for position, k w for rate
OUTPUTS = ("position", "deflection", "rate")
STEP_SIZES_S = (1e-4, 0.001, bact.CONTROL_PERIOD_S, 0.1)
SENSOR = {"initial_position": 2.03, "chatter.amplitude": 0.25, "chatter.phase": 0.5, "sensor_bias.offset": 0.125}
CUSTOM = {"source": "custom", "custom.k": 1.25, "custom.p": 3000.0, "custom.omega": 77.0, "custom.zeta": 0.35}

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


def directional(actuator, unknowns, known, direction=1.0):
    references = [actuator.vr(name) for name in unknowns]
    return np.array(actuator.fmu.getDirectionalDerivative(references, [actuator.vr(known)], [direction]))


def scale(s):
    return np.array([s.k, s.k, s.k * s.omega])


def test_directional_derivatives_are_offered(package):
    assert package.description.coSimulation.providesDirectionalDerivative


@every_order
@every_set
def test_the_sensitivity_to_the_held_command_is_the_closed_form(shared, rng, s, order):
    """Change of position and rate per unit of command over the last step, independent of everything before it."""
    shared.restart(selection(s, order))
    shared.run(rng.uniform(-5, 5, 20), bact.CONTROL_PERIOD_S)
    for h in STEP_SIZES_S:
        shared.run([rng.uniform(-5, 5)], h)
        position, rate = bact.command_sensitivity(s, order, h)
        error = directional(shared, OUTPUTS, "command") - [position, position, rate]
        assert (np.abs(error) <= TOLERANCE * scale(s)).all(), h


@pytest.mark.parametrize("linear", [False, True], ids=["held", "linear"])
@every_order
@pytest.mark.parametrize("s", [bact.SETS[0], bact.STIFFEST], ids=lambda s: s.name)
def test_the_sensitivity_is_the_finite_difference_of_the_step(shared, rng, s, order, linear):
    """The same step from the same stored state with another command value (and the same slope, if any)."""
    slope = [40.0] if linear else None
    shared.restart(selection(s, order))
    shared.run(rng.uniform(-5, 5, 20), bact.CONTROL_PERIOD_S)
    time, state = shared.time, shared.fmu.getFMUstate()

    def outcome(command):
        shared.fmu.setFMUstate(state)
        shared.time = time
        return shared.run([command], bact.CONTROL_PERIOD_S, slope, outputs=OUTPUTS)[0]

    difference = outcome(3.0) - outcome(2.0)
    assert (np.abs(directional(shared, OUTPUTS, "command") - difference) <= TOLERANCE * scale(s)).all()
    shared.fmu.freeFMUstate(state)


def test_the_derivative_is_linear_in_the_direction(shared):
    shared.restart()
    shared.run([1.0, 2.0], bact.CONTROL_PERIOD_S)
    one = directional(shared, OUTPUTS, "command")
    np.testing.assert_allclose(directional(shared, OUTPUTS, "command", -7.0), -7 * one, rtol=1e-14)
    assert not directional(shared, OUTPUTS, "command", 0.0).any()


def test_asking_does_not_change_anything(shared, rng):
    """Bit for bit: a run with queries in between equals the run without."""
    commands = rng.uniform(-5, 5, 20)
    shared.restart()
    quiet = shared.run(commands, bact.CONTROL_PERIOD_S)
    shared.restart()
    asked = []
    for command in commands:
        asked += list(shared.run([command], bact.CONTROL_PERIOD_S))
        directional(shared, OUTPUTS, "command")
    assert (np.array(asked) == quiet).all()


def in_initialization_mode(actuator, values):
    actuator.fmu.reset()
    actuator.set(values)
    actuator.fmu.setupExperiment(startTime=0.0)
    actuator.fmu.enterInitializationMode()
    return actuator


def test_initially_the_position_follows_the_initial_position(shared):
    """d position / d initial_position = 1, and the rate is zero whatever the position."""
    in_initialization_mode(shared, {})
    assert directional(shared, OUTPUTS, "initial_position").tolist() == [1.0, 1.0, 0.0]


@pytest.mark.parametrize("source, expected", [("custom", 1.0), ("table", 0.0)])
@pytest.mark.parametrize("name", ["k", "p", "omega", "zeta"])
def test_active_parameters_follow_custom_ones_if_these_are_in_use(shared, name, source, expected):
    in_initialization_mode(shared, {**CUSTOM, "source": source})
    assert directional(shared, [f"active.{name}"], f"custom.{name}").tolist() == [expected]


@pytest.mark.parametrize("step_deg", [0.0, 0.5], ids=["not quantised", "quantised"])
def test_initial_unknowns_answer_to_their_declared_dependencies_as_finite_differences_do(shared, step_deg):
    """For every Real dependency in `ModelStructure/InitialUnknowns`. Central difference, 2e-7 of curvature in the phase.

    The sensor's parameters are inside their ranges. A quantiser step of zero is an end of its range, and has no derivative there.
    """
    checked = 0
    for unknown in shared.package.description.initialUnknowns:
        if unknown.variable.type != "Real":
            continue
        for known in unknown.dependencies or []:
            if known.type != "Real" or (known.name == "quantisation.step" and not step_deg):
                continue
            in_initialization_mode(shared, CUSTOM | SENSOR | {"quantisation.step": step_deg})
            here, step = shared[known.name], 2.0**-10
            derivative = directional(shared, [unknown.variable.name], known.name)[0]
            sides = []
            for side in (here + step, here - step):
                shared[known.name] = side
                sides.append(shared[unknown.variable.name])
            assert abs(derivative - (sides[0] - sides[1]) / (2 * step)) <= 1e-6 * max(1.0, abs(derivative)), (
                unknown.variable.name,
                known.name,
            )
            checked += 1
    assert checked, "no initial unknown declares a Real dependency"


@pytest.mark.parametrize("known", ["command", "load"])
@pytest.mark.parametrize("effect", EFFECTS)
def test_with_an_effect_the_sensitivity_is_still_the_finite_difference(shared, rng, effect, known):
    """Events move with the command, so it is a derivative only to first order: 1e-4 of the largest sensitivity.

    Held between samples, random strengths; a step with a kink within the difference would be excluded, and does not occur.
    """
    case = effect_cases.draw(rng, [effect])
    shared.restart(effect_cases.start_values(case))
    effect_cases.go_on(shared, case, 0, last=int(rng.integers(30, 150)))
    time, state = shared.time, shared.fmu.getFMUstate()

    def outcome(value):
        shared.fmu.setFMUstate(state)
        shared.time = time
        shared["command"] = case["command"][0]
        shared[known] = value
        shared.step(bact.CONTROL_PERIOD_S)
        return np.array([shared[name] for name in OUTPUTS])

    here = case["command"][0] if known == "command" else 0.7
    difference = (outcome(here + 1e-5) - outcome(here - 1e-5)) / 2e-5
    outcome(here)
    k, _, omega, _ = case["base"]
    error = directional(shared, OUTPUTS, known) - difference
    shared.fmu.freeFMUstate(state)
    assert (np.abs(error) <= 1e-4 * np.array([1.0, 1.0, omega]) * max(k, 1.0)).all(), case["effects"]


@pytest.mark.parametrize("unknown, known", [("position", "position"), ("command", "command"), ("position", "active.k")])
def test_what_is_no_unknown_or_no_known_is_refused_with_a_word(actuator, unknown, known):
    """An output is not a known, an input is not an unknown, a calculated parameter cannot be varied."""
    actuator.initialize()
    actuator.step(bact.CONTROL_PERIOD_S)
    with pytest.raises(FMICallException) as refusal:
        directional(actuator, [unknown], known)
    assert refusal.value.status == fmi2Error
    assert unknown in actuator.text or known in actuator.text
