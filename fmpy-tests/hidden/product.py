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

from . import bundle, cases, files, kinds, scoring, scoring_garbage

PROGRAM = REPOSITORY / "target" / "release" / "actuator"
TIME_LIMIT_S = 120.0


def program():
    """The built binary, or that of ACTUATOR_PROGRAM=/path/to/actuator."""
    return Path(os.environ.get("ACTUATOR_PROGRAM", PROGRAM)).resolve()


def can_diagnose(path):
    """Whether the binary exists and has the command."""
    return path.is_file() and "diagnose" in subprocess.run([path, "--help"], capture_output=True, text=True).stdout


def needs_program():
    """Mark for tests that run the binary."""
    path = program()
    return pytest.mark.skipif(
        not can_diagnose(path),
        reason=f"{path} does not know `diagnose` or is not there (`cargo build --release`; another one: ACTUATOR_PROGRAM, as ./test sets it)",
    )


def slow(*cases):
    """Cases for `./test --all`: a seed each, or a kind and a seed."""
    return [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow) for case in cases]


class Refused(RuntimeError):
    """The product ended without a diagnosis: its exit code, its output, its run time in seconds."""

    def __init__(self, code, message, seconds):
        super().__init__(f"exit {code}: {message[-300:]}")
        self.code, self.message, self.seconds = code, message, seconds


THREE_RECORDS = ("--model", "model.toml", "--fit", "sweep.csv", "random.csv", "--check", "check.csv")


def diagnose(path, folder, time_limit_s=TIME_LIMIT_S, threads=None, arguments=THREE_RECORDS):
    """The diagnosis of the records in a folder, as read from its file, and the run time in seconds; `RuntimeError` if there is none."""
    out = folder / "diagnosis"
    environment = os.environ | ({"RAYON_NUM_THREADS": str(threads)} if threads else {})
    command = [path, "diagnose", *arguments, "-o", out, "--json"]
    start = clock.perf_counter()
    try:
        run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=time_limit_s)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"no answer within {time_limit_s:.0f} s") from None
    seconds = clock.perf_counter() - start
    if run.returncode != 0:
        raise Refused(run.returncode, run.stderr.strip() or run.stdout.strip(), seconds)
    text = (out / "diagnosis.json").read_text()
    if json.loads(run.stdout) != json.loads(text):
        raise RuntimeError("--json prints another diagnosis than diagnosis.json holds")
    return json.loads(text), seconds


def write_case(kind, seed, folder):
    """Files of one case in a folder; its truth and the arguments of `diagnose`."""
    if kind in cases.KINDS:
        case = cases.draw(seed, kind)
        files.write(case, folder)
        return files.truth(case), THREE_RECORDS
    drawn = kinds.draw(seed, kind)
    bundle.write(drawn, folder)
    return drawn.truth, drawn.arguments


def diagnose_case(kind, seed, folder):
    """Files of one case in a folder; its truth and its diagnosis."""
    truth, arguments = write_case(kind, seed, folder)
    diagnosis, _ = diagnose(program(), folder, arguments=arguments)
    return truth, diagnosis


def run_one(job):
    """One row of results: the truth, the outcome, seconds."""
    path, kind, seed, keep, time_limit_s, threads = job
    folder = Path(keep) / f"{kind}-{seed}" if keep else Path(tempfile.mkdtemp(prefix="hidden-effect-"))
    try:
        truth, arguments = write_case(kind, seed, folder)
        shutil.rmtree(folder / "diagnosis", ignore_errors=True)
        row = {"truth": truth}
        try:
            diagnosis, seconds = diagnose(path, folder, time_limit_s, threads, arguments)
            if kind == "garbage":
                return row | scoring_garbage.score(truth, diagnosis, seconds)
            return row | scoring.score(truth, diagnosis) | {"seconds": seconds}
        except (RuntimeError, OSError, ValueError, KeyError, TypeError) as error:
            if isinstance(error, Refused):
                of_kind = scoring_garbage if kind == "garbage" else scoring
                refusal = of_kind.refusal(truth, error.code, error.message, error.seconds)
                if refusal:
                    return row | refusal
            return row | {"outcome": "failed", "named": [], "alternatives": [], "error": f"{type(error).__name__}: {error}"}
    finally:
        if not keep:
            shutil.rmtree(folder, ignore_errors=True)
