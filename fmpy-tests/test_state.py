"""The state of an instance is a value: it can be stored, copied, serialized and deserialized, and is never shared by accident.

Equalities are bit for bit: the same state and the same commands give the same doubles.
"""

import threading
from ctypes import byref, c_void_p

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Error

import bact
from actuator_fmu import Actuator, selection, state_bytes

STEPS = 100
OUTPUTS = ("position", "rate")
SLOPE_DEG_S = 40.0

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


@pytest.fixture
def commands(rng):
    return rng.uniform(-5, 5, STEPS)


def run(actuator, commands):
    return actuator.run(commands, bact.CONTROL_PERIOD_S, outputs=OUTPUTS)


def in_motion(actuator, commands, s=bact.STIFFEST, order=bact.THIRD):
    """In mid-run, within a linear segment of the command."""
    actuator.restart(selection(s, order))
    run(actuator, commands)
    actuator.set_slope(SLOPE_DEG_S)
    actuator.step(0.3 * bact.CONTROL_PERIOD_S)
    return actuator


def go_on(actuator, commands):
    """The rest of the linear segment with nothing set, then held commands."""
    actuator.step(0.7 * bact.CONTROL_PERIOD_S)
    first = [actuator[name] for name in OUTPUTS]
    return np.vstack([first, run(actuator, commands)])


@every_order
@pytest.mark.parametrize("s", [bact.SETS[0], bact.STIFFEST], ids=lambda s: s.name)
def test_a_restored_state_continues_bit_for_bit(shared, commands, s, order):
    """Outputs are the same at once and from then on. The slope of the command belongs to the state."""
    in_motion(shared, commands, s, order)
    time, outputs = shared.time, [shared[name] for name in OUTPUTS]
    state = shared.fmu.getFMUstate()
    once = go_on(shared, commands)
    shared.fmu.setFMUstate(state)
    shared.time = time
    assert [shared[name] for name in OUTPUTS] == outputs
    assert (go_on(shared, commands) == once).all()
    shared.fmu.freeFMUstate(state)


@every_order
@every_set
def test_a_written_state_continues_bit_for_bit_in_another_instance(shared, package, commands, s, order):
    """The other instance is not even initialized; parameters belong to the state as well."""
    in_motion(shared, commands, s, order)
    time, written = shared.time, state_bytes(shared)
    once = go_on(shared, commands)
    with Actuator(package, "another") as another:
        another.initialize()
        another.fmu.setFMUstate(another.fmu.deSerializeFMUstate(written))
        another.time = time
        assert another["active.p"] == s.p
        assert (go_on(another, commands) == once).all()


def test_writing_a_state_twice_gives_the_same_bytes(shared, commands):
    in_motion(shared, commands)
    assert state_bytes(shared) == state_bytes(shared)


def test_a_state_reads_back_into_the_same_bytes(shared, commands):
    written = state_bytes(in_motion(shared, commands))
    shared.restart()
    shared.fmu.setFMUstate(shared.fmu.deSerializeFMUstate(written))
    assert state_bytes(shared) == written


def test_a_kept_state_does_not_follow_the_instance(shared, commands):
    """It is a copy: stepping on, resetting, overwriting another stored state do not change it."""
    in_motion(shared, commands)
    state, written = shared.fmu.getFMUstate(), state_bytes(shared)
    go_on(shared, commands)
    shared.restart()
    assert shared.fmu.serializeFMUstate(state) == written
    shared.fmu.freeFMUstate(state)


def test_getting_a_state_again_reuses_the_given_one(shared, commands):
    """The standard: a non-NULL pointer passed to `fmi2GetFMUstate` is an earlier copy, to be overwritten."""
    in_motion(shared, commands)
    state = shared.fmu.getFMUstate()
    earlier = shared.fmu.serializeFMUstate(state)
    run(shared, commands)
    shared.fmu.fmi2GetFMUstate(shared.fmu.component, byref(state))
    assert shared.fmu.serializeFMUstate(state) == state_bytes(shared) != earlier
    shared.fmu.freeFMUstate(state)
    assert not state.value, "freeing a state sets the pointer to NULL"


def test_freeing_no_state_is_fine(shared):
    """The standard: a NULL state is ignored by `fmi2FreeFMUstate`."""
    shared.fmu.fmi2FreeFMUstate(shared.fmu.component, byref(c_void_p()))


def spoiled(written, rng):
    """Possible damage to a file: truncated, emptied, one bit flipped, bytes appended, entirely different contents."""
    yield "empty", b""
    for length in sorted({1, 7, len(written) // 2, len(written) - 1}):
        yield f"cut to {length} bytes", written[:length]
    for place in rng.choice(len(written), size=min(40, len(written)), replace=False):
        bit = int(rng.integers(8))
        yield f"bit {bit} of byte {place} flipped", written[:place] + bytes([written[place] ^ 1 << bit]) + written[place + 1 :]
    yield "something appended", written + b"\0"
    yield "zeros", bytes(len(written))
    yield "ones", b"\xff" * len(written)
    yield "noise", rng.bytes(len(written))
    yield "a picture", b"\x89PNG\r\n\x1a\n" + rng.bytes(200)


def test_spoiled_bytes_are_refused_with_a_word(actuator, commands, rng):
    """Never accepted, never a crash; the stored state and the instance are unaffected by the attempt."""
    in_motion(actuator, commands)
    written = state_bytes(actuator)
    for what, data in spoiled(written, rng):
        before = len(actuator.log)
        with pytest.raises(FMICallException) as refusal:
            actuator.fmu.deSerializeFMUstate(data)
        assert refusal.value.status == fmi2Error, what
        assert len(actuator.log) > before, f"no log line for a state that was {what}"
        assert "state" in actuator.log[-1].message, what


def test_after_spoiled_bytes_a_good_state_brings_the_instance_back(actuator, commands):
    """The standard's recovery from `fmi2Error`: `fmi2SetFMUstate`."""
    in_motion(actuator, commands)
    time, state, written = actuator.time, actuator.fmu.getFMUstate(), state_bytes(actuator)
    once = go_on(actuator, commands)
    with pytest.raises(FMICallException):
        actuator.fmu.deSerializeFMUstate(written[:-1])
    actuator.fmu.setFMUstate(state)
    actuator.time = time
    assert (go_on(actuator, commands) == once).all()
    actuator.fmu.freeFMUstate(state)


@pytest.mark.parametrize("order", bact.ORDERS)
def test_a_rerun_after_reset_is_bit_identical(shared, commands, order):
    shared.restart(selection(bact.STIFFEST, order))
    once = run(shared, commands)
    shared.restart(selection(bact.STIFFEST, order))
    assert (run(shared, commands) == once).all()


def test_a_rerun_in_a_fresh_instance_is_bit_identical(package, shared, commands):
    shared.restart()
    once = run(shared, commands)
    with Actuator(package) as fresh:
        fresh.initialize()
        assert (run(fresh, commands) == once).all()


@pytest.mark.parametrize("count", [2, 50])
def test_instances_side_by_side_do_not_know_each_other(package, shared, rng, count):
    """Interleaved step by step, each with its set and command, the results are those of each alone."""
    sets = [bact.SETS[i % len(bact.SETS)] for i in range(count)]
    commands = rng.uniform(-5, 5, (count, STEPS))
    alone = []
    for s, command in zip(sets, commands):
        shared.restart(selection(s, bact.THIRD))
        alone.append(run(shared, command))
    crowd = [Actuator(package, f"number {i}") for i in range(count)]
    try:
        for actuator, s in zip(crowd, sets):
            actuator.initialize(selection(s, bact.THIRD))
        together = np.array([[run(a, c[i : i + 1])[0] for a, c in zip(crowd, commands)] for i in range(STEPS)])
    finally:
        for actuator in crowd:
            actuator.__exit__()
    assert (together.transpose(1, 0, 2) == np.array(alone)).all()


def test_instances_in_threads_do_not_know_each_other(package, shared, rng):
    """Eight threads, an instance each; ctypes releases Python's lock during a call."""
    sets, commands = bact.SETS[:8], rng.uniform(-5, 5, (8, STEPS))
    alone = []
    for s, command in zip(sets, commands):
        shared.restart(selection(s, bact.THIRD))
        alone.append(run(shared, command))
    crowd = [Actuator(package, s.name) for s in sets]
    together, start = [None] * len(crowd), threading.Barrier(len(crowd))

    def work(i):
        start.wait()
        crowd[i].initialize(selection(sets[i], bact.THIRD))
        together[i] = run(crowd[i], commands[i])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(crowd))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for actuator in crowd:
        actuator.__exit__()
    assert (np.array(together) == np.array(alone)).all()


@every_order
@every_set
def test_the_initial_position_is_a_position_at_rest(shared, s, order):
    """In the outputs before the first step; then the drive leaves it according to equations (1) and (6)."""
    start, command = -3.5, 1.25
    shared.restart(selection(s, order, initial_position=start, command=command))
    assert (shared["position"], shared["deflection"], shared["rate"]) == (start, start, 0.0)
    measured = run(shared, np.full(STEPS, command))
    exact = bact.respond(s, order, np.full(STEPS, command), bact.CONTROL_PERIOD_S, initial_position=start)[:, 1:]
    assert (np.abs(measured - exact).max(axis=0) <= 1e-9 * np.abs(exact).max(axis=0)).all()


def test_a_position_held_by_its_command_stays(shared):
    """k c = initial position: the equilibrium of both equations, left by roundings only (1e-12 of the position)."""
    s = bact.SETS[0]
    for order in bact.ORDERS:
        shared.restart(selection(s, order, initial_position=2.0))
        assert np.abs(shared.run(np.full(STEPS, 2.0 / s.k), bact.CONTROL_PERIOD_S) - 2.0).max() <= 2e-12
