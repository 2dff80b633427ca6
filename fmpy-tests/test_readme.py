"""The README: every block of commands in order, as one shell session, has the results stated in the text."""

import os
import re
import subprocess

import pytest

from actuator_fmu import DEFAULT_FMU, REPOSITORY
from hidden import product

# Excluded: commands that run this test, and those that compile. The program is the one under test.
NOT_HERE = ("./demo", ".venv/bin/python")
BUILD = 'cargo build --release && export PATH="$PWD/target/release:$PATH"'
FOLDER = "/tmp/first"


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("readme")
    text = (REPOSITORY / "README.md").read_text()
    blocks = [block for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) if not block.startswith(NOT_HERE)]
    assert BUILD in blocks[0] and FOLDER in blocks[0], "the first block builds the program and goes to a folder"
    script = "\n".join(["set -eux", *blocks]).replace(BUILD, "true").replace(FOLDER, str(folder))
    assert "cargo" not in script
    environment = os.environ | {
        "PATH": f"{product.program().parent}{os.pathsep}{os.environ['PATH']}",
        "ACTUATOR_FMU": str(DEFAULT_FMU),
    }
    done = subprocess.run(["bash", "-c", script], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return folder, done.stdout


def test_records_lead_to_a_model(session):
    folder, said = session
    for name in ("response.csv", "us-late-loaded.toml", "load/compare.html", "inspection/inspection.html", "again.csv"):
        assert (folder / name).is_file(), name
    assert "predicts random.csv" in said


def test_the_play_is_named_with_its_size(session):
    folder, said = session
    gap = re.search(r"Missing: backlash \(gap ([0-9.]+) deg\)", said)
    assert gap and abs(float(gap[1]) - 0.15) < 0.002, said
    assert all((folder / "diagnosis" / name).is_file() for name in ("diagnosis.json", "report.html", "model.toml", "model.fmu"))


def test_comparison_and_campaign_leave_their_pages(session):
    folder, _ = session
    assert (folder / "comparison/figure-10.svg").is_file()
    assert (folder / "results/report.html").is_file() and (folder / "results/models/te-early-unloaded.toml").is_file()
