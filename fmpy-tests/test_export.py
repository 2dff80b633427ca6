"""Models in the languages of other simulators, which are run: the deviation of each from ours over the report's sweep.

`export_table.py` prints the complete table; tested here are all sets and effects in C, and some of each in JSBSim and MuJoCo.
"""

import pytest

from export_table import EFFECTS, KNOWN, SETS, export, model_with
from hidden import product
from own_actuators import actuator

pytestmark = product.needs_program()

EXACT = 1e-12  # C without effects in the loop: rounding
STEPPED = 2e-3  # C with them: ten microseconds
HALF_A_FRAME = 0.045  # JSBSim: filters by Tustin's rule, half a frame of a millisecond late, 2.2 deg at 12 Hz
WITHOUT_POLE = 0.01  # MuJoCo: 0.1 ms of the pole is omitted
CONSTRAINED = 0.05  # MuJoCo: stops are soft


def share(said):
    return said["deviation"]["share"]


@pytest.mark.parametrize("name", SETS)
def test_c_is_exact_for_every_set(tmp_path, name):
    said, text = export(name, "c", tmp_path)
    assert share(said) < EXACT, said
    assert "Largest deviation from ours over a sweep" in text and "compiled by" in text and name in text.splitlines()[0]


@pytest.mark.parametrize("effect", EFFECTS)
def test_c_knows_every_effect(tmp_path, effect):
    said, text = export(model_with(effect, tmp_path), "c", tmp_path)
    assert share(said) < STEPPED, said
    assert effect in text


@pytest.mark.parametrize("name", ["te-early-unloaded", "us-late-loaded"])
def test_jsbsim_flies_the_sets(tmp_path, name):
    pytest.importorskip("jsbsim")
    said, text = export(name, "jsbsim", tmp_path)
    assert share(said) < HALF_A_FRAME, said
    assert "JSBSim 1." in text and any("pole" in note for note in said["notes"])


@pytest.mark.parametrize("effect", KNOWN["jsbsim"])
def test_jsbsim_knows_its_effects(tmp_path, effect):
    pytest.importorskip("jsbsim")
    assert share(export(model_with(effect, tmp_path), "jsbsim", tmp_path)[0]) < HALF_A_FRAME


def test_mujoco_moves_a_set(tmp_path):
    pytest.importorskip("mujoco")
    said, text = export("te-early-unloaded", "mujoco", tmp_path)
    assert share(said) < WITHOUT_POLE and "MuJoCo" in text, said


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["hinge_load", "coulomb_friction", "position_limit"])
def test_mujoco_knows_its_effects(tmp_path, effect):
    pytest.importorskip("mujoco")
    assert share(export(model_with(effect, tmp_path), "mujoco", tmp_path)[0]) < CONSTRAINED


@pytest.mark.parametrize("target", KNOWN)
def test_what_a_target_cannot_express_is_refused_by_name(tmp_path, target):
    for effect in set(EFFECTS) - set(KNOWN[target]):
        path = tmp_path / "refused"
        message = actuator("export", model_with(effect, tmp_path), "--to", target, "-o", path, succeeds=False)
        assert effect in message and "FMU" in message and all(known in message for known in KNOWN[target]), message
        assert not path.exists()
    for effect in KNOWN[target]:
        actuator("export", model_with(effect, tmp_path), "--to", target, "-o", tmp_path / f"{effect}.{target}")


def test_what_was_not_run_says_so(tmp_path):
    said, text = export("us-late-loaded", "modelica", tmp_path, measured=False)
    assert said["deviation"] is None and "not measured" in text and "der(drive) = rate;" in text
    message = actuator("export", "us-late-loaded", "--to", "modelica", "--measure", "-o", tmp_path / "x", succeeds=False)
    assert "Modelica" in message and "which can be run" in message
    message = actuator("export", "us-late-loaded", "--to", "c", "--measure", tmp_path / "none", "-o", tmp_path / "x", succeeds=False)
    assert "Python" in message and not (tmp_path / "x").exists()
