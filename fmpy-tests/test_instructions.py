"""The hot paths of the packaged library execute no more instructions than before: callgrind's counts, which do not depend on other load of the
computer. `python fmpy-tests/test_instructions.py` counts again and writes the reference, if a change justifies it."""

import json
import platform
import shutil
import sys
from pathlib import Path

import pytest

from actuator_fmu import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "benches"))

from against_c import run as against_c  # noqa: E402

REFERENCE = REPOSITORY / "benches" / "against_c" / "instructions.json"
MOST = 1.10  # of the reference
LOOPS = ("steps", "states", "effects")

pytestmark = [
    pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed (Debian: apt-get install valgrind)"),
    pytest.mark.skipif((platform.system(), platform.machine()) != ("Linux", "x86_64"), reason="the reference is of Linux on x86-64"),
]


def counted(fmu, loops=LOOPS):
    """Instructions per round of each loop, those of the loop itself included."""
    with against_c.prepared(fmu) as bench:
        return {loop: round(sum(bench.instructions(loop).values()), 1) for loop in loops}


@pytest.mark.parametrize("loop", ["steps", *(pytest.param(loop, marks=pytest.mark.slow) for loop in LOOPS if loop != "steps")])
def test_a_hot_path_takes_no_more_instructions(fmu_path, loop):
    expected = json.loads(REFERENCE.read_text())[loop]
    found = counted(fmu_path, (loop,))[loop]
    print(f"{loop}: {found} instructions, reference {expected}")
    assert found <= MOST * expected, f"{loop}: {found} instructions, {found / expected - 1.0:.0%} more than {REFERENCE.name} says"
    assert found > 0.5 * expected, f"{loop}: {found} instructions; much less than {REFERENCE.name} says, which wants to be written anew"


if __name__ == "__main__":
    counts = counted(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    REFERENCE.write_text(json.dumps(counts, indent=1) + "\n")
    print(counts)
