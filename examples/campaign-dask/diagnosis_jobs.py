"""A job: one `actuator diagnose` in a separate folder, which is either complete or absent.

Dask may run it anywhere, so it needs nothing but Python and the program. A job gives its records and its model as its manifest does,
relative to the manifest's folder, and the program runs there: its output then contains no machine-specific path.
"""

import csv
import hashlib
import json
import os
import random
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

RECEIPT = "job.json"  # marks a folder as finished and states its inputs
LAST_WORDS = 500  # characters of an error message that are kept


@dataclass(frozen=True)
class Job:
    """What to diagnose. Paths are relative to `base`, except `program`, `fmu` and `folder`."""

    name: str
    base: str  # folder in which the program runs, accessible to every worker under this path
    folder: str  # folder for the results
    program: str
    model: str  # set name or model file
    fit: tuple[str, ...]
    check: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()  # passed on unchanged
    fmu: str | None = None  # take the binary from this FMU
    noise_rms_deg: float = 0.0  # white noise added to the records' positions before they are diagnosed
    seed: int = 0  # seed of that noise
    threads: int = 1  # threads of the program; Dask provides the parallelism

    def command(self):
        """Arguments of the program, ending with the output folder and the FMU that provides the binary."""
        check = ["--check", *self.check] if self.check else []
        return ["diagnose", "--model", self.model, "--fit", *self.fit, *check, *self.arguments]


@dataclass(frozen=True)
class Outcome:
    """Outcome of a job: `finished`, `kept` (already finished before) or `failed`, with the reason."""

    name: str
    ended: str
    reason: str = ""


def run(job):
    """Runs one job. Never raises for an error of this job alone, so that the others continue."""
    try:
        receipt = describe(job)
        if is_finished(Path(job.folder), receipt):
            return Outcome(job.name, "kept")
        diagnose(job, receipt)
        return Outcome(job.name, "finished")
    except (OSError, ValueError, KeyError, RuntimeError, subprocess.SubprocessError) as error:
        return Outcome(job.name, "failed", f"{type(error).__name__}: {error}" if not isinstance(error, RuntimeError) else str(error))


def describe(job):
    """Everything the result depends on. The same job on another machine has the same description."""
    inputs = [job.model, *job.fit, *job.check]
    base = Path(job.base)
    return {
        "command": job.command(),
        "inputs": {name: sha256(base / name) for name in inputs if (base / name).is_file()},
        "noise_rms_deg": job.noise_rms_deg,
        "seed": job.seed,
        "program": sha256(job.program),
        "fmu": sha256(job.fmu) if job.fmu else None,
    }


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_finished(folder, receipt):
    try:
        return json.loads((folder / RECEIPT).read_text()) == receipt
    except (OSError, ValueError):
        return False


def diagnose(job, receipt):
    """Works in a temporary folder beside the final one and renames it at the end: no result is ever incomplete."""
    final = Path(job.folder)
    if final.exists() and not (final / RECEIPT).is_file():
        raise RuntimeError(f"{final} is there and holds no {RECEIPT}; allowed: a new folder, or one of an earlier run")
    final.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{final.name}-", dir=final.parent))
    try:
        base = Path(job.base)
        if job.noise_rms_deg > 0.0:
            base = partial
            write_noisy_records(job, partial)
        call(job, base, partial)
        (partial / RECEIPT).write_text(json.dumps(receipt, indent=2, sort_keys=True) + "\n")
        partial.chmod(0o755)  # temporary folders are private, results are not
        shutil.rmtree(final, ignore_errors=True)
        partial.rename(final)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def call(job, base, output):
    command = [job.program, *job.command(), "-o", str(output)] + (["--from", job.fmu] if job.fmu else [])
    environment = os.environ | {"RAYON_NUM_THREADS": str(job.threads)}
    done = subprocess.run(command, cwd=base, env=environment, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise RuntimeError(f"exit code {done.returncode}: {(done.stderr.strip() or done.stdout.strip())[-LAST_WORDS:]}")


def write_noisy_records(job, folder):
    """The records, with white noise on the positions, and the model file of the job. Python's generator is the same on every machine."""
    base = Path(job.base)
    if (base / job.model).is_file():
        shutil.copyfile(base / job.model, folder / job.model)
    for number, name in enumerate((*job.fit, *job.check)):
        noise = random.Random(f"{job.seed}/{number}")
        with open(base / name, newline="") as source, open(folder / name, "w", newline="") as target:
            rows = csv.DictReader(source)
            write = csv.writer(target, lineterminator="\n")
            write.writerow(("time", "command", "position"))
            for row in rows:
                position = float(row["position"]) + noise.gauss(0.0, job.noise_rms_deg)
                write.writerow((row["time"], row["command"], f"{position:.7f}"))
