"""Records that are no response to their command, or one in another unit: every command states the error, and names no effect.

Twelve kinds, drawn from seeds by `hidden/garbage.py`, and unrelated ones; through `inspect`, `frf`, `fit`, `diagnose` and `campaign`.
"""

import json
import subprocess

import pytest

from hidden import garbage, product

SEED = 7
SCALED = ("degrees_against_radians", "opposite_sign")  # still a response: a frequency response is possible, with a warning


@pytest.fixture(scope="module", params=garbage.PLAIN)
def spoiled(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    return request.param, folder, garbage.write(request.param, SEED, folder)


def run(folder, *arguments):
    return subprocess.run([product.program(), *arguments], cwd=folder, capture_output=True, text=True, timeout=garbage.TIME_LIMIT_S)


def names_cause(kind, text):
    return any(word in text.lower() for word in garbage.KINDS[kind][1])


def test_inspect_names_the_cause(spoiled):
    kind, folder, bundle = spoiled
    done = run(folder, "inspect", *bundle.files, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["verdict"] == ("usable with care" if kind in SCALED else "refused")
    for record in found["records"]:
        grave = [finding for finding in record["findings"] if finding["severity"] != "note"]
        assert any(names_cause(kind, finding["sentence"] + finding["remedy"]) for finding in grave), grave


def test_frf_refuses_or_warns(spoiled):
    kind, folder, bundle = spoiled
    done = run(folder, "frf", *bundle.fit, "--json", "-o", "response.csv")
    if kind in SCALED:
        assert done.returncode == 0 and names_cause(kind, " ".join(json.loads(done.stdout)["warnings"])), done
    else:
        refused(kind, done)
        assert not (folder / "response.csv").exists()


def test_fit_refuses_or_warns(spoiled):
    kind, folder, bundle = spoiled
    done = run(folder, "fit", *bundle.fit, "--json", "-o", "fit.toml")
    if kind == "degrees_against_radians":
        assert done.returncode == 0 and names_cause(kind, " ".join(json.loads(done.stdout)["warnings"])), done
    else:
        refused(kind, done)
        assert not (folder / "fit.toml").exists()


def test_diagnose_refuses(spoiled):
    kind, folder, bundle = spoiled
    done = run(folder, "diagnose", "--model", "model.toml", "--fit", *bundle.fit, "--check", *bundle.check, "-o", "diagnosis")
    refused(kind, done)
    assert not (folder / "diagnosis").exists()


@pytest.mark.slow
def test_campaign_lists_the_failure(spoiled):
    kind, folder, bundle = spoiled
    rows = [f'[[record]]\nfile = "{name}"\nsurface = "rig"\nstage = "new"\nload_case = "unloaded"\n' for name in bundle.files]
    (folder / "manifest.toml").write_text("\n".join(rows))
    done = run(folder, "campaign", "manifest.toml", "-o", "campaign", "--json", "--no-diagnosis")
    found = json.loads(done.stdout)
    for record in found["records"]:
        said = record["failure"] or " ".join(record["result"]["warnings"])
        assert names_cause(kind, said), said
        assert (record["result"] is None) == (kind != "degrees_against_radians")


def test_fit_judges_the_records_it_checks_on_as_well(tmp_path):
    """A record that is no response is refused there too, and a fit record is no check."""
    sound, crossed = tmp_path / "sound", tmp_path / "crossed"
    garbage.write("degrees_against_radians", SEED, sound)
    garbage.write("crossed", SEED, crossed)
    done = run(tmp_path, "fit", "sound/sweep.csv", "--check", "crossed/sweep.csv")
    refused("crossed", done)
    again = run(tmp_path, "fit", "sound/sweep.csv", "--check", "sound/sweep.csv", "--json")
    assert again.returncode == 0 and any("same data" in warning for warning in json.loads(again.stdout)["warnings"]), again


def test_a_copy_of_a_fitted_record_checks_nothing_in_a_diagnosis(tmp_path):
    """Neither the same file nor one with the same samples: the diagnosis is that without it, and says so."""
    garbage.write("degrees_against_radians", SEED, sound := tmp_path / "sound")
    fit = sorted(str(path) for path in sound.glob("*.csv"))[:2]
    rows = (tmp_path / fit[0]).read_text().splitlines()
    (tmp_path / "again.csv").write_text("\n".join([rows[0], *(row + " " for row in rows[1:])]) + "\n")
    run(tmp_path, "fit", *fit, "-o", "model.toml")
    told = []
    for number, check in enumerate(([], [fit[0]], ["again.csv", fit[1]])):
        checks = ["--check", *check] if check else []
        done = run(tmp_path, "diagnose", "--model", "model.toml", "--fit", *fit, *checks, "-o", f"out{number}", "--json")
        assert done.returncode == 0, done.stderr
        found = json.loads(done.stdout)
        left_out = [warning for warning in found["warnings"] if "left out of the checks" in warning]
        assert len(left_out) == len(check), found["warnings"]
        told.append((found["verdict"], found["sentence"], found["gap"]))
    assert told[1] == told[0] and told[2] == told[0]


def refused(kind, done):
    assert done.returncode == 2, done.stdout
    assert names_cause(kind, done.stderr), done.stderr
    assert ".csv" in done.stderr  # which record
