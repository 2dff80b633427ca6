"""A second checker beside fmpy's: FMU Manipulation Toolbox, which has its own schema and rules."""

import subprocess
import sys
import zipfile

import pytest

pytest.importorskip("fmu_manipulation_toolbox", reason="pip install fmu-manipulation-toolbox")

PROGRAM = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"


def check(fmu):
    return subprocess.run([sys.executable, "-c", PROGRAM, "-input", str(fmu), "-check"], capture_output=True, text=True)


def test_the_checker_finds_nothing(fmu_path):
    outcome = check(fmu_path)
    said = outcome.stdout + outcome.stderr
    assert outcome.returncode == 0 and "No semantic error" in said and "seems to be compliant with FMI-2.0" in said, said


def test_the_checker_finds_what_is_wrong(fmu_path, tmp_path):
    broken = tmp_path / fmu_path.name
    with zipfile.ZipFile(fmu_path) as before, zipfile.ZipFile(broken, "w") as after:
        for name in before.namelist():
            content = before.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b'initial="exact"', b'initial="calculated"', 1)
            after.writestr(name, content)
    assert check(broken).returncode != 0
