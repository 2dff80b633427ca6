"""Records and models in rad, mm, m, deg and numbers without unit: from a record to the FMU, in that unit throughout."""

import json
import tomllib

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from actuator_fmu import Actuator, unpacked
from own_actuators import PERIOD_S, UNITS, actuator, model_file, read_csv, sweep, write_csv

every_unit = pytest.mark.parametrize("unit", UNITS)
NOISE_SHARE = 0.01


@pytest.fixture(scope="module")
def identified(fmu_path, tmp_path_factory):
    """unit -> record, fitted model and its FMU, each made once."""
    made = {}

    def make(unit):
        if unit not in made:
            folder = tmp_path_factory.mktemp("unit")
            size = UNITS[unit][0]
            time, command = sweep(size)
            write_csv(folder / "command.csv", time=time, command=command)
            truth = model_file(folder / "truth.toml", unit, order=3)
            actuator("simulate", truth, folder / "command.csv", "-o", folder / "response.csv")
            position = read_csv(folder / "response.csv")["position"]
            noise = np.random.default_rng(208452).normal(scale=NOISE_SHARE * size, size=len(time))
            record = write_csv(folder / "record.csv", time=time, command=command, position=position + noise)
            fit = json.loads(actuator("fit", record, "--unit", unit, "-o", folder / "servo.toml", "--json"))
            actuator("build", "--model", folder / "servo.toml", "-o", folder / "servo.fmu", "--from", fmu_path)
            made[unit] = folder, fit
        return made[unit]

    return make


def units_of(description):
    return {v.name: v.unit for v in description.modelVariables if v.unit}


@every_unit
def test_the_fmu_of_a_record_predicts_it_to_the_noise_in_its_unit(identified, unit):
    folder, fit = identified(unit)
    record = read_csv(folder / "record.csv")
    with unpacked(folder / "servo.fmu") as package, Actuator(package) as fmu:
        measured = fmu.initialize().run(record["command"][:-1], PERIOD_S)
    left = record["position"][1:] - measured
    noise = NOISE_SHARE * UNITS[unit][0]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(noise, rel=0.05)
    assert fit["unit"] == unit and fit["residual_rms"] == pytest.approx(noise, rel=0.05)
    assert {e["name"]: e["unit"] for e in fit["estimates"]}["k"] == f"{unit}/{unit}"


@every_unit
def test_fit_says_the_same_in_every_unit(identified, unit):
    """The same motion, scaled: numbers whose unit contains no position are the same."""
    base = tomllib.loads((identified(unit)[0] / "servo.toml").read_text())["base"]
    same = tomllib.loads((identified("deg")[0] / "servo.toml").read_text())["base"]
    assert base["k"]["unit"] == f"{unit}/{unit}"
    for name in ("k", "omega", "zeta"):
        assert base[name]["value"] == pytest.approx(same[name]["value"], rel=1e-6)


@every_unit
def test_the_description_is_valid_and_its_units_are_those_of_the_model(identified, unit):
    path = identified(unit)[0] / "servo.fmu"
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    spelled = units_of(description)
    for name, expected in {
        "command": unit,
        "load": unit,
        "position": unit,
        "deflection": unit,
        "rate": f"{unit}/s",
        "initial_position": unit,
        "custom.k": f"{unit}/{unit}",
        "active.k": f"{unit}/{unit}",
        "custom.omega": "rad/s",
        "backlash.gap": unit,
        "rate_limit.up": f"{unit}/s",
        "acceleration_limit.value": f"{unit}/s2",
        "amplitude_gain.cubic": "1" if unit == "1" else f"1/{unit}2",
        "sensor_bias.drift": f"{unit}/s",
        "chatter.phase": "rad",
        "chatter.frequency": "Hz",
        "drive.position": unit,
        "der(drive.rate)": f"{unit}/s2",
    }.items():
        assert spelled[name] == expected, name
    if unit != "deg":
        assert not [name for name in spelled.values() if "deg" in name]
    m, s, rad, factor = UNITS[unit][1]
    for suffix, seconds in {"": 0, "/s": -1, "/s2": -2}.items():
        base = next(u for u in description.unitDefinitions if u.name == unit + suffix).baseUnit
        assert (base.m, base.s, base.rad, base.factor) == (m, s + seconds, rad, pytest.approx(factor))
    display = {"rad": "deg", "m": "mm"}.get(unit)
    assert next(v for v in description.modelVariables if v.name == "position").displayUnit == display


def test_what_is_displayed_is_the_value_in_the_display_unit(identified):
    for unit, display, value, shown in (("rad", "deg", np.pi, 180.0), ("m", "mm", 0.004, 4.0)):
        description = fmpy.read_model_description(str(identified(unit)[0] / "servo.fmu"))
        units = next(u for u in description.unitDefinitions if u.name == unit).displayUnits
        factor = next(d for d in units if d.name == display).factor
        assert factor * value == pytest.approx(shown)


@every_unit
def test_a_diagnosis_names_the_effect_in_the_unit_of_the_record(identified, fmu_path, tmp_path, unit):
    """A gap of a tenth of the motion, absent from the model, which was fitted without it."""
    folder, _ = identified(unit)
    size = UNITS[unit][0]
    records = []
    for name, duration_s, seed in (("fit", 20.0, 1), ("check", 15.0, 2)):
        time, command = sweep(size, duration_s)
        source = write_csv(tmp_path / f"{name}-command.csv", time=time, command=command)
        hidden = model_file(tmp_path / "hidden.toml", unit, gap_share=0.1, order=3)
        actuator("simulate", hidden, source, "-o", tmp_path / f"{name}-response.csv")
        position = read_csv(tmp_path / f"{name}-response.csv")["position"]
        noise = np.random.default_rng(seed).normal(scale=NOISE_SHARE * size, size=len(time))
        records.append(write_csv(tmp_path / f"{name}.csv", time=time, command=command, position=position + noise))
    fit, check = records
    options = ["--fit", fit, "--check", check, "--unit", unit, "--from", fmu_path, "-o", tmp_path / "d", "--json"]
    said = json.loads(actuator("diagnose", "--model", folder / "servo.toml", *options))
    assert [effect["name"] for effect in said["effects"]] == ["backlash"], said["sentence"]
    gap = said["effects"][0]["parameters"]["gap"]
    assert gap["unit"] == unit and gap["value"] == pytest.approx(0.1 * size, rel=0.05)
    assert said["unit"] == unit
    model = tomllib.loads((tmp_path / "d" / "model.toml").read_text())
    assert model["model"]["unit"] == unit and model["model"]["name"] == "servo"
    assert model["effects"]["backlash"]["gap"]["unit"] == unit
    assert units_of(fmpy.read_model_description(str(tmp_path / "d" / "model.fmu")))["backlash.gap"] == unit
    if unit in ("mm", "m", "1"):
        words = said["sentence"] + " ".join(place["sentence"] for place in said["where"])
        assert " deg" not in words, words


def rewritten(record, path, factor):
    columns = read_csv(record)
    for name in ("command", "position"):
        columns[name] = columns[name] * factor
    return write_csv(path, **columns)


def test_a_record_of_the_same_kind_is_converted_and_that_is_said(identified, fmu_path, tmp_path):
    for unit, other, factor in (("rad", "deg", 180 / np.pi), ("m", "mm", 1e3)):
        folder, _ = identified(unit)
        record = rewritten(folder / "record.csv", tmp_path / f"record-{other}.csv", factor)
        options = ["--unit", other, "--from", fmu_path, "-o", tmp_path / f"d-{other}", "--json"]
        said = json.loads(actuator("diagnose", "--model", folder / "servo.toml", "--fit", record, *options))
        assert said["unit"] == unit
        assert any(f"records in {other} were converted to {unit}" in note for note in said["notes"]), said["notes"]
        assert said["gap"]["noise_rms"] == pytest.approx(NOISE_SHARE * UNITS[unit][0], rel=0.1)


def test_a_record_in_rad_goes_with_a_tabulated_set_in_deg(fmu_path, tmp_path):
    time, command = sweep(2.0)
    source = write_csv(tmp_path / "command.csv", time=time, command=command)
    actuator("simulate", "te-early-unloaded", source, "-o", tmp_path / "response.csv")
    position = read_csv(tmp_path / "response.csv")["position"]
    position = position + np.random.default_rng(3).normal(scale=0.02, size=len(time))
    record = write_csv(tmp_path / "rad.csv", time=time, command=np.radians(command), position=np.radians(position))
    options = ["--unit", "rad", "--from", fmu_path, "-o", tmp_path / "d", "--json"]
    said = json.loads(actuator("diagnose", "--model", "te-early-unloaded", "--fit", record, *options))
    assert said["verdict"] == "nothing_missing" and said["unit"] == "deg"
    assert said["gap"]["noise_rms"] == pytest.approx(0.02, rel=0.1)


def test_records_of_one_condition_in_rad_and_in_deg_are_fitted_together(identified, tmp_path):
    """In a campaign: in the unit of the first, which the result states. A length among them is refused, naming its file."""
    folder, fit = identified("rad")
    rewritten(folder / "record.csv", tmp_path / "deg.csv", 180 / np.pi)
    record = '[[record]]\nfile = "{}"\nname = "{}"\nsurface = "rudder"\nstage = "new"\nload_case = "unloaded"\nunit = "{}"\n'
    first = record.format(folder / "record.csv", "one", "rad")
    (tmp_path / "both.toml").write_text(first + record.format(tmp_path / "deg.csv", "other", "deg"))
    said = json.loads(actuator("campaign", tmp_path / "both.toml", "-o", tmp_path / "both", "--json"))
    assert "records in deg were converted to rad" in json.dumps(said)
    model = tomllib.loads((tmp_path / "both" / "models" / "rudder-new-unloaded.toml").read_text())
    omega = {e["name"]: e["value"] for e in fit["estimates"]}["omega"]
    assert model["model"] == {"name": "rudder-new-unloaded", "unit": "rad"}
    assert model["base"]["omega"]["value"] == pytest.approx(omega, rel=1e-3)
    (tmp_path / "wrong.toml").write_text(first + record.format(tmp_path / "deg.csv", "other", "mm"))
    said = actuator("campaign", tmp_path / "wrong.toml", "-o", tmp_path / "wrong", "--json")
    assert "mm, a length, against rad, an angle" in said


def test_a_length_against_an_angle_is_refused_with_both(identified, fmu_path, tmp_path):
    folder, _ = identified("mm")
    options = ["--unit", "mm", "--from", fmu_path, "-o", tmp_path / "d"]
    message = actuator(
        "diagnose", "--model", "te-early-unloaded", "--fit", folder / "record.csv", *options, succeeds=False
    )
    for words in ("record.csv", "mm, a length", "deg, an angle", "--unit"):
        assert words in message
    message = actuator("simulate", folder / "servo.toml", folder / "command.csv", "--unit", "rad", succeeds=False)
    assert "rad, an angle" in message and "mm, a length" in message


def test_simulate_converts_the_command_and_says_the_unit(identified):
    folder, _ = identified("m")
    command = read_csv(folder / "command.csv")
    source = write_csv(folder / "mm.csv", time=command["time"], command=1e3 * command["command"])
    own = json.loads(actuator("simulate", folder / "servo.toml", folder / "command.csv", "-o", folder / "o.csv", "--force", "--json"))
    options = ["--unit", "mm", "-o", folder / "c.csv", "--force", "--json"]
    converted = json.loads(actuator("simulate", folder / "servo.toml", source, *options))
    assert own["unit"] == converted["unit"] == "m"
    assert converted["peak_position"] == pytest.approx(own["peak_position"], rel=1e-12)
    assert any("from mm to m" in note for note in converted["notes"])
    text = actuator("simulate", folder / "servo.toml", folder / "command.csv", "-o", folder / "o.csv", "--force")
    assert f"peak position {own['peak_position']:.7f} m" in text, text


def test_simulate_with_an_fmu_works_in_the_unit_of_the_fmu(identified):
    """The model in mm, set in the FMU of the same actuator in m."""
    folder, _ = identified("m")
    text = (folder / "servo.toml").read_text().replace('"m"', '"mm"').replace('"m/m"', '"mm/mm"')
    (folder / "servo-mm.toml").write_text(text)
    one, other = folder / "one.csv", folder / "other.csv"
    options = ["--fmu", folder / "servo.fmu", "--force", "-o"]
    actuator("simulate", folder / "servo.toml", folder / "command.csv", *options, one)
    said = actuator("simulate", folder / "servo-mm.toml", folder / "command.csv", *options, other)
    assert "converted from mm to m" in said
    assert np.allclose(read_csv(one)["position"], read_csv(other)["position"], rtol=1e-12, atol=0)
