"""Archives from untrusted sources: names that lead outside, bombs, missing and wrong libraries, another GUID: refused with a reason."""

import re
import subprocess
import zipfile

import pytest

from hidden import product
from own_program import PROGRAM

pytestmark = product.needs_program()
DESCRIPTION = "modelDescription.xml"
LIBRARY = "binaries/linux64/BactActuator.so"


@pytest.fixture
def command(tmp_path):
    path = tmp_path / "command.csv"
    path.write_text("time,command\n0,0\n0.005,1\n0.2,1\n")
    return path


def archive(fmu_path, path, change):
    """The FMU with changed entries: `change` maps names and contents."""
    with zipfile.ZipFile(fmu_path) as own:
        entries = change({name: own.read(name) for name in own.namelist()})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as made:
        for name, text in entries.items():
            made.writestr(name, text)
    return path


def replaced(name, old, new):
    return lambda entries: {**entries, name: re.sub(old, new, entries[name])}


def without(prefix):
    return lambda entries: {name: text for name, text in entries.items() if not name.startswith(prefix)}


STRANGE = {
    "a name that leads out": (lambda entries: {**entries, "../outside": b"x"}, "would leave the archive"),
    "an absolute name": (lambda entries: {**entries, "/tmp/outside": b"x"}, "is absolute"),
    "a name of Windows": (lambda entries: {**entries, "resources\\..\\outside": b"x"}, "backslash"),
    "a bomb": (lambda entries: {DESCRIPTION: entries[DESCRIPTION], "zeros": bytes(1 << 25)}, "times its size"),
    "no library": (without("binaries/"), "binaries of this FMU: none"),
    "a library for another computer": (
        lambda entries: {**without("binaries/")(entries), "binaries/win32/BactActuator.dll": b"MZ"},
        "binaries of this FMU: win32",
    ),
    "a library that is none": (lambda entries: {**entries, LIBRARY: b"MZ" * 1000}, "BactActuator.so"),
    "another GUID": (replaced(DESCRIPTION, rb'guid="[^"]*"', b'guid="{0}"'), "take binary and modelDescription.xml"),
    "an identifier that is a path": (
        replaced(DESCRIPTION, rb'modelIdentifier="[^"]*"', b'modelIdentifier="../../evil"'),
        "no name of C",
    ),
    "no description": (without(DESCRIPTION), DESCRIPTION),
    "a description that is none": (lambda entries: {**entries, DESCRIPTION: b"<a>" * 100_000}, DESCRIPTION),
}


@pytest.mark.parametrize("what", STRANGE)
def test_a_strange_archive_is_refused_with_words(fmu_path, tmp_path, command, what):
    change, words = STRANGE[what]
    folder = tmp_path / "inside"
    folder.mkdir()
    strange = archive(fmu_path, folder / "strange.fmu", change)
    done = subprocess.run(
        [PROGRAM, "simulate", "us-late-loaded", command, "--fmu", strange], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2, done
    assert "strange.fmu" in done.stderr and words in done.stderr and "found" in done.stderr, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["command.csv", "inside"], "something was written outside"


def test_the_archive_itself_is_read(fmu_path, tmp_path, command):
    """Otherwise the other tests would test nothing."""
    sound = archive(fmu_path, tmp_path / "sound.fmu", lambda entries: entries)
    done = subprocess.run([PROGRAM, "simulate", "us-late-loaded", command, "--fmu", sound], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("time,"), done


def test_the_help_says_that_a_foreign_fmu_is_a_program():
    done = subprocess.run([PROGRAM, "simulate", "--help"], capture_output=True, text=True)
    assert "runs the program in the FMU" in " ".join(done.stdout.split()), done.stdout
