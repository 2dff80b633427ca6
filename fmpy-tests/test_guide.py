"""The guide is correct: its commands run, its links resolve, its plots are those of the FMU, no effect is missing."""

import json
import os
import re
import shutil
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest

from actuator_fmu import REPOSITORY
from hidden import product

GUIDE = REPOSITORY / "docs" / "guide"
sys.path.insert(0, str(GUIDE))

import effect_pictures  # noqa: E402

PAGES = sorted([*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"), *(REPOSITORY / "examples").rglob("*.md")])
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
PYTHON_BLOCKS = re.findall(r"^```python\n(.*?)^```", (GUIDE / "src" / "use-it-in.md").read_text(), flags=re.DOTALL | re.MULTILINE)
SETTLED_DEG = 1.0767  # k of us-late-loaded, table 2 of the report, after a step of 1 deg
PLAY_DEG = 0.05  # half the gap that one of the blocks sets; the servo settles to 1e-4 within 0.2 s
# A plot is 734 points wide. Rounding may move a point slightly on another processor; a twentieth of a point is invisible.
PICTURE_TOLERANCE = 0.05
NOISE_SHARE = 0.05  # allowed difference of the residual from the noise: 5000 samples determine it to 1 %, and the diagnosis skips the start


def without_code(text):
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def anchor(heading):
    """As in GitHub and mdBook: lower case, no punctuation, hyphens for blanks."""
    kept = (c for c in heading.strip().lower() if c in " -_" or unicodedata.category(c)[0] in "LN")
    return "".join(kept).replace(" ", "-")


def anchors(page):
    return {anchor(line.lstrip("#")) for line in without_code(page.read_text()).splitlines() if line.startswith("#")}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_every_relative_link_leads_to_a_file_and_a_heading(page):
    lost = []
    for link in LINK.findall(without_code(page.read_text())):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, heading = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or (heading and target.suffix == ".md" and heading not in anchors(target)):
            lost.append(link)
    assert not lost


def test_every_page_of_the_guide_is_in_its_summary():
    named = set(LINK.findall((GUIDE / "src" / "SUMMARY.md").read_text()))
    assert named == {page.name for page in (GUIDE / "src").glob("*.md")} - {"SUMMARY.md"}


@product.needs_program()
def test_every_effect_has_its_section_and_its_picture_in_the_order_of_the_chain():
    effects = json.loads(subprocess.run([product.program(), "effects", "--json"], capture_output=True, text=True, check=True).stdout)
    text = (GUIDE / "src" / "effects.md").read_text()
    names = [effect["name"] for effect in effects]
    assert re.findall(r"^### `(\w+)`$", text, flags=re.MULTILINE) == names
    assert re.findall(r"\(pictures/(\w+)\.svg\)", text) == names
    assert list(effect_pictures.SPECS) == names
    for effect in effects:
        spec = effect_pictures.SPECS[effect["name"]]
        assert {*spec.weak, *spec.strong} <= {parameter["name"] for parameter in effect["parameters"]}


@pytest.mark.slow
def test_the_pictures_are_those_that_the_fmu_draws(fmu_path):
    """`.venv/bin/python docs/guide/effect_pictures.py` redraws them."""
    for effect, drawn in effect_pictures.pictures(fmu_path).items():
        stored = (GUIDE / "src" / "pictures" / f"{effect}.svg").read_text()
        assert NUMBER.sub("#", drawn) == NUMBER.sub("#", stored), effect
        numbers = zip(NUMBER.findall(drawn), NUMBER.findall(stored), strict=True)
        assert all(a == b or abs(float(a) - float(b)) < PICTURE_TOLERANCE for a, b in numbers), effect


@pytest.mark.parametrize("block", PYTHON_BLOCKS, ids=lambda block: re.search(r"(?:import|from) (\w+)", block)[1])
def test_the_lines_for_an_importer_run_and_select_the_actuator(block, fmu_path, tmp_path):
    """Unchanged, from a folder with the layout of the repository."""
    (tmp_path / "target" / "fmu").mkdir(parents=True)
    (tmp_path / "target" / "fmu" / "BactActuator.fmu").symlink_to(fmu_path)
    run = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True)
    if "libtbb" in run.stderr:
        pytest.skip("ecospy needs libtbb.so.12 (Debian: apt install libtbb12)")
    assert run.returncode == 0, run.stderr
    # libcosim logs to the same stream.
    (position,) = re.findall(r"^-?\d+\.\d+$", run.stdout, flags=re.MULTILINE)
    assert float(position) == pytest.approx(SETTLED_DEG, abs=PLAY_DEG + 1e-3)


@pytest.fixture(scope="module")
def tutorial(tmp_path_factory):
    """The folder in which all commands of the tutorial ran, one after the other."""
    folder = tmp_path_factory.mktemp("tutorial")
    blocks = re.findall(r"^```sh\n(.*?)^```", (GUIDE / "src" / "tutorial.md").read_text(), flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 7
    (folder / "bin").mkdir()
    (folder / "bin" / "actuator").symlink_to(product.program())
    (folder / "work").mkdir()
    environment = os.environ | {"PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}", "LC_ALL": "C"}
    run = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", "\n".join(blocks)], cwd=folder / "work", env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return folder / "work"


@product.needs_program()
@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_the_tutorial_names_the_play_and_closes_the_gap(tutorial):
    diagnosis = json.loads((tutorial / "diagnosis" / "diagnosis.json").read_text())
    assert diagnosis["verdict"] == "named" and [effect["name"] for effect in diagnosis["effects"]] == ["backlash"]
    assert diagnosis["effects"][0]["parameters"]["gap"]["value"] == pytest.approx(0.12, abs=0.002)  # as in the tutorial
    left = {line.split(":")[0]: float(line.split()[1]) for line in (tutorial / "gap.txt").read_text().splitlines()}
    assert left["after"] == pytest.approx(diagnosis["gap"]["noise_rms"], rel=NOISE_SHARE)
    assert left["before"] > 2 * left["after"]
    assert left["after"] == pytest.approx(diagnosis["gap"]["after"]["check_rms"], rel=NOISE_SHARE)
    assert (tutorial / "corrected.fmu").read_bytes() == (tutorial / "diagnosis" / "model.fmu").read_bytes()
