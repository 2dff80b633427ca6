"""Laws of the nonlinear actuator for any command: symmetry, sticking, stops, limits, energy.

Equalities are bit for bit unless a tolerance is given: a stop is an exact number and a stuck drive does not creep.
"""

import numpy as np
import pytest

import effect_cases
from effect_cases import CHANNELS, EFFECTS
from reference import random_cases, simulate

COUNT = 10  # random cases per law
ONE_SIDED = "asymmetric_gain"
LOOP = ("dead_zone", "amplitude_gain", "hinge_load", "coulomb_friction", "acceleration_limit", "rate_limit", "position_limit")
FINE_S = 1e-4  # step for checks between the control computer's samples


def names_of(rng, effects, least=2):
    """Some of these effects, at least so many."""
    return [str(name) for name in rng.choice(effects, rng.integers(least, len(effects) + 1), replace=False)]


def show(case):
    print(case["base"], case["order"], case["effects"])
    return case


# Symmetry


def assert_mirrored(actuator, case):
    upright = effect_cases.run(actuator, case)
    inverted = effect_cases.run(actuator, effect_cases.mirrored(case))
    for channel in CHANNELS:
        if channel == "position" and "chatter" in case["effects"]:  # half a turn of its phase is subject to rounding
            assert np.abs(upright[channel] + inverted[channel]).max() <= 1e-12 * np.abs(upright[channel]).max()
        else:
            assert np.array_equal(upright[channel], -inverted[channel]), channel
    assert np.array_equal(upright["saturated"], inverted["saturated"])


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name != ONE_SIDED])
def test_an_actuator_upside_down_answers_upside_down(shared, rng, effect):
    """The negated command gives the negated position, with limits of the two sides exchanged and signs of loads and offsets changed."""
    for order in (2, 3):
        assert_mirrored(shared, show(effect_cases.draw(rng, [effect], rng.choice(effect_cases.COMMANDS), order)))


def test_many_effects_together_are_as_symmetric_as_each(shared, rng):
    """Without quantisation together with chatter, where a rounding would decide."""
    for _ in range(COUNT):
        names = names_of(rng, [name for name in EFFECTS if name not in (ONE_SIDED, "quantisation")], least=4)
        assert_mirrored(shared, show(effect_cases.draw(rng, names, hold=bool(rng.integers(2)))))


def test_the_one_sided_gain_mirrors_into_its_reciprocal(shared, rng):
    """k a(-c; r) = -k r a(c; 1/r): the ratio of the gains of negative and positive commands is inverted. 1e-12 of the peak."""
    for _ in range(COUNT):
        case = show(effect_cases.draw(rng, [ONE_SIDED]) | {"initial_position": 0.0})
        ratio, (k, *rest) = case["effects"][ONE_SIDED]["ratio"], case["base"]
        other = {**case, "command": -case["command"], "base": (k * ratio, *rest), "effects": {ONE_SIDED: {"ratio": 1 / ratio}}}
        one, two = (effect_cases.run(shared, c)["position"] for c in (case, other))
        assert np.abs(one + two).max() <= 1e-12 * np.abs(one).max()


# Sticking


def test_a_stuck_drive_has_no_rate_and_does_not_move_by_a_bit(shared, rng):
    """Wherever the reference sticks from one sample to the next."""
    stuck_samples = 0
    for _ in range(COUNT):
        case = show(effect_cases.draw(rng, ["coulomb_friction"], hold=bool(rng.integers(2))))
        case["effects"]["coulomb_friction"]["level"] = float(rng.uniform(0.2, 1.5))
        expected, found = simulate(**case), effect_cases.run(shared, case)
        stuck = (expected["rate"] == 0.0) & (expected["rate_after"] == 0.0)
        stays = stuck[:-1] & stuck[1:] & (np.diff(expected["drive"]) == 0.0)
        assert (found["rate"][stuck] == 0.0).all()
        assert (np.diff(found["deflection"])[stays] == 0.0).all()
        stuck_samples += stays.sum()
    assert stuck_samples > 20 * COUNT, "these commands never let it stick"


@pytest.mark.parametrize("order", ["second", "third"])
def test_what_friction_can_hold_never_moves(shared, rng, order):
    """Commands and loads within the level of friction: the drive stays at its start exactly, at all times."""
    level, start = 0.5, 0.7
    shared.restart({"order": order, "coulomb_friction.level": level, "initial_position": start})
    k = shared["active.k"]
    for _ in range(500):
        shared["command"] = (start + rng.uniform(-0.8, 0.8) * level) / k
        shared["load"] = rng.uniform(-0.1, 0.1) * level
        shared.step(rng.uniform(1e-5, 0.05))
        assert (shared["deflection"], shared["position"], shared["rate"]) == (start, start, 0.0)


# Stops and limits


@pytest.mark.parametrize("stop", [1.1, 2.0 / 3.0, 3.0])
@pytest.mark.parametrize("more", [{}, {"coulomb_friction.level": 0.2, "amplitude_gain.cubic": 0.01, "rate_limit.up": 90.0}])
def test_a_pushed_stop_holds_without_chatter(shared, rng, stop, more):
    """Exactly at the stop, exactly at rest, saturated, at every one of 2000 small steps; then it leaves the stop at once."""
    shared.restart({"position_limit.min": -stop, "position_limit.max": stop, **more})
    for side in (1.0, -1.0, 1.0):
        shared.run([side * 6.0], 0.2)
        for push in rng.uniform(4.0, 8.0, 2000):
            found = shared.run([side * push], FINE_S, outputs=("position", "deflection", "rate"))[0]
            assert (found == [side * stop, side * stop, 0.0]).all() and shared["saturated"]
        shared.run([0.0], 0.01)
        assert abs(shared["position"]) < stop


def test_limits_are_limits_at_every_instant(shared, rng):
    """Random loops evaluated every 0.1 ms: never beyond a stop, never faster than the rate limit; and both are reached."""
    touched = {"up": 0, "down": 0, "min": 0, "max": 0}
    for _ in range(COUNT):
        names = {"rate_limit", "position_limit", *names_of(rng, LOOP, 1)}
        case = show(effect_cases.draw(rng, names, rng.choice(effect_cases.COMMANDS)))
        rates, stops = case["effects"]["rate_limit"], case["effects"]["position_limit"]
        stops.update(min=float(rng.uniform(-1.5, -0.5)), max=float(rng.uniform(0.5, 1.5)))
        case.update(initial_position=0.0, command=case["command"] * 6.0 / np.abs(case["command"]).max())
        shared.restart(effect_cases.start_values(case))
        fine = np.repeat(case["command"][:100], 50)
        position, rate = shared.run(fine, FINE_S, outputs=("position", "rate")).T
        assert (rate <= rates["up"]).all() and (rate >= -rates["down"]).all()
        assert (position <= stops["max"]).all() and (position >= stops["min"]).all()
        touched["up"] += (rate == rates["up"]).sum()
        touched["down"] += (rate == -rates["down"]).sum()
        touched["max"] += (position == stops["max"]).sum()
        touched["min"] += (position == stops["min"]).sum()
    assert min(touched.values()) > 100, touched


def test_at_its_limit_the_rate_is_the_limit(shared, rng):
    """Without other limits, a rate exactly at the limit is `saturated`, as is one that was at the limit within the step."""
    for _ in range(COUNT):
        case = show(effect_cases.draw(rng, ["rate_limit"], rng.choice(effect_cases.COMMANDS), hold=bool(rng.integers(2))))
        found, limits = effect_cases.run(shared, case), case["effects"]["rate_limit"]
        at_limit = (found["rate"] == limits["up"]) | (found["rate"] == -limits["down"])
        assert (found["saturated"][at_limit] == 1.0).all() and at_limit.any()
        assert np.array_equal(simulate(**case)["saturated_within"], found["saturated"] == 1.0)


@pytest.mark.parametrize("number", range(COUNT))
def test_saturated_is_true_exactly_when_the_reference_says_so(shared, rng, number):
    """Three limits and any other effects, with loads and failures."""
    case = random_cases.draw(int(rng.integers(1 << 31)), 2)
    limits = random_cases.draw(int(rng.integers(1 << 31)), len(EFFECTS))["effects"]
    for name in ("rate_limit", "acceleration_limit", "position_limit"):
        case["effects"].setdefault(name, limits[name])
    show(case)
    expected, found = simulate(**case), effect_cases.run(shared, case)
    assert np.array_equal(found["saturated"] == 1.0, expected["saturated_within"])


@pytest.mark.parametrize("push", [0.0, 0.5, -0.1])
def test_a_start_on_a_stop_is_saturated_like_any_other_stay_there(shared, push):
    """From before the first step until a force points away from the stop: without any force the stop remains active."""
    time, k, stop = 0.005 * np.arange(10), 1.0198, 2.0
    case = effect_cases.draw(np.random.default_rng(0), []) | {"base": (k, 1e4, 165.26, 0.5624), "initial_position": stop}
    case.update(time=time, command=np.full(10, (stop + push) / k), effects={"position_limit": {"max": stop}})
    expected, found = simulate(**case), effect_cases.run(shared, case)
    assert np.array_equal(found["saturated"] == 1.0, expected["saturated_within"])


# Energy


def potential(effects, omega, d, passive):
    """Energy [deg^2/s^2] of the springs at d: drive through dead zone and saturation, cubic, hinge; the command is zero."""
    width, limit = effects["dead_zone"]["half_width"], effects["acceleration_limit"]["value"] / omega**2
    e = np.maximum(np.abs(d) - width, 0.0)
    drive = np.where(e <= limit, 0.5 * e**2, limit * (e - 0.5 * limit))
    hinge = 0.5 * effects["hinge_load"]["stiffness"] * d**2
    return omega**2 * ((0.0 if passive else drive) + 0.25 * effects["amplitude_gain"]["cubic"] * d**4 + hinge)


@pytest.mark.parametrize("failure", ["none", "passive"])
@pytest.mark.parametrize("number", range(COUNT // 2))
def test_energy_never_appears(shared, rng, number, failure):
    """All loop effects on, command and load zero, released away from rest: v^2/2 + potential never grows by more than 1e-12 of it per step.

    Friction, damping, limits and stops dissipate energy, springs conserve it. Second order: the pole stores none.
    """
    case = show(effect_cases.draw(rng, LOOP, order=2))
    case["effects"]["hinge_load"].update(bias=0.0, stiffness=abs(case["effects"]["hinge_load"]["stiffness"]))
    case["effects"]["amplitude_gain"]["cubic"] = abs(case["effects"]["amplitude_gain"]["cubic"])
    stops, omega = case["effects"]["position_limit"], case["base"][2]
    case["initial_position"] = float(rng.uniform(stops["min"], stops["max"]))
    shared.restart(effect_cases.start_values(case) | {"failure": failure})
    d, v = shared.run(np.zeros(3000), rng.uniform(1e-5, 1e-3, 3000), outputs=("deflection", "rate")).T
    energy = 0.5 * v**2 + potential(case["effects"], omega, d, failure == "passive")
    assert (np.diff(energy) <= 1e-12 * energy[0]).all()


def test_springs_keep_their_energy(shared, rng):
    """Without dissipation: half a second of oscillation through dead zone, cubic and hinge spring conserves energy to 1e-7."""
    for _ in range(COUNT):
        case = show(effect_cases.draw(rng, ["dead_zone", "amplitude_gain", "hinge_load", "acceleration_limit"], order=2))
        case["effects"]["hinge_load"].update(bias=0.0, stiffness=0.3)
        case["effects"]["amplitude_gain"]["cubic"] = 0.01
        case["base"], case["initial_position"] = (1.0, 1e4, case["base"][2], 0.0), 4.0
        shared.restart(effect_cases.start_values(case))
        d, v = shared.run(np.zeros(500), 1e-3, outputs=("deflection", "rate")).T
        energy = 0.5 * v**2 + potential(case["effects"], case["base"][2], d, False)
        assert np.abs(energy / energy[0] - 1.0).max() <= 1e-7 and np.abs(v).max() > 0.0
