"""The product on one case: draws it, writes its files, runs `actuator diagnose`, reads and scores the diagnosis."""

import json
import os
import shutil
import subprocess
import tempfile
import time as clock
from pathlib import Path

import pytest

from actuator_fmu import REPOSITORY

from . import cases, files, scoring

PROGRAM = REPOSITORY / "target" / "release" / "actuator"
TIME_LIMIT_S = 120.0


def program():
    """The built binary; another one: ACTUATOR_PROGRAM=/path/to/actuator."""
    return Path(os.environ.get("ACTUATOR_PROGRAM", PROGRAM)).resolve()


def can_diagnose(path):
    """The binary is there and knows the command."""
    return path.is_file() and "diagnose" in subprocess.run([path, "--help"], capture_output=True, text=True).stdout


def needs_program():
    """The mark of tests that run the binary."""
    path = program()
    return pytest.mark.skipif(
        not can_diagnose(path),
        reason=f"{path} does not know `diagnose` or is not there (`cargo build --release`; another one: ACTUATOR_PROGRAM, as ./test sets it)",
    )


def diagnose(path, folder, time_limit_s=TIME_LIMIT_S, threads=None):
    """The diagnosis of the records in a folder, as read from its file, and the seconds it took; `RuntimeError` if there is none."""
    out = folder / "diagnosis"
    environment = os.environ | ({"RAYON_NUM_THREADS": str(threads)} if threads else {})
    command = [path, "diagnose", "--model", "model.toml", "--fit", "sweep.csv", "random.csv", "--check", "check.csv", "-o", out, "--json"]
    start = clock.perf_counter()
    try:
        run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=time_limit_s)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"no answer within {time_limit_s:.0f} s") from None
    seconds = clock.perf_counter() - start
    if run.returncode != 0:
        raise RuntimeError(f"exit {run.returncode}: {(run.stderr.strip() or run.stdout.strip())[-300:]}")
    text = (out / "diagnosis.json").read_text()
    if json.loads(run.stdout) != json.loads(text):
        raise RuntimeError("--json prints another diagnosis than diagnosis.json holds")
    return json.loads(text), seconds


def run_one(job):
    """One row of results: the truth, the outcome, seconds."""
    path, kind, seed, keep, time_limit_s, threads = job
    folder = Path(keep) / f"{kind}-{seed}" if keep else Path(tempfile.mkdtemp(prefix="hidden-effect-"))
    try:
        case = cases.draw(seed, kind)
        shutil.rmtree(folder / "diagnosis", ignore_errors=True)
        files.write(case, folder)
        row = {"truth": files.truth(case)}
        try:
            diagnosis, seconds = diagnose(path, folder, time_limit_s, threads)
            return row | scoring.score(row["truth"], diagnosis) | {"seconds": seconds}
        except (RuntimeError, OSError, ValueError, KeyError, TypeError) as error:
            return row | {"outcome": "failed", "named": [], "alternatives": [], "error": f"{type(error).__name__}: {error}"}
    finally:
        if not keep:
            shutil.rmtree(folder, ignore_errors=True)
