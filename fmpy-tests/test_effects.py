"""Every effect, alone and in pairs, agrees with the independent reference; cutting time changes nothing.

Truth: `reference.simulate`, which shares only the equations with the product. Tolerances are relative to the largest
drive position of the run (rates: times omega):

    against the reference    1e-7    1e-4 is guaranteed; the reference itself is accurate to 1e-11
    time cut differently     1e-9    1e-6 is guaranteed; events are found to the last digits, for any cuts

Most errors are 1e-13; a chain with stick and stops amplifies rounding. Only the cubic spring has no closed form between
events; it is integrated by a series, truncated at a fixed size: its tolerances are ten and a hundred times these.
`ACTUATOR_EFFECT_ROUNDS=50 pytest test_effects.py` draws fifty times as many cases (ten minutes), `ACTUATOR_SEED=n` others.
"""

import os

import numpy as np
import pytest

import bact
import effect_cases
from actuator_fmu import selection
from effect_cases import COMMANDS, EFFECTS, five_pieces, irregular_pieces
from reference import simulate
from reference.plant import NEUTRAL

ROUNDS = int(os.environ.get("ACTUATOR_EFFECT_ROUNDS", "1"))
PAIRS = 40
EXTREMES = {  # towards both ends of a parameter's range; others are drawn from the usual range
    "delay": [{"time": 1e-9}, {"time": 0.005}, {"time": 5.0}],
    "command_rate_limit": [{"up": 1e-3, "down": 1e-3}, {"up": 1e5, "down": 1e5}],
    "command_dead_zone": [{"half_width": 1e-9}, {"half_width": 100.0}],
    "command_backlash": [{"gap": 1e-9}, {"gap": 100.0}],
    "asymmetric_gain": [{"ratio": 0.0}, {"ratio": 100.0}],
    "gain_drift": [{"rate": -1.0}, {"rate": 1.0}],
    "dead_zone": [{"half_width": 1e-9}, {"half_width": 100.0}],
    "amplitude_gain": [{"cubic": 0.05}, {"cubic": 0.5}],
    "hinge_load": [{"stiffness": -0.9}, {"stiffness": 30.0}, {"stiffness": 1000.0}],
    "coulomb_friction": [{"level": 1e-9}, {"level": 1e-3}, {"level": 100.0}],
    "acceleration_limit": [{"value": 1.0}, {"value": 1e6}],
    "rate_limit": [{"up": 1e-3, "down": 1e-3}, {"up": 1e4, "down": 1e-3}],
    "position_limit": [{"min": -1e-6, "max": 1e-6}, {"min": -1e6}],
    "backlash": [{"gap": 1e-9}, {"gap": 100.0}],
    "structural_mode": [{"frequency": 0.01}, {"frequency": 150.0}, {"frequency": 500.0}, {"damping": 0.0}, {"damping": 1.0},
                        {"damping": 2.0}, {"damping": 10.0}, {"frequency": 1000.0, "damping": 10.0, "gain": -10.0}],
    "sensor_lag": [{"time": 1e-9}, {"time": 1e-5}, {"time": 100.0}],
    "chatter": [{"frequency": 0.0}, {"frequency": 1e5}],
    "quantisation": [{"step": 5.0}],
}  # fmt: skip
SLOW = (1.1, 1e4, 20.0, 0.7)  # a servo of 3 Hz, slower than any tabulated one

every_effect = pytest.mark.parametrize("effect", EFFECTS)
every_command = pytest.mark.parametrize("kind", COMMANDS)


def assert_as_the_reference(actuator, case, rng):
    """In whole steps; in five; in five uneven ones. The reference has no cuts."""
    print({name: value for name, value in case.items() if name not in ("time", "command", "load", "failure")})
    expected = simulate(**case)
    whole = effect_cases.run(actuator, case)
    against_the_reference, between_cuts = effect_cases.allowed(case)
    assert effect_cases.difference(case, whole, expected) <= against_the_reference
    assert (whole["saturated"] == expected["saturated_within"]).all()
    for pieces in (five_pieces, irregular_pieces(rng)):
        cut = effect_cases.run(actuator, case, pieces)
        assert effect_cases.difference_between_runs(case, cut, whole, expected) <= between_cuts
        assert (cut["saturated"] == whole["saturated"]).all()


@pytest.mark.parametrize("order", [2, 3])
@every_command
@every_effect
def test_an_effect_alone_with_a_held_command(shared, rng, effect, kind, order):
    for _ in range(ROUNDS):
        assert_as_the_reference(shared, effect_cases.draw(rng, [effect], kind, order), rng)


@every_command
@every_effect
def test_an_effect_alone_with_a_linear_command(shared, rng, effect, kind):
    for _ in range(ROUNDS):
        assert_as_the_reference(shared, effect_cases.draw(rng, [effect], kind, int(rng.integers(2, 4)), hold=False), rng)


@pytest.mark.parametrize("number", range(PAIRS))
def test_two_effects_together(shared, rng, number):
    """Held or linear, either order, with a load on every other one; the seeds together cover all 190 pairs."""
    for _ in range(ROUNDS):
        names = [str(name) for name in rng.choice(EFFECTS, 2, replace=False)]
        case = effect_cases.draw(rng, names, rng.choice(COMMANDS), int(rng.integers(2, 4)), bool(rng.integers(2)))
        if number % 2:
            case["load"] = np.repeat(rng.uniform(-2.0, 2.0, len(case["time"]) // 20 + 1), 20)[: len(case["time"])]
        assert_as_the_reference(shared, case, rng)


@pytest.mark.parametrize("base", [None, SLOW], ids=["tabulated", "slow"])
@pytest.mark.parametrize("effect, values", [(effect, values) for effect, all_values in EXTREMES.items() for values in all_values])
def test_an_effect_at_the_ends_of_its_range(shared, rng, effect, values, base):
    """A shorter record; the accuracy does not depend on the strength of an effect, or on its speed relative to the servo."""
    case = effect_cases.draw(rng, [effect], order=int(rng.integers(2, 4)), hold=bool(rng.integers(2)))
    case["effects"][effect].update(values)
    case.update(time=case["time"][:60], command=case["command"][:60], initial_position=0.0, base=base or case["base"])
    assert_as_the_reference(shared, case, rng)


# Neutral effects

OUTPUTS = ("position", "deflection", "rate")
STEPS = 100


def go(actuator, rng_state):
    """Held, linear, whole and cut steps; the same for the same random state."""
    rng = np.random.default_rng(rng_state)
    commands, slopes = rng.uniform(-8, 8, STEPS), rng.uniform(-300, 300, STEPS) * rng.integers(0, 2, STEPS)
    return actuator.run(commands, rng.uniform(1e-4, 0.02, STEPS), slopes, OUTPUTS)


@pytest.mark.parametrize("order", bact.ORDERS)
@pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
def test_neutral_values_set_one_by_one_change_no_bit(shared, rng, s, order):
    """The instance whose effects were never set, and the one in which all were set to their neutral values."""
    shared.restart(selection(s, order))
    untouched = go(shared, s.number)
    shared.restart(selection(s, order, **effect_cases.dotted(NEUTRAL)))
    assert np.array_equal(go(shared, s.number), untouched)
    assert not shared["saturated"]


@every_effect
def test_an_effect_taken_back_before_the_start_leaves_no_trace(shared, rng, effect):
    shared.restart(selection(bact.SETS[0], bact.THIRD))
    untouched = go(shared, 1)
    shared.fmu.reset()
    shared.set(effect_cases.dotted(effect_cases.draw(rng, [effect])["effects"]))
    shared.initialize(selection(bact.SETS[0], bact.THIRD) | effect_cases.dotted({effect: NEUTRAL[effect]}))
    assert np.array_equal(go(shared, 1), untouched)


def test_parameters_of_an_effect_that_is_off_change_no_bit(shared):
    """Frequency, damping and phase of a mode without gain and of chatter without amplitude; a negative zero."""
    idle = {"structural_mode.frequency": 3.0, "structural_mode.damping": 0.7, "chatter.frequency": 1.0, "chatter.phase": 1.0,
            "dead_zone.half_width": -0.0, "backlash.gap": -0.0, "delay.time": -0.0, "quantisation.step": -0.0}  # fmt: skip
    shared.restart()
    untouched = go(shared, 2)
    shared.restart(idle)
    assert np.array_equal(go(shared, 2), untouched)


@pytest.mark.parametrize("order", bact.ORDERS)
def test_limits_that_are_never_reached_do_nothing(shared, order):
    """Not neutral, so the loop checks for them; 1e-12 of the peak for the rounding of these checks."""
    out_of_reach = {"rate_limit.up": 1e7, "rate_limit.down": 1e7, "acceleration_limit.value": 5e8, "position_limit.min": -1e3,
                    "position_limit.max": 1e3, "command_limit.min": -1e3, "command_limit.max": 1e3}  # fmt: skip
    for s in bact.SETS:
        shared.restart(selection(s, order))
        untouched = go(shared, 3)
        shared.restart(selection(s, order, **out_of_reach))
        difference = np.abs(go(shared, 3) - untouched).max(axis=0)
        assert (difference <= 1e-12 * np.abs(untouched).max(axis=0)).all(), s.name
