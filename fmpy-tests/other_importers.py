"""Runs the importers that need a separate process, each in a separate folder."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import bact

PATIENCE_S = 120
NOT_HERE = 77  # exit code of import_with_ecos.py
HERE = Path(__file__).parent


class NotHere(Exception):
    """The importer does not load on this computer; the message gives the reason."""


def positions_from(script, path, folder, runs, step_s=bact.CONTROL_PERIOD_S):
    """The positions from the importer for each run (`integers`, `commands`, for Ecos `set`), as arrays; for several components by their names."""
    job = Path(folder) / "job.json"
    job.write_text(json.dumps({"step_s": step_s, "runs": [{"integers": {}, **run} for run in runs]}))
    run = subprocess.run(
        [sys.executable, "-B", str(HERE / script), str(path), str(job)],
        capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, "TMPDIR": str(folder)}, cwd=folder,
    )  # fmt: skip
    if run.returncode == NOT_HERE:
        raise NotHere(f"ecospy does not load here: {run.stderr.strip()} (Debian: apt install libtbb12)")
    if run.returncode != 0:
        raise RuntimeError(f"{script}: exit code {run.returncode}\n{run.stdout}\n{run.stderr}")
    measured = json.loads(run.stdout.splitlines()[-1])
    return [
        {name: np.array(each) for name, each in positions.items()} if isinstance(positions, dict) else np.array(positions)
        for positions in measured
    ]
