"""`fmi2GetXxxStatus`, which importers query after a discarded step; and steps that end exactly at the right time."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Discard, fmi2DoStepStatus, fmi2LastSuccessfulTime, fmi2OK, fmi2PendingStatus, fmi2Terminated

import bact


def test_the_last_successful_time_is_the_end_of_the_last_step(shared, rng):
    """To the last bit: current communication point plus step size."""
    shared.restart()
    for h in rng.uniform(1e-4, 0.1, 100):
        start = shared.time
        shared.step(float(h))
        assert shared.fmu.getRealStatus(fmi2LastSuccessfulTime) == start + float(h)


def test_a_refused_step_does_not_advance_anything(actuator):
    """Time, outputs and the effect of the next good step are those without the refused one."""
    actuator.initialize()
    expected = actuator.run([1.0, 2.0], bact.CONTROL_PERIOD_S)
    actuator.restart()
    first = actuator.run([1.0], bact.CONTROL_PERIOD_S)[0]
    with pytest.raises(FMICallException):
        actuator.fmu.doStep(actuator.time, -1.0)
    assert actuator["position"] == first
    assert actuator.fmu.getRealStatus(fmi2LastSuccessfulTime) == actuator.time
    assert [first, *actuator.run([2.0], bact.CONTROL_PERIOD_S)] == list(expected)


def test_the_slave_never_wants_to_end_the_simulation(actuator):
    actuator.initialize()
    actuator.step(bact.CONTROL_PERIOD_S)
    assert actuator.fmu.getBooleanStatus(fmi2Terminated) is False


def test_questions_about_pending_steps_are_answered_or_discarded(actuator):
    """No step is ever pending: the last one is done (`fmi2OK`), or there is nothing to report (`fmi2Discard`)."""
    actuator.initialize()
    actuator.step(bact.CONTROL_PERIOD_S)
    for ask, kind in ((actuator.fmu.getStatus, fmi2DoStepStatus), (actuator.fmu.getStringStatus, fmi2PendingStatus)):
        try:
            assert ask(kind) in (fmi2OK, "")
        except FMICallException as refusal:
            assert refusal.status == fmi2Discard


def test_a_refused_value_leaves_the_others_of_the_call_alone(actuator):
    """All or nothing: one bad value among good ones sets none of them."""
    actuator.initialize({"custom.k": 1.5})
    names = ("command", "custom.k", "custom.zeta")
    before = [actuator[name] for name in names]
    with pytest.raises(FMICallException):
        actuator.fmu.setReal([actuator.vr(name) for name in names], [1.0, 2.0, np.nan])
    assert [actuator[name] for name in names] == before
