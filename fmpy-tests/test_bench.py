"""`./bench` works: its list, its refusals, and one row in a few rounds. The content of the row is not asserted, since run times cannot be tested."""

import os
import re
import subprocess
import sys

from actuator_fmu import REPOSITORY


def bench(*arguments):
    """The table without installing the peers, which the row under test does not need."""
    environment = os.environ | {"PYTHONPATH": str(REPOSITORY / "benches")}
    return subprocess.run([sys.executable, "-m", "table", *arguments], env=environment, capture_output=True, text=True, check=False)


def test_rows_are_listed_without_installing_anything():
    done = subprocess.run([REPOSITORY / "bench", "--list"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = [line.split()[0] for line in done.stdout.splitlines()]
    assert {"fmu", "frf", "diagnosis", "campaign"} <= set(rows) and rows == list(dict.fromkeys(rows))


def test_an_unknown_row_and_a_quick_page_are_refused():
    assert "there are fmu" in bench("--only", "none").stderr
    assert "--write-docs" in bench("--quick", "--write-docs").stderr


def test_a_row_has_both_numbers(fmu_path):
    done = bench("--only", "fmu", "--quick")
    assert done.returncode == 0, done.stderr
    line = next(line for line in done.stdout.splitlines() if "set + step + get" in line)
    number = r"([\d.]+) \([\d.]+ to [\d.]+\) ns"
    found = re.search(rf"{number}; C: {number}; ratio ([\d.]+); agreement", line)
    assert found and all(float(value) > 0.0 for value in found.groups()), done.stdout
