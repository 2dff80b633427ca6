"""The memory of the effects: stored, restored and serialized in mid-motion; steps of any size; any start.

Equalities are bit for bit unless a tolerance is given.
"""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import effect_cases
from actuator_fmu import Actuator, state_bytes
from effect_cases import EFFECTS
from reference import random_cases, simulate

OUTPUTS = ("position", "deflection", "rate")
SITUATIONS = {  # parameters, commands [deg] held for 10 ms each, and a condition at the instant at which the state is stored
    "in the middle of a delay": ({"delay.time": 0.0437}, [5.0], lambda a: a["position"] == 0.0),
    "stuck": ({"coulomb_friction.level": 1.0}, [4.0] * 10 + [3.6] * 3, lambda a: a["rate"] == 0.0 and a["position"] > 2.0),
    "on a stop": ({"position_limit.max": 2.0}, [4.0] * 5, lambda a: a["position"] == 2.0 and a["saturated"]),
    "at the rate limit": ({"rate_limit.up": 30.0}, [6.0] * 5, lambda a: a["rate"] == 30.0 and a["saturated"]),
    "in the dead zone": ({"dead_zone.half_width": 0.5}, [3.0] * 20, lambda a: 0.01 < abs(a["position"] - 3.059) < 0.49),
    "in the free play": ({"backlash.gap": 1.0}, [4.0] * 20 + [3.8] * 20, lambda a: 0.1 < abs(a["position"] - 3.875) < 0.49),
    "on the ramp of the command": ({"command_rate_limit.up": 20.0}, [6.0] * 5, lambda a: 0.5 < a["position"] < 1.5),
    "ringing": ({"structural_mode.gain": 0.5, "structural_mode.damping": 0.005}, [3.0] * 9, lambda a: a["position"] > 2.0),
    "lagging": ({"sensor_lag.time": 0.1}, [4.0] * 9, lambda a: a["position"] < a["deflection"] - 1.0),
    "drifting": ({"gain_drift.rate": 0.3, "sensor_bias.drift": 1.0, "chatter.amplitude": 0.2}, [1.0] * 9, lambda a: True),
    "frozen": ({"failure": "stuck", "initial_position": 1.0}, [4.0] * 5, lambda a: a["position"] == 1.0),
}  # fmt: skip


def strong(rng):
    """All effects on, none so strong that it hides another: new values from the ranges of the random cases."""
    effects = random_cases.draw(int(rng.integers(1 << 31)), len(EFFECTS))["effects"]
    effects["command_dead_zone"]["half_width"] *= 0.3
    effects["coulomb_friction"]["level"] *= 0.3
    effects["dead_zone"]["half_width"] *= 0.3
    return effects


def everything_on(rng, hold=True):
    """A random case of all effects together, with a load and an intermittent failure."""
    case = effect_cases.draw(rng, EFFECTS, "random", int(rng.integers(2, 4)), hold) | {"effects": strong(rng)}
    count = len(case["time"])
    case["load"] = np.repeat(rng.uniform(-1.0, 1.0, count // 20 + 1), 20)[:count]
    case["failure"] = np.where(np.arange(count) // 20 % 5 == 3, rng.integers(1, 5), 0)
    print(case["base"], case["order"], case["effects"])
    return case


def same(one, other):
    return all(np.array_equal(one[channel], other[channel]) for channel in one)


# Stored and restored


@pytest.mark.parametrize("number", range(6))
def test_with_everything_on_a_state_kept_anywhere_continues_bit_for_bit(shared, package, rng, number):
    """At three instants: restored in place, and deserialized in an unrelated instance."""
    case = everything_on(rng, hold=number % 2 == 0)
    for moment in sorted(rng.integers(1, len(case["time"]) - 1, 3)):
        shared.restart(effect_cases.start_values(case))
        effect_cases.go_on(shared, case, 0, last=moment)
        time, state, written = shared.time, shared.fmu.getFMUstate(), state_bytes(shared)
        once = effect_cases.go_on(shared, case, moment)
        shared.fmu.setFMUstate(state)
        shared.time = time
        assert same(effect_cases.go_on(shared, case, moment), once)
        shared.fmu.freeFMUstate(state)
        with Actuator(package, "another") as another:
            another.initialize()
            another.fmu.setFMUstate(another.fmu.deSerializeFMUstate(written))
            another.time = time
            assert state_bytes(another) == written
            assert same(effect_cases.go_on(another, case, moment), once)


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_state_kept_in_this_situation_continues_bit_for_bit(shared, package, rng, situation):
    """In place after another run in between, and in another instance by deserialization."""
    parameters, commands, as_meant = SITUATIONS[situation]
    later, steps = rng.uniform(-6, 6, 60), rng.uniform(1e-4, 0.01, 60)
    shared.restart(parameters)
    shared.run(commands, 0.01)
    assert as_meant(shared), [shared[name] for name in OUTPUTS]
    time, state, written = shared.time, shared.fmu.getFMUstate(), state_bytes(shared)
    once = shared.run(later, steps, outputs=OUTPUTS)
    shared.restart({"backlash.gap": 0.3})
    shared.run(later, steps)
    shared.fmu.setFMUstate(state)
    shared.time = time
    assert as_meant(shared)
    assert np.array_equal(shared.run(later, steps, outputs=OUTPUTS), once)
    shared.fmu.freeFMUstate(state)
    with Actuator(package, "another") as another:
        another.initialize()
        another.fmu.setFMUstate(another.fmu.deSerializeFMUstate(written))
        another.time = time
        assert np.array_equal(another.run(later, steps, outputs=OUTPUTS), once)


def test_a_reset_forgets_every_memory(shared, rng):
    """A run of all effects after a run of all effects equals the run in a fresh instance."""
    case, other = everything_on(rng), everything_on(rng)
    once = effect_cases.run(shared, case)
    effect_cases.run(shared, other)
    assert same(effect_cases.run(shared, case), once)


def test_spoiled_bytes_of_many_memories_are_refused(shared, rng):
    """One flipped bit in any byte, with a command in transit in the delay: the state is rejected as a whole."""
    case = everything_on(rng)
    shared.restart(effect_cases.start_values(case))
    effect_cases.go_on(shared, case, 0, last=50)
    written = state_bytes(shared)
    for place in range(len(written)):
        flipped = bytes([written[place] ^ 1 << int(rng.integers(8))])
        with pytest.raises(FMICallException):
            shared.fmu.deSerializeFMUstate(written[:place] + flipped + written[place + 1 :])


LONG_DELAY, UNDER_WAY = {"delay.time": 5.0}, 25_000  # steps of 0.1 ms, 2.5 s in total


def test_a_state_may_be_large(shared, rng):
    """Everything in transit in a long delay belongs to the state."""
    shared.restart(LONG_DELAY)
    shared.run(rng.uniform(-5, 5, UNDER_WAY), 1e-4)
    time, written, later = shared.time, state_bytes(shared), [0.0] * 60
    once = shared.run(later, 0.1)
    shared.restart()
    shared.fmu.setFMUstate(shared.fmu.deSerializeFMUstate(written))
    shared.time = time
    assert np.array_equal(shared.run(later, 0.1), once) and np.ptp(once) > 0.1


@pytest.mark.parametrize("hold", [True, False], ids=["held", "linear"])
@pytest.mark.parametrize("delay_s", [0.0003, 0.005, 0.0173, 0.3])
def test_a_delay_does_not_care_for_steps(shared, rng, delay_s, hold):
    """Steps from 10 microseconds to 100 ms in random order, shorter and longer than the delay."""
    time = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-5, -1, 150))])
    case = effect_cases.draw(rng, ["delay"], order=3, hold=hold)
    case.update(time=time, command=rng.uniform(-5, 5, len(time)), effects={"delay": {"time": delay_s}})
    expected = simulate(**case)
    assert effect_cases.difference(case, effect_cases.run(shared, case), expected) <= effect_cases.allowed(case)[0]
    cut = effect_cases.run(shared, case, effect_cases.irregular_pieces(rng))
    assert effect_cases.difference(case, cut, expected) <= effect_cases.allowed(case)[0]


@pytest.mark.parametrize("number", range(2))
def test_ten_seconds_in_one_step_are_ten_seconds(shared, rng, number):
    """All effects on; as in the reference after hundreds of time constants and as many events, with steps cut or not."""
    case = everything_on(rng) | {"time": np.array([0.0, 10.0, 20.0]), "command": rng.uniform(-5, 5, 3)}
    case.update(load=None, failure=None)
    expected, whole = simulate(**case), effect_cases.run(shared, case)
    assert effect_cases.difference(case, whole, expected) <= effect_cases.allowed(case)[0]
    cut = effect_cases.run(shared, case, effect_cases.irregular_pieces(rng, 100))
    assert effect_cases.difference(case, cut, expected) <= effect_cases.allowed(case)[0]


@pytest.mark.parametrize("number", range(2))
def test_steps_of_a_tenth_of_a_microsecond_add_up(shared, rng, number):
    """All effects on, in motion: two thousand steps equal one step of 0.2 ms, to 1e-9 of the peak because of rounding."""
    case = everything_on(rng)
    case["effects"]["quantisation"]["step"] = 0.0
    shared.restart(effect_cases.start_values(case))
    effect_cases.go_on(shared, case, 0, last=30)
    time, state = shared.time, shared.fmu.getFMUstate()
    whole = shared.run([3.0], 2e-4, outputs=OUTPUTS)[0]
    shared.fmu.setFMUstate(state)
    shared.time = time
    tiny = shared.run(np.full(2000, 3.0), 1e-7, outputs=OUTPUTS)[-1]
    shared.fmu.freeFMUstate(state)
    assert (np.abs(tiny - whole) <= 1e-9 * np.array([8.0, 8.0, 8.0 * case["base"][2]])).all()


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_does_not_care_when_the_experiment_starts(shared, rng, effect):
    """The same an hour later: drifts and phases count from the start. 1e-9 of the peak: times are rounded to 5e-13 s."""
    case = effect_cases.draw(rng, [effect], hold=False)
    slopes, runs = np.diff(case["command"]) / 0.005, []
    for start in (0.0, 3600.0):
        shared.restart(effect_cases.start_values(case), start_time=start)
        runs.append(shared.run(case["command"][:-1], 0.005, slopes, OUTPUTS))
    assert (np.abs(runs[1] - runs[0]).max(axis=0) <= 1e-9 * np.abs(runs[0]).max(axis=0)).all()
