"""Parameters of effects tuned between steps: they apply from the next step on, and only physically possible jumps occur."""

import numpy as np
import pytest

import bact
import effect_cases
from effect_cases import EFFECTS
from reference.plant import NEUTRAL

OUTPUTS = ("position", "deflection", "rate")
LINEAR = 1e-9  # relative: where the motion has a closed form
NANOSECOND, FASTEST_DEG_S, HARDEST_DEG_S2 = 1e-9, 3e3, 3e6  # more than omega and omega^2 times 8 deg for any tabulated set
AT_REST_EVERYWHERE = [name for name in EFFECTS if name != "hinge_load"]  # a steady load moves the drive from the start


@pytest.mark.parametrize("effect", AT_REST_EVERYWHERE)
def test_an_effect_tuned_at_rest_is_an_effect_set_from_the_start(shared, rng, effect):
    """Zero is an equilibrium with any of them: then the instant at which a parameter is set does not matter. Drifts count from the start."""
    case = effect_cases.draw(rng, [effect]) | {"initial_position": 0.0}
    values, rest = effect_cases.dotted(case["effects"]), np.zeros(20)
    shared.restart(effect_cases.start_values(case))
    shared.run(rest, 0.005)
    expected = shared.run(case["command"], 0.005, outputs=OUTPUTS)
    shared.restart(effect_cases.start_values(case | {"effects": {}}))
    shared.run(rest, 0.005)
    shared.set(values)
    assert np.abs(shared.run(case["command"], 0.005, outputs=OUTPUTS) - expected).max() <= 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("effect", effect_cases.EFFECTS[7:14])
def test_an_effect_of_the_loop_taken_back_in_motion_leaves_the_linear_motion(shared, rng, effect):
    """From the next step on, without a jump. Second order: position and rate are the complete state, so there is a closed form."""
    s = bact.SETS[rng.integers(len(bact.SETS))]
    case = effect_cases.draw(rng, [effect], order=2) | {"base": (s.k, s.p, s.omega, s.zeta)}
    shared.restart(effect_cases.start_values(case))
    effect_cases.go_on(shared, case, 0, last=33)
    before = [shared[name] for name in OUTPUTS]
    shared.set(effect_cases.dotted({effect: NEUTRAL[effect]}))
    assert [shared[name] for name in OUTPUTS] == before
    commands = rng.uniform(-5, 5, 40)
    found = shared.run(commands, 0.005, outputs=("position", "rate"))
    exact = bact.respond(s, bact.SECOND, commands, 0.005, state=np.array([0.0, before[0], before[2]]))[:, 1:]
    assert (np.abs(found - exact).max(axis=0) <= LINEAR * np.abs(exact).max(axis=0)).all()


@pytest.mark.parametrize("effect", EFFECTS)
def test_tuning_moves_the_surface_by_no_jump(shared, rng, effect):
    """In mid-motion to other strengths and back to neutral: a nanosecond later the drive position is unchanged.

    Necessary jumps are allowed: a nearer stop displaces the drive, a narrower play the surface, a mode's gain its share.
    """
    may_jump = {"position_limit": OUTPUTS, "rate_limit": "rate", "backlash": "deflection", "structural_mode": "deflection"}
    for values in (effect_cases.draw(rng, [effect])["effects"], NEUTRAL):
        case = effect_cases.draw(rng, [effect], "swept", order=2) | {"initial_position": 0.0}
        shared.restart(effect_cases.start_values(case))
        effect_cases.go_on(shared, case, 0, last=int(rng.integers(20, 150)))
        before = {name: shared[name] for name in OUTPUTS}
        shared.set(effect_cases.dotted({effect: values[effect]}))
        shared.step(NANOSECOND)
        for name, bound in (("deflection", NANOSECOND * FASTEST_DEG_S), ("rate", NANOSECOND * HARDEST_DEG_S2)):
            if name not in may_jump.get(effect, ()):
                assert abs(shared[name] - before[name]) <= bound, (name, case["effects"], values[effect])
