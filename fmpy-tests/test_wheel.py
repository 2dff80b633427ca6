"""The wheel in an empty environment and an empty folder, with neither Rust nor a compiler on the PATH: from `pip install` to a diagnosis.

`./wheel --as-built` packs it from the program and the FMU that the other tests use; nothing is compiled for it.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
import venv
from pathlib import Path

import pytest

from actuator_fmu import REPOSITORY

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("cargo") is None, reason="no cargo here, which packs the wheel"),
]


class Environment:
    """A separate environment, with a working folder."""

    def __init__(self, folder):
        self.folder = folder / "work"
        self.folder.mkdir()
        self.programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        venv.create(folder / "venv", with_pip=True)
        # Only the package sources of the present environment.
        ways = {name: value for name, value in os.environ.items() if name.upper().startswith("PIP_") or name.upper().endswith("_PROXY")}
        self.variables = ways | {"PATH": str(self.programs), "HOME": str(folder)}

    def run(self, program, *arguments, code=0):
        done = subprocess.run(
            [str(self.programs / program), *map(str, arguments)], cwd=self.folder, env=self.variables, capture_output=True, text=True
        )
        assert done.returncode == code, f"{program} {arguments}\n{done.stdout}\n{done.stderr}"
        return done.stdout if code == 0 else done.stderr

    def python(self, text):
        return self.run("python", "-W", "error", "-c", textwrap.dedent(text))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    tools = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = ["bash", "./wheel", "--as-built", "--out", str(folder)]
    done = subprocess.run(command, cwd=REPOSITORY, env=os.environ | {"PATH": tools}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return next(folder.glob("actuator_fmu-*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    environment = Environment(tmp_path_factory.mktemp("installed"))
    environment.run("python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile", wheel)
    for name in ("cargo", "rustc", "cc", "gcc", "zig"):
        assert shutil.which(name, path=environment.variables["PATH"]) is None, name
    return environment


@pytest.fixture(scope="module")
def story(installed):
    """`actuator demo`: records of an actuator with play, its fit and its diagnosis."""
    return installed.run("actuator", "demo", "-o", "demo")


def test_the_program_is_on_the_path_and_tells_the_whole_story(installed, story):
    assert "Missing: backlash" in story, story
    found = {path.name for path in (installed.folder / "demo" / "diagnosis").iterdir()}
    assert {"diagnosis.json", "report.html", "model.toml", "model.fmu"} <= found


def test_the_program_builds_an_fmu_without_a_compiler(installed):
    installed.run("actuator", "build", "--model", "us-late-loaded", "-o", "us.fmu")
    assert (installed.folder / "us.fmu").stat().st_size > 100_000


def test_sets_and_fmu_are_there(installed):
    said = json.loads(
        installed.python(
            """
            import json, zipfile, actuator_fmu
            names = zipfile.ZipFile(actuator_fmu.fmu_path()).namelist()
            sets = actuator_fmu.sets()
            one = next(s for s in sets if s.name == "us-late-loaded")
            print(json.dumps([len(sets), one.k.value, one.k.unit, one.set_number, "modelDescription.xml" in names, actuator_fmu.__version__]))
            """
        )
    )
    assert said == [17, 1.0767, "deg/deg", 15, True, installed.run("actuator", "--version").split()[1]]


def test_arrays_become_a_fit_and_a_fit_a_diagnosis(installed, story):
    """As in a script: frames are tuples here, since pandas is not needed."""
    said = json.loads(
        installed.python(
            """
            import json, numpy as np, actuator_fmu as af
            read = lambda name: tuple(np.loadtxt(f"demo/{name}.csv", delimiter=",", skiprows=1, usecols=(0, 1, 2)).T)
            sweep, random, multisine = map(read, ("sweep", "random", "multisine"))
            fit = af.fit([sweep, random], check=multisine, order=2, name="servo")
            response = af.simulate(fit, sweep[0], sweep[1])
            found = af.diagnose(fit, [sweep, random], check=[multisine], output="from-python")
            gap = found.effects[0].parameters["gap"]
            print(json.dumps({
                "omega": fit["omega"].value, "order": fit.order, "residual": fit.residual_rms,
                "shape": response.position.shape, "unit": response.unit, "rms": float(np.sqrt(np.mean((response.position - sweep[2]) ** 2))),
                "verdict": found.verdict, "name": found.effects[0].name, "gap": gap.value, "gap_unit": gap.unit,
                "files": [found.report.is_file(), found.fmu.is_file(), "backlash" in found.model],
                "html": [found.sentence[:20] in found._repr_html_(), "omega" in fit._repr_html_()],
                "before": found.gap.before.check_rms, "after": found.gap.after.check_rms,
            }))
            """
        )
    )
    assert said["order"] == 2 and abs(said["omega"] / 165.0 - 1) < 0.2
    assert said["shape"] == [5000] and said["unit"] == "deg" and abs(said["rms"] / said["residual"] - 1) < 0.2
    assert (said["verdict"], said["name"], said["gap_unit"]) == ("named", "backlash", "deg") and abs(said["gap"] - 0.12) < 0.01
    assert said["files"] == [True] * 3 and said["html"] == [True] * 2
    assert said["after"] < 0.5 * said["before"]


def test_the_lines_of_the_readme_do_what_they_say(installed, story):
    text = (REPOSITORY / "README.md").read_text()
    lines = re.search(r"```python\n(import actuator_fmu\n.*?)```", text, re.DOTALL)[1]
    said = installed.python("import os; os.chdir('demo')\n" + lines)
    assert said.startswith("Missing: backlash"), said
    assert all((installed.folder / "demo" / "found" / name).is_file() for name in ("report.html", "model.fmu"))


def test_a_frame_is_taken_by_its_columns(installed):
    """The interface of pandas without pandas: `columns` and `[]`; in mm, with user-defined names."""
    said = installed.python(
        """
        import numpy as np, actuator_fmu as af
        time = np.arange(4000) * 0.005
        command = 3.0 * np.sin(2 * np.pi * (0.5 * time + 0.2 * time**2))
        response = af.simulate("te-early-unloaded", time, command)
        class Frame(dict):
            columns = property(dict.keys)
        noise = np.random.default_rng(7).normal(scale=0.01, size=4000)
        frame = Frame({"t": response.time, "soll": response.command, "ist": response.position + noise, "other": ["x"] * 4000})
        fit = af.fit(frame, unit="mm", columns={"time": "t", "command": "soll", "position": "ist"}, order=2)
        print(fit.unit, fit["k"].unit, round(fit["k"].value, 3))
        """
    ).split()
    assert said[:2] == ["mm", "mm/mm"] and abs(float(said[2]) / 1.0198 - 1) < 0.005


def test_refusals_are_exceptions_with_the_words_of_the_program(installed):
    said = installed.python(
        """
        import numpy as np, actuator_fmu as af
        time = np.arange(500) * 0.005
        for call in (
            lambda: af.fit((time, np.sin(20 * time), np.random.default_rng(1).normal(size=500))),
            lambda: af.simulate("te-early-loadedd", time, np.sin(time)),
            lambda: af.simulate("te-early-loaded", time, np.sin(time)[1:]),
            lambda: af.fit([]),
        ):
            try:
                call()
            except af.ActuatorError as error:
                print(error)
        """
    ).splitlines()
    assert len(said) == 4 and "does not follow the command" in said[0] and "record-1.csv" in said[0]
    assert "te-early-loadedd" in said[1] and "te-early-loaded" in said[1]
    assert "one length" in said[2] and "one or more" in said[3]
