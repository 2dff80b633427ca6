"""The parameters in use: from three selectors, a number, or four user-defined values; and the start values of the binary."""

import struct
from fractions import Fraction

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Error

import bact
from actuator_fmu import selection
from decimal_truth import exact_transition

PARAMETERS = ("k", "p", "omega", "zeta")
NASTY = {  # k, p, omega, zeta
    "double pole": (1.0, 3000.0, 50.0, 1.0),
    "nearly a double pole, from below": (1.0, 3000.0, 50.0, 1 - 1e-7),
    "nearly a double pole, from above": (1.0, 3000.0, 50.0, 1 + 1e-7),
    "two real poles": (1.0, 3000.0, 50.0, 3.0),
    "two real poles far apart": (1.0, 3000.0, 500.0, 1000.0),
    "triple pole": (1.0, 50.0, 50.0, 1.0),
    "nearly a triple pole": (1.0, 50.0 * (1 + 1e-9), 50.0 * (1 - 1e-9), 1 + 1e-10),
    "three nearby poles": (1.0, 51.0, 50.0, 1.0),
    "pole upon a real pole": (1.0, 50.0 * (1.25 + 0.75), 50.0, 1.25),
    "pole below the pair": (1.0, 25.0, 50.0, 0.5),
    "slow pole": (1.0, 0.1, 50.0, 0.5),
    "hardly damped": (1.0, 3000.0, 300.0, 1e-6),
    "very stiff pair": (1.0, 1e6, 1e5, 0.7),
}
OWN = {"k": 1.25, "p": 3000.0, "omega": 77.0, "zeta": 0.35}
TOLERANCE = 1e-9  # relative to the largest deflection

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


def active(actuator):
    return {name: actuator[f"active.{name}"] for name in PARAMETERS}


def tabulated(s):
    return {name: getattr(s, name) for name in PARAMETERS}


def selectors(s):
    return {"surface": s.surface, "stage": s.stage, "load_case": s.load_case}


def custom(values):
    return {"source": "custom", **{f"custom.{name}": value for name, value in values.items()}}


def own_set(values):
    return bact.ParameterSet(0, bact.TE, "own", "own", **values)


def unit_step(actuator, steps=20):
    return actuator.run(np.ones(steps), bact.CONTROL_PERIOD_S)


def assert_steps_like(actuator, s, order):
    exact = bact.respond(s, order, np.ones(20), bact.CONTROL_PERIOD_S)[:, 1]
    assert np.abs(unit_step(actuator) - exact).max() <= TOLERANCE * s.k


@every_set
def test_the_three_selectors_select_the_row_of_the_table(shared, s):
    """Equal, not nearly: the table's decimals are the same doubles on both sides."""
    shared.restart(selectors(s))
    assert active(shared) == tabulated(s)


@every_set
def test_the_set_number_selects_the_same_row(shared, s):
    shared.restart({"set_number": s.number})
    assert active(shared) == tabulated(s)


@every_set
def test_the_set_number_overrides_the_selectors(shared, s):
    """Including selectors for which the report has no data."""
    surface, stage, load_case = bact.NOT_IN_THE_REPORT
    shared.restart({"surface": surface, "stage": stage, "load_case": load_case, "set_number": s.number})
    assert active(shared) == tabulated(s)


def test_unset_selectors_mean_the_first_row_and_the_third_order(shared):
    """The defaults: trailing edge, early, unloaded, equation (1)."""
    shared.restart()
    assert active(shared) == tabulated(bact.SETS[0])
    assert_steps_like(shared, bact.SETS[0], bact.THIRD)


@every_order
def test_the_order_selects_the_equation(shared, order):
    """Equations (1) and (6) differ by 1e-2 deg in a unit step, so that confusing them is detected."""
    s = bact.BY_NAME["te-late-loaded"]
    shared.restart(selection(s, order))
    assert_steps_like(shared, s, order)


@every_order
def test_custom_parameters_are_used_as_given(shared, order):
    shared.restart({**custom(OWN), "order": order})
    assert active(shared) == OWN
    assert_steps_like(shared, own_set(OWN), order)


def test_custom_parameters_beat_the_set_number(shared):
    """`source` selects the table or the user-defined values; `set_number` only selects the row of the table."""
    shared.restart({**custom(OWN), "set_number": 15})
    assert active(shared) == OWN


def test_custom_parameters_wait_for_their_source(shared):
    shared.restart({f"custom.{name}": value for name, value in OWN.items()})
    assert active(shared) == tabulated(bact.SETS[0])


def test_custom_parameters_need_no_report_data(shared):
    """The selectors of the missing row have no effect if the table is not used."""
    shared.restart({**custom(OWN), **dict(zip(("surface", "stage", "load_case"), bact.NOT_IN_THE_REPORT))})
    assert active(shared) == OWN


@every_order
@pytest.mark.parametrize("values", NASTY.values(), ids=NASTY)
def test_no_custom_parameters_are_a_special_case(shared, values, order):
    """Where poles coincide, partial fractions divide by zero, and nearby by almost zero; the response must not be affected.

    Truth: the matrix exponential in 160-digit arithmetic.
    """
    s = bact.ParameterSet(0, bact.TE, "own", "own", *values)
    shared.restart({**custom(tabulated(s)), "order": order})
    step_map = exact_transition(s, order, bact.CONTROL_PERIOD_S)
    state, exact = np.zeros(3), []
    for _ in range(20):
        state = step_map @ np.append(state, [1.0, 0.0])
        exact.append(state[1])
    assert np.abs(unit_step(shared) - exact).max() <= TOLERANCE * np.abs(exact).max()


@pytest.mark.parametrize("moment", ["before setup", "after setup", "in initialization mode"])
def test_parameters_may_be_set_at_any_time_before_the_first_step(actuator, moment):
    """Importers differ in when they set parameters, and some do it twice: the last value counts."""
    wrong, right = bact.SETS[3], bact.STIFFEST

    def set_now_if(now):
        if now == moment:
            actuator.set({**selectors(wrong), "order": "third"})
            actuator.set({**selectors(right), "order": "second"})

    set_now_if("before setup")
    actuator.fmu.setupExperiment(startTime=0.0)
    set_now_if("after setup")
    actuator.fmu.enterInitializationMode()
    set_now_if("in initialization mode")
    assert active(actuator) == tabulated(right)
    actuator.fmu.exitInitializationMode()
    assert active(actuator) == tabulated(right)
    assert_steps_like(actuator, right, bact.SECOND)


def test_a_parameter_set_in_initialization_mode_replaces_an_earlier_one(actuator):
    actuator["set_number"] = 4
    actuator.fmu.setupExperiment(startTime=0.0)
    actuator.fmu.enterInitializationMode()
    actuator["set_number"] = 0
    actuator.set(selectors(bact.STIFFEST))
    actuator.fmu.exitInitializationMode()
    assert active(actuator) == tabulated(bact.STIFFEST)


def test_the_missing_row_is_refused_by_name(actuator):
    """NASA/TM-1998-208452 has no data for the lower spoiler under load late in the test; a made-up answer would be worse."""
    with pytest.raises(FMICallException) as refusal:
        actuator.initialize(dict(zip(("surface", "stage", "load_case"), bact.NOT_IN_THE_REPORT)))
    assert refusal.value.status == fmi2Error
    assert refusal.value.function == "fmi2ExitInitializationMode"
    message = actuator.text.lower()
    for word in (*bact.NOT_IN_THE_REPORT, "report", "no data"):
        assert word in message, f"{word!r} is missing in the log: {message!r}"


def test_after_a_refusal_reset_makes_the_instance_usable(actuator):
    with pytest.raises(FMICallException):
        actuator.initialize(dict(zip(("surface", "stage", "load_case"), bact.NOT_IN_THE_REPORT)))
    actuator.restart()
    assert_steps_like(actuator, bact.SETS[0], bact.THIRD)


def test_reset_works_at_once_and_forgets_everything(actuator):
    """Right after instantiation, and after parameters were set: all start values are restored."""
    actuator.fmu.reset()
    actuator.set({**custom(OWN), "set_number": 7, "order": "second", "initial_position": 3.0, "command": 2.0})
    actuator.fmu.reset()
    actuator.initialize()
    assert active(actuator) == tabulated(bact.SETS[0])
    assert actuator["position"] == 0.0 and actuator["command"] == 0.0
    assert_steps_like(actuator, bact.SETS[0], bact.THIRD)


@every_order
def test_tuning_custom_parameters_continues_the_motion(shared, rng, order):
    """`custom.*` are tunable: from the next step on the new values apply, and position and rate do not jump."""
    commands = rng.uniform(-1, 1, 60)
    tuned = {**OWN, "k": 0.9, "omega": 120.0, "zeta": 0.8}
    shared.restart({**custom(OWN), "order": order})
    before = bact.respond(own_set(OWN), order, commands[:30], bact.CONTROL_PERIOD_S)
    shared.run(commands[:30], bact.CONTROL_PERIOD_S)
    shared.set({f"custom.{name}": value for name, value in tuned.items()})
    after = shared.run(commands[30:], bact.CONTROL_PERIOD_S)
    assert active(shared) == tuned
    exact = bact.respond(own_set(tuned), order, commands[30:], bact.CONTROL_PERIOD_S, state=before[-1])
    assert np.abs(after - exact[:, 1]).max() <= TOLERANCE * np.abs(exact[:, 1]).max()


def start_values(package):
    return {v.name: v for v in package.variables.values() if v.start is not None}


def test_the_binary_starts_from_the_start_values_of_the_description(actuator):
    """Bit for bit, because no importer sends them. A number that does not survive printing and parsing would be detected here."""
    for name, variable in start_values(actuator.package).items():
        found = actuator[name]
        if variable.type == "Real":
            assert struct.pack("<d", found) == struct.pack("<d", float(variable.start)), name
        elif variable.type == "Boolean":
            assert bool(found) == (variable.start in ("true", "1", True)), name
        else:
            assert found == int(variable.start), name


def test_printed_start_values_are_the_shortest_that_read_back(package):
    """`1.0198`, not `1.01980000000000003979`: the description is read by people."""
    for name, variable in start_values(package).items():
        if variable.type == "Real":
            value = float(variable.start)
            assert Fraction(variable.start) == Fraction(repr(value)), name
