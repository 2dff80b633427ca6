"""Other importers step the FMU like fmpy does: libcosim and Ecos, which see no enumerations and so use `set_number`."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bact

TOLERANCE = 1e-9  # relative to the largest position
STEPS = 200
PATIENCE_S = 60
NOT_HERE = 77  # exit code of import_with_ecos.py
HERE = Path(__file__).parent


def positions_from(script, fmu_path, folder, s, commands):
    """What the importer measures; it runs in a process of its own, with a temporary folder of its own."""
    job = folder / "job.json"
    job.write_text(
        json.dumps({"integers": {"set_number": s.number}, "step_s": bact.CONTROL_PERIOD_S, "commands": list(commands)})
    )
    run = subprocess.run(
        [sys.executable, "-B", str(HERE / script), str(fmu_path), str(job)],
        capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, "TMPDIR": str(folder)}, cwd=folder,
    )  # fmt: skip
    if run.returncode == NOT_HERE:
        pytest.skip(f"ecospy does not load here: {run.stderr.strip()} (Debian: apt install libtbb12)")
    assert run.returncode == 0, f"exit code {run.returncode}\n{run.stdout}\n{run.stderr}"
    return np.array(json.loads(run.stdout.splitlines()[-1]))


@pytest.mark.parametrize("script", ["import_with_libcosim.py", "import_with_ecos.py"])
@pytest.mark.parametrize("s", [bact.SETS[0], bact.BY_NAME["te-late-loaded"], bact.STIFFEST], ids=lambda s: s.name)
def test_another_importer_measures_the_exact_response(fmu_path, tmp_path, rng, script, s):
    """Held random commands at 200 Hz. Ecos sets the input ahead of a step, libcosim as well: no step of delay in either."""
    commands = rng.uniform(-5, 5, STEPS)
    measured = positions_from(script, fmu_path, tmp_path, s, commands)
    exact = bact.respond(s, bact.THIRD, commands, bact.CONTROL_PERIOD_S)[:, 1]
    assert np.abs(measured - exact).max() <= TOLERANCE * np.abs(exact).max()
