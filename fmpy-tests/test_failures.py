"""The drive fails, and recovers: `failure` against the independent reference and against closed forms; the load on the hinge.

    passive               the drive exerts no force: damping, hinge, friction and stops remain
    stuck                 the drive freezes where it is
    hardover_positive     the target of the servo is position_limit.max, for any command
    hardover_negative     the same to position_limit.min

Tolerances relative to the largest position: against the reference as in `effect_cases.py`, 1e-9 against a closed form. Equalities
are bit for bit.
"""

import numpy as np
import pytest

import bact
import effect_cases
from actuator_fmu import selection
from effect_cases import EFFECTS, irregular_pieces
from reference import simulate
from reference.plant import FAILURES

LINEAR = 1e-9
OUTPUTS = ("position", "rate")
STOPS = {"position_limit.min": -3.0, "position_limit.max": 5.0}
FEW = [bact.SETS[0], bact.SETS[11], bact.STIFFEST]

few_sets = pytest.mark.parametrize("s", FEW, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)
every_stop = pytest.mark.parametrize("failure, stop", [("hardover_positive", 5.0), ("hardover_negative", -3.0)])


def in_motion(actuator, s, order=bact.SECOND, steps=7, **parameters):
    """A step of 2 deg, ended while the drive still moves: (d, v)."""
    actuator.restart(selection(s, order, **parameters))
    actuator.run(np.full(steps, 2.0), 0.002)
    return actuator["position"], actuator["rate"]


def follow(actuator, times, command=2.0):
    """(position, rate) at these times from now on, the command held."""
    return actuator.run(np.full(len(times), command), np.diff(times, prepend=0.0), outputs=OUTPUTS)


def assert_close(found, exact):
    assert (np.abs(found - exact).max(axis=0) <= LINEAR * np.abs(exact).max(axis=0)).all()


# Against the reference


def with_a_failure(rng, names, failure, hold):
    """The drive works, fails at a random sample, works again from another."""
    case = effect_cases.draw(rng, names, rng.choice(effect_cases.COMMANDS), int(rng.integers(2, 4)), hold)
    begin, end = sorted(rng.choice(np.arange(10, len(case["time"]) - 10), 2, replace=False))
    case["failure"] = np.zeros(len(case["time"]), int)
    case["failure"][begin:end] = FAILURES.index(failure)
    case["load"] = np.repeat(rng.uniform(-2.0, 2.0, len(case["time"]) // 20 + 1), 20)[: len(case["time"])]
    print(failure, begin, end, {name: value for name, value in case.items() if name in ("base", "effects", "order", "hold")})
    return case


@pytest.mark.parametrize("number", range(8))
@pytest.mark.parametrize("failure", FAILURES[1:])
def test_failure_and_recovery_are_the_reference_s(shared, rng, failure, number):
    """Stops and up to five more effects, random loads; also in cut steps. `saturated` is right in every step."""
    names = {"position_limit", *rng.choice(EFFECTS, number % 6, replace=False)}
    case = with_a_failure(rng, [str(name) for name in sorted(names)], failure, hold=number % 2 == 0)
    expected, found = simulate(**case), effect_cases.run(shared, case)
    against_the_reference, between_cuts = effect_cases.allowed(case)
    assert effect_cases.difference(case, found, expected) <= against_the_reference
    assert np.array_equal(found["saturated"] == 1.0, expected["saturated_within"])
    cut = effect_cases.run(shared, case, irregular_pieces(rng))
    assert effect_cases.difference_between_runs(case, cut, found, expected) <= between_cuts


# Passive


@few_sets
def test_a_passive_drive_coasts(shared, rng, s):
    """d + v / (2 zeta w) (1 - exp(-2 zeta w t)): damping alone."""
    d, v = in_motion(shared, s)
    shared["failure"] = "passive"
    times, damping = np.sort(rng.uniform(0.001, 0.1, 30)), 2.0 * s.zeta * s.omega
    decay = np.exp(-damping * times)
    assert_close(follow(shared, times), np.column_stack([d + v / damping * (1.0 - decay), v * decay]))


@few_sets
def test_a_passive_drive_swings_about_the_balance_of_its_hinge(shared, rng, s):
    """The hinge alone: omega sqrt(stiffness), about (load + bias) / stiffness: a second-order servo."""
    stiffness, bias, load = 0.4, 0.3, -0.5
    d, v = in_motion(shared, s, **{"hinge_load.stiffness": stiffness, "hinge_load.bias": bias})
    shared.set({"failure": "passive", "load": load})
    root = np.sqrt(stiffness)
    hinge = bact.ParameterSet(0, bact.TE, "own", "own", 1.0 / stiffness, 1.0, s.omega * root, s.zeta / root)
    steps = rng.uniform(0.001, 0.01, 40)
    exact = bact.respond(hinge, bact.SECOND, np.full(40, load + bias), steps, state=np.array([0.0, d, v]))[:, 1:]
    assert_close(follow(shared, np.cumsum(steps)), exact)


# Stuck


@every_order
@few_sets
def test_a_stuck_drive_is_frozen_to_the_bit(shared, rng, s, order):
    """Commands, loads, small and large steps: same position, no rate, nothing saturated."""
    d, _ = in_motion(shared, s, order, **STOPS)
    shared["failure"] = "stuck"
    for _ in range(100):
        shared["load"] = rng.uniform(-5, 5)
        found = shared.run([rng.uniform(-8, 8)], 10.0 ** rng.uniform(-6, 0), outputs=("position", "deflection", "rate"))[0]
        assert (found == [d, d, 0.0]).all() and not shared["saturated"]


@every_order
@few_sets
def test_a_freed_drive_starts_from_rest(shared, s, order):
    """From where it stuck; the servo's target has followed the command meanwhile (after half a second to within 1e-300)."""
    d, _ = in_motion(shared, s, order)
    shared["failure"] = "stuck"
    shared.run([1.2], 0.5)
    shared["failure"] = "none"
    exact = bact.respond(s, order, np.full(40, -1.0), 0.003, state=np.array([s.k * 1.2, d, 0.0]))[:, 1:]
    assert_close(follow(shared, 0.003 * np.arange(1, 41), -1.0), exact)


# Hardover


@every_stop
@few_sets
def test_a_hardover_is_a_step_to_the_stop(shared, s, failure, stop):
    """At once and without the pole: the second-order servo with the command stop / k until the stop is reached, where it stays exactly."""
    d, v = in_motion(shared, s, bact.THIRD, **STOPS)
    shared["failure"] = failure
    times = 0.0005 * np.arange(1, 400)
    exact = bact.respond(s, bact.SECOND, np.full(len(times), stop / s.k), 0.0005, state=np.array([0.0, d, v]))[:, 1:]
    found = follow(shared, times, command=-8.0 * np.sign(stop))
    reached = np.argmax(np.abs(exact[:, 0]) >= abs(stop)) if (np.abs(exact[:, 0]) >= abs(stop)).any() else len(times)
    assert 0 < reached < len(times), "this servo overshoots"
    assert_close(found[:reached], exact[:reached])
    assert np.abs(found[:, 0]).max() == abs(stop) and found[-1, 0] == stop and found[-1, 1] == 0.0 and shared["saturated"]


@every_stop
def test_a_hardover_goes_through_the_limits(shared, failure, stop):
    """Driven exactly at the rate limit, and saturated throughout; the acceleration limit acts before."""
    limits = {"rate_limit.up": 40.0, "rate_limit.down": 25.0, "acceleration_limit.value": 2e4}
    shared.restart({**STOPS, **limits, "failure": failure})
    rate = 40.0 if stop > 0 else -25.0
    found = shared.run(np.zeros(60), 0.001, outputs=OUTPUTS)
    assert np.allclose(found[:1, 1], np.sign(stop) * 2e4 * 0.001, rtol=0.1), "it accelerates at the limit, less its damping"
    assert (found[5:, 1] == rate).all() and shared["saturated"]
    assert np.allclose(np.diff(found[5:, 0]), rate * 0.001, rtol=1e-12)
    shared.run([0.0], 1.0)
    assert (shared["position"], shared["rate"], shared["saturated"]) == (stop, 0.0, True)


@every_order
@every_stop
def test_after_a_hardover_the_servo_takes_its_command_up_again(shared, order, failure, stop):
    """From rest at the stop; the target has followed the command throughout."""
    s = bact.SETS[0]
    shared.restart(selection(s, order, failure=failure, **STOPS))
    shared.run(np.full(100, 1.0), 0.01)
    assert shared["position"] == stop
    shared["failure"] = "none"
    exact = bact.respond(s, order, np.full(60, 1.0), 0.002, state=np.array([s.k, stop, 0.0]))[:, 1:]
    assert_close(follow(shared, 0.002 * np.arange(1, 61), 1.0), exact)


def test_a_failure_set_before_the_start_holds_from_the_start(shared):
    for values in ({"failure": "stuck"}, {"failure": "passive"}):
        shared.restart({"initial_position": 1.5, **values})
        assert (shared.run(np.full(50, 5.0), 0.01) == 1.5).all()


# The hinge


@every_order
@few_sets
def test_at_rest_the_servo_and_the_hinge_share_the_load(shared, rng, s, order):
    """(k c + load + bias) / (1 + stiffness), 1e-12 of it, after two seconds."""
    for _ in range(10):
        stiffness, bias, load, command = rng.uniform(-0.3, 3.0), *rng.uniform(-3, 3, 3)
        shared.restart(selection(s, order, **{"hinge_load.stiffness": stiffness, "hinge_load.bias": bias}))
        shared["load"] = load
        found = shared.run([command] * 4, 0.5)[-1]
        exact = (s.k * command + load + bias) / (1.0 + stiffness)
        assert abs(found - exact) <= 1e-12 * (abs(s.k * command) + abs(load) + abs(bias)) / (1.0 + stiffness)


@few_sets
def test_a_load_moves_the_drive_as_a_command_does(shared, rng, s):
    """Held and moving loads enter where k c does, behind the pole: the second-order response, of gain one."""
    unit = bact.ParameterSet(0, bact.TE, "own", "own", 1.0, s.p, s.omega, s.zeta)
    for order in bact.ORDERS:
        shared.restart(selection(s, order))
        loads, steps = rng.uniform(-3, 3, 60), rng.uniform(1e-4, 0.02, 60)
        slopes = rng.uniform(-100, 100, 60) * rng.integers(0, 2, 60)
        found = np.empty((60, 2))
        for i, (load, slope, h) in enumerate(zip(loads, slopes, steps)):
            shared["load"] = load
            shared.set_slope(slope, "load")
            shared.step(h)
            found[i] = [shared[name] for name in OUTPUTS]
        assert_close(found, bact.respond(unit, bact.SECOND, loads, steps, slopes)[:, 1:])


def test_a_load_that_is_not_set_again_stays(shared):
    shared.restart()
    shared["load"] = 1.5
    assert np.abs(shared.run(np.zeros(100), 0.01)[50:] - 1.5).max() <= 1e-9
