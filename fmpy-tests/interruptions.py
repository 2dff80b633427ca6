"""Kills the program at random moments, fills its disk, forbids it to write: `python fmpy-tests/interruptions.py --kills 100`.

After every kill each file that is there is whole. A campaign that is started again goes on, and ends with what a run that nobody has
disturbed ends with. A command that is killed while it replaces a file leaves the old one or the new one.
"""

import argparse
import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from actuator_fmu import DEFAULT_FMU
from own_program import PROGRAM

TEMPORARY = ".fmu-build-"  # prefix of the names of files that are being written


def start(*arguments, **options):
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen([str(PROGRAM), *map(str, arguments)], **{**quiet, **options})


def run(*arguments, **options):
    return subprocess.run([str(PROGRAM), *map(str, arguments)], capture_output=True, text=True, **options)


def killed(delay_s, *arguments):
    """Kills the program after some time; true if it was still running. It has a separate folder for temporary files, since a killed program cannot
    remove them."""
    with tempfile.TemporaryDirectory() as temporary:
        process = start(*arguments, env=os.environ | {"TMPDIR": temporary})
        try:
            process.wait(delay_s)
        except subprocess.TimeoutExpired:
            process.kill()
        return process.wait() == -signal.SIGKILL


def files(folder):
    return sorted(path for path in Path(folder).rglob("*") if path.is_file() and not path.name.startswith(TEMPORARY))


def assert_whole(folder):
    """Every file under its final name is complete in its format."""
    for path in files(folder):
        text = path.read_bytes()
        if path.suffix == ".json":
            json.loads(text)
        elif path.suffix == ".fmu":
            assert zipfile.ZipFile(path).testzip() is None
        elif path.suffix == ".html":
            assert text.rstrip().endswith(b"</html>"), path
        else:
            assert text.endswith(b"\n"), path


def contents(folder):
    """The results of a campaign, except for the notes that results were reused from an earlier run."""
    found = {}
    for path in files(folder):
        name = str(path.relative_to(folder))
        if name == "campaign.json":
            campaign = json.loads(path.read_text())
            for record in campaign["records"]:
                del record["reused"]
            found[name] = campaign
        elif name != "report.html":
            found[name] = path.read_bytes()
    return found


def campaign(folder, records):
    """A manifest of a few generated records, and the arguments to analyse it."""
    assert run("generate-campaign", "-o", folder, "--seed", "7", "--duration", "20").returncode == 0
    manifest = folder / "manifest.toml"
    head, *rows = manifest.read_text().split("[[record]]")
    manifest.write_text("[[record]]".join([head, *rows[:records]]))
    return manifest


def kill_campaigns(kills, rng, folder, records=6, diagnose=False):
    """Kills campaigns this many times; returns how many campaigns were completed in between."""
    manifest = campaign(folder / "records", records)
    options = [] if diagnose else ["--no-diagnosis"]
    began = time.monotonic()
    assert run("campaign", manifest, "-o", folder / "undisturbed", *options).returncode == 0
    duration_s, expected = time.monotonic() - began, contents(folder / "undisturbed")
    done, ended = 0, 0
    results = folder / "results"
    while done < kills:
        if killed(rng.uniform(0, duration_s), "campaign", manifest, "-o", results, *options):
            done += 1
            assert_whole(results)
            continue
        assert contents(results) == expected
        shutil.rmtree(results)
        ended += 1
    again = run("campaign", manifest, "-o", results, *options)
    assert again.returncode == 0, again.stderr
    assert contents(results) == expected
    assert not [path for path in results.rglob(f"{TEMPORARY}*")], "what killed runs were writing is still there"
    return ended + 1


def kill_builds(kills, rng, folder):
    """A replaced FMU is either the old or the new one."""
    path = folder / "model.fmu"
    build = ["build", "--from", DEFAULT_FMU, "-o", path, "--force", "--model"]
    versions = []
    for model in ("us-late-loaded", "te-early-unloaded"):
        began = time.monotonic()
        made = run(*build, model)
        assert made.returncode == 0, made.stderr
        versions.append((model, path.read_bytes(), time.monotonic() - began))
    done = 0
    while done < kills:
        model, _, duration_s = rng.choice(versions)
        done += killed(rng.uniform(0, duration_s), *build, model)
        assert path.read_bytes() in [version for _, version, _ in versions]


def kill_diagnoses(kills, rng, folder):
    """Each file in the folder of an earlier diagnosis is complete."""
    manifest = campaign(folder / "records", 2)
    records = sorted((folder / "records").rglob("*.csv"))[:2]
    diagnose = ["diagnose", "--model", "te-early-unloaded", "--from", DEFAULT_FMU, "--fit", *records]
    began = time.monotonic()
    made = run(*diagnose, "-o", folder / "diagnosis", "--force")
    duration_s = time.monotonic() - began
    assert made.returncode == 0 and manifest.is_file(), made.stderr
    before, done = {path.name for path in files(folder / "diagnosis")}, 0
    while done < kills:
        # Most of the time is computation; half of the kills hit the end, where files are written.
        delay_s = rng.uniform(0.9 if rng.random() < 0.5 else 0, 1) * duration_s
        done += killed(delay_s, *diagnose, "-o", folder / "diagnosis", "--force")
        assert_whole(folder / "diagnosis")
        assert {path.name for path in files(folder / "diagnosis")} == before


def limited(size):
    """Limits the size of files: writing beyond it fails, as on a full disk."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def assert_refused_and_unchanged(done, folder, before):
    """A failure with location and remedy, and unchanged files."""
    assert done.returncode not in (0, 101) and done.returncode > 0, done
    assert "found" in done.stderr and "allowed" in done.stderr and "as it was" in done.stderr, done.stderr
    assert {path: path.read_bytes() for path in files(folder)} == before
    assert not [path for path in Path(folder).rglob(f"{TEMPORARY}*")]


def fill_disk(folder, size, mounted=False):
    """An FMU for which no space is left, over an existing one."""
    path = folder / "model.fmu"
    build = ["build", "--from", DEFAULT_FMU, "-o", path, "--force", "--model"]
    options = {} if mounted else {"preexec_fn": limited(size)}
    if not path.exists():
        path.write_bytes(b"earlier")
    before = {one: one.read_bytes() for one in files(folder)}
    assert_refused_and_unchanged(run(*build, "us-late-loaded", **options), folder, before)


@contextlib.contextmanager
def small_disk(size):
    """A RAM disk of this size; needs root."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], check=True)
        try:
            yield Path(folder)
        finally:
            subprocess.run(["umount", folder], check=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=208452)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    for name, kill in (("campaigns", kill_campaigns), ("builds", kill_builds), ("diagnoses", kill_diagnoses)):
        with tempfile.TemporaryDirectory() as folder:
            ended = kill(arguments.kills, rng, Path(folder))
        print(f"{name}: {arguments.kills} kills, nothing torn" + (f", {ended} ended equal" if ended else ""), flush=True)
    try:
        with small_disk(300_000) as disk:
            fill_disk(disk, 0, mounted=True)
        print("full disk: refused, what was there is as it was")
    except subprocess.CalledProcessError:
        print("full disk: not tried, no right to mount one")
