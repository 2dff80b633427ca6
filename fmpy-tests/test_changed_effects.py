"""An effect that the given model already has, at another strength: wear, with an earlier diagnosed model as the baseline; and a limit with a side that is
never reached.

The records come from the plant of the hidden-effect suite, which shares no code with the product.
"""

import numpy as np
import pytest

from hidden import excitation, plant, product
from hidden.bundle import Bundle, model_text, write

BASE, ORDER, DURATION_S, PEAK_DEG = (1.08, 9600.0, 75.0, 0.6), 3, 15.0, 3.0
NOISE = 0.01
UNIT = {"gap": "deg", "time": "s", "level": "deg", "up": "deg/s", "down": "deg/s", "min": "deg", "max": "deg"}
# The given model, and the true effects.
CHANGES = {
    "play that has grown fourfold": ({"backlash": {"gap": 0.1}}, {"backlash": {"gap": 0.4}}),
}
MORE_CHANGES = {
    "a rate limit that is met no more": ({"rate_limit": {"up": 60.0, "down": 60.0}}, {}),
    "a delay three times as long": ({"delay": {"time": 0.004}}, {"delay": {"time": 0.012}}),
    "stops that came nearer": ({"position_limit": {"min": -3.1, "max": 3.1}}, {"position_limit": {"min": -2.0, "max": 2.0}}),
    "play that has grown, and a limit": ({"backlash": {"gap": 0.1}}, {"backlash": {"gap": 0.3}, "rate_limit": {"up": 60.0, "down": 60.0}}),
}
TOLERANCE = 0.05
SAME = {"backlash": {"gap": 0.1}, "delay": {"time": 0.004}}

pytestmark = product.needs_program()


def diagnosis_of(given, acting, folder, seed=5):
    rng = np.random.default_rng(seed)
    time = excitation.time(DURATION_S)
    files = {}
    for name in ("sweep", "random", "multisine"):
        command = excitation.command(rng, name, time, PEAK_DEG, quiet=True)
        position = plant.simulate(BASE, acting, time, command, order=ORDER) + NOISE * rng.standard_normal(len(time))
        files[f"{name}.csv"] = {"time": time, "command": command, "position": position}
    effects = [
        f"[effects.{effect}]\n" + "".join(f'{name} = {{ value = {value}, unit = "{UNIT[name]}" }}\n' for name, value in values.items())
        for effect, values in given.items()
    ]
    case = Bundle(files, ["sweep.csv", "random.csv"], ["multisine.csv"], model_text(BASE, ORDER) + "\n" + "".join(effects), {})
    write(case, folder)
    return product.diagnose(product.program(), folder, arguments=case.arguments)[0]


@pytest.mark.parametrize("change", [*CHANGES, *product.slow(*MORE_CHANGES)])
def test_an_effect_of_the_given_model_is_named_with_its_strength_and_what_that_was(change, tmp_path):
    given, acting = (CHANGES | MORE_CHANGES)[change]
    said = diagnosis_of(given, acting, tmp_path)
    assert said["verdict"] == "named", said["sentence"]
    found = {effect["name"]: effect["parameters"] for effect in said["effects"]}
    assert found.keys() == given.keys() | acting.keys()
    for effect, parameters in found.items():
        for name, parameter in parameters.items():
            assert parameter.get("was") == given.get(effect, {}).get(name)
            if effect in acting:
                assert parameter["value"] == pytest.approx(acting[effect][name], rel=TOLERANCE)
            else:
                assert parameter["value"] == 1e9, "a limit that does not act is none"
    assert said["sentence"].startswith("Changed: " if given.keys() >= acting.keys() else "Missing or changed: ")
    assert said["gap"]["closed"] > 0.99


def test_nothing_is_said_of_effects_of_the_given_model_that_are_as_they_were(tmp_path):
    assert diagnosis_of(SAME, SAME, tmp_path)["verdict"] == "nothing_missing"


@pytest.mark.slow
def test_a_side_of_a_limit_that_no_record_meets_is_none(tmp_path):
    said = diagnosis_of({}, {"command_limit": {"max": 2.0}}, tmp_path)
    (found,) = said["effects"]
    assert (said["verdict"], found["name"]) == ("named", "command_limit"), said["sentence"]
    assert found["parameters"]["max"]["value"] == pytest.approx(2.0, rel=TOLERANCE)
    assert found["parameters"]["min"]["value"] == -1e9 and "min" not in said["sentence"]
