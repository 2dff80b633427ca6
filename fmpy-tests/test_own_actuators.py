"""User-defined actuators: their FMUs state their provenance, and several run as one system in other importers."""

import tomllib
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import bact
from actuator_fmu import Actuator, unpacked
from other_importers import NotHere, positions_from
from own_actuators import PERIOD_S, UNITS, actuator, model_file, read_csv, sweep, write_csv

NAME, DESCRIPTION = "Rudder servo <A>", "Rudder servo of the test rig & its horn"


@pytest.fixture(scope="module")
def rudder(fmu_path, tmp_path_factory):
    """A second-order model in mm without p, with backlash and provenance, as an FMU."""
    folder = tmp_path_factory.mktemp("rudder")
    model = model_file(folder / "rudder.toml", "mm", gap_share=0.1, name=NAME, description=DESCRIPTION)
    text = '[provenance]\nrecords = ["chirp_1A.csv"]\nhashes = ["ab12cd"]\nmethod = "by hand"\ndate = "2026-05-01"\n'
    model.write_text(model.read_text() + text)
    actuator("build", "--model", model, "-o", folder / "rudder.fmu", "--from", fmu_path)
    return folder / "rudder.fmu"


def test_an_fmu_bears_the_name_and_the_description_of_its_model(rudder):
    assert validate_fmu(str(rudder)) == []
    description = fmpy.read_model_description(str(rudder))
    assert (description.modelName, description.description) == (NAME, DESCRIPTION)
    assert description.coSimulation.modelIdentifier == "BactActuator"  # the binary's


def test_its_page_holds_its_own_numbers_effects_unit_and_provenance(rudder):
    with zipfile.ZipFile(rudder) as archive:
        page = archive.read("documentation/index.html").decode()
        names = archive.namelist()
        model = tomllib.loads(archive.read("resources/model.toml").decode())
    for words in ("Rudder servo &lt;A&gt;", "Rudder servo of the test rig &amp; its horn", "<code>backlash.gap</code>", "mm/mm"):
        assert words in page, words
    for words in ("0.95", "60", "chirp_1A.csv", "ab12cd", "by hand", "2026-05-01", "1/mm2", "second"):
        assert words in page, words
    for words in ("BACT", "te-early-unloaded", "297000000", "deg"):
        assert words not in page, words
    assert not [name for name in names if name.startswith("extra/")]
    assert "p" not in model["base"] and model["model"] == {"name": NAME, "description": DESCRIPTION, "unit": "mm"}


def test_another_name_or_unit_is_another_model(fmu_path, tmp_path):
    """The binary reads the model file, so that the GUID of one does not instantiate the other."""
    guids = set()
    for index, (name, unit) in enumerate((("a", "mm"), ("b", "mm"), ("a", "m"))):
        model = model_file(tmp_path / f"{index}.toml", unit, name=name)
        actuator("build", "--model", model, "-o", tmp_path / f"{index}.fmu", "--from", fmu_path)
        guids.add(fmpy.read_model_description(str(tmp_path / f"{index}.fmu")).guid)
    assert len(guids) == 3


def test_a_file_without_a_name_is_called_like_the_file_and_a_set_like_the_set(fmu_path, tmp_path):
    model = model_file(tmp_path / "elevator.toml", "deg")
    for source, name, words in (
        (model, "elevator", "Identified actuator of second order, positions in deg"),
        ("us-late-loaded", "us-late-loaded", "Upper-spoiler actuator of the BACT wind-tunnel model, late in the test, loaded"),
    ):
        actuator("build", "--model", source, "-o", tmp_path / f"{name}.fmu", "--from", fmu_path)
        description = fmpy.read_model_description(str(tmp_path / f"{name}.fmu"))
        assert description.modelName == name and words in description.description


def test_the_default_fmu_is_still_that_of_the_report(fmu_path):
    description = fmpy.read_model_description(str(fmu_path))
    assert description.modelName == "BactActuator" and "BACT" in description.description


def test_the_model_of_another_fmu_is_refused_by_the_binary(rudder, tmp_path):
    """Only the name in the model file differs: the GUID does not match, and the log says so."""
    changed = tmp_path / "changed.fmu"
    with zipfile.ZipFile(rudder) as source, zipfile.ZipFile(changed, "w") as target:
        for entry in source.infolist():
            data = source.read(entry)
            if entry.filename == "resources/model.toml":
                data = data.replace(b"Rudder servo <A>", b"Rudder servo <B>")
            target.writestr(entry, data)
    with unpacked(changed) as package, pytest.raises(Exception, match="instantiate"):
        Actuator(package)


def expected(model, unit, commands, folder):
    """Positions of the internal model after each step."""
    time = np.arange(len(commands) + 1) * PERIOD_S
    source = write_csv(folder / f"{model.stem}-command.csv", time=time, command=[*commands, commands[-1]])
    actuator("simulate", model, source, "-o", folder / f"{model.stem}-response.csv", "--force")
    return read_csv(folder / f"{model.stem}-response.csv")["position"][1:]


@pytest.fixture(scope="module")
def pair(fmu_path, tmp_path_factory):
    """A system of two actuators, commands for both, and the expected response of each."""
    folder = tmp_path_factory.mktemp("pair")
    models = {
        "Rudder": (model_file(folder / "rudder.toml", "mm", gap_share=0.1, name="Rudder"), "mm"),
        "Elevator": (model_file(folder / "elevator.toml", "rad", name="Elevator", order=3, omega=90.0), "rad"),
    }
    system = folder / "tail.ssp"
    options = ["--model", models["Rudder"][0], "--model", models["Elevator"][0], "--from", fmu_path]
    said = actuator("build", "--ssp", system, *options)
    assert "component `Rudder`" in said and "component `Elevator`" in said and "positions in rad" in said
    _, command = sweep(1.0, 1.0)
    commands = {name: list(share * UNITS[unit][0] * command) for share, (name, (_, unit)) in zip((1, -0.7), models.items())}
    answers = {name: expected(model, unit, commands[name], folder) for name, (model, unit) in models.items()}
    return system, commands, answers


@pytest.mark.parametrize("script", ["import_with_libcosim.py", "import_with_ecos.py"])
def test_two_own_actuators_run_as_one_system(pair, tmp_path, script):
    system, commands, answers = pair
    try:
        [measured] = positions_from(script, system, tmp_path, [{"commands": commands, "set": None}])
    except NotHere as reason:
        pytest.skip(str(reason))
    for name, answer in answers.items():
        assert np.abs(measured[name] - answer).max() <= 1e-12 * np.abs(answer).max(), name


@pytest.mark.parametrize("script", ["import_with_libcosim.py", "import_with_ecos.py"])
def test_an_own_actuator_runs_beside_a_tabulated_set(fmu_path, tmp_path, script):
    model = model_file(tmp_path / "rudder.toml", "mm", name="Rudder")
    system = tmp_path / "both.ssp"
    actuator("build", "--ssp", system, "--model", model, "--set", "us-late-loaded", "--from", fmu_path)
    _, command = sweep(1.0, 1.0)
    commands = {"Rudder": list(4.0 * command), "actuator": list(2.0 * command)}
    try:
        [measured] = positions_from(script, system, tmp_path, [{"commands": commands, "set": "us-late-loaded"}])
    except NotHere as reason:
        pytest.skip(str(reason))
    exact = bact.respond(bact.BY_NAME["us-late-loaded"], bact.THIRD, commands["actuator"], PERIOD_S)[:, 1]
    assert np.abs(measured["actuator"] - exact).max() <= 1e-9
    own = expected(model, "mm", commands["Rudder"], tmp_path)
    assert np.abs(measured["Rudder"] - own).max() <= 1e-12 * np.abs(own).max()


def test_the_system_is_valid_and_holds_both_fmus_with_their_units(pair):
    from fmpy.ssp.ssd import read_ssd

    system, _, _ = pair
    components = read_ssd(str(system)).system.elements
    assert [component.name for component in components] == ["Rudder", "Elevator"]
    with zipfile.ZipFile(system) as archive:
        names = archive.namelist()
        text = archive.read("SystemStructure.ssd").decode()
    assert sorted(names) == ["SystemStructure.ssd", "resources/Elevator.fmu", "resources/Rudder.fmu"]
    for unit in ("mm", "mm/s", "rad", "rad/s"):
        assert f'<ssc:Unit name="{unit}">' in text, unit


def test_several_models_without_a_system_are_refused(tmp_path):
    model = model_file(tmp_path / "rudder.toml", "mm")
    message = actuator("build", "--model", model, "--model", model, "-o", tmp_path / "a.fmu", succeeds=False)
    assert "--ssp" in message


def test_what_is_wrong_in_a_model_file_is_refused_with_file_line_and_remedy(fmu_path, tmp_path):
    model = model_file(tmp_path / "rudder.toml", "mm")
    text = model.read_text()
    for found, instead, words in (
        ("order = 2", "order = 3", ["rudder.toml:3: base.p: found nothing", "or set order = 2"]),
        ("mm/mm", "deg/deg", ["rudder.toml:5: unit of base.k", "`mm/mm`, since positions are in mm", "convert"]),
        ("zeta =", "damping =", ["rudder.toml:7: model file: found unknown field `damping`", "allowed:", "correct"]),
    ):
        model.write_text(text.replace(found, instead))
        message = actuator("build", "--model", model, "-o", tmp_path / "a.fmu", "--from", fmu_path, succeeds=False)
        for part in words:
            assert part in message, message
