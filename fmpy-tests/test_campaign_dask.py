"""`examples/campaign-dask` on a cluster of two workers: the same files as on one machine; failed and finished jobs kept apart."""

import contextlib
import importlib
import json
import os
import re
import subprocess
import sys
from types import SimpleNamespace

import distributed
import pytest

from actuator_fmu import REPOSITORY
from hidden import product

PROGRAM = REPOSITORY / "examples" / "campaign-dask" / "on_dask.py"
DURATION_S = 8  # of each record: the shortest for which these effects are named
FILES = ("diagnosis.json", "model.toml", "model.fmu", "report.html")
NAMES = {"new": set(), "worn": {"backlash"}}
BROKEN = '\n[[job]]\nname = "broken"\nmodel = "te-early-unloaded"\nfit = ["records/none.csv"]\n'

pytestmark = product.needs_program()


def on_dask(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-B", str(PROGRAM), *map(str, arguments), "--program", str(product.program())],
        capture_output=True, text=True, cwd=cwd, env=os.environ | {"MPLBACKEND": "Agg"},
    )  # fmt: skip


def content(path):
    """A file's bytes; for a diagnosis and its page without the command line, which contains different folders."""
    if path.name == "report.html":
        options, command = r"<dt>options</dt><dd>.*?</dd>\n", r'<pre class="command">.*?</pre>\n'
        page, cut = re.subn(f"{options}|{command}", "", path.read_text(), flags=re.DOTALL)
        assert cut == 2
        return page
    if path.name != "diagnosis.json":
        return path.read_bytes()
    diagnosis = json.loads(path.read_text())
    assert diagnosis.pop("reproduce")["command"][1] == "diagnose"
    return diagnosis


def files(folder):
    return {str(path.relative_to(folder)): content(path) for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two valid jobs and a broken one, on a local cluster of two workers."""
    folder = tmp_path_factory.mktemp("dask")
    made = on_dask("example", "-o", "data", "--duration", DURATION_S, cwd=folder)
    assert made.returncode == 0, made.stderr
    jobs = (folder / "data" / "manifest.toml").read_text().split("\n[[job]]")
    manifest = "\n[[job]]".join(job for job in jobs if any(f'name = "{name}"' in job for name in NAMES))
    (folder / "data" / "manifest.toml").write_text(manifest + BROKEN)
    done = on_dask("diagnose", "data/manifest.toml", "-o", "dask", "--workers", 2, cwd=folder)
    return folder, done


def test_a_job_that_fails_is_reported_and_the_rest_is_kept(runs):
    folder, done = runs
    assert done.returncode == 1, done.stdout + done.stderr
    summary = {row["name"]: row for row in json.loads((folder / "dask" / "summary.json").read_text())}
    assert "records/none.csv" in summary["broken"]["failed"] and not (folder / "dask" / "broken").exists()
    for name, effects in NAMES.items():
        assert {found.split(".")[0] for found in summary[name]["found"]} == effects
    assert not list((folder / "dask").glob(".*")), "a partial folder was left"


@pytest.mark.parametrize("name", NAMES)
def test_every_file_is_the_one_that_the_bare_command_makes(runs, name, tmp_path):
    """`actuator diagnose`, called directly in the manifest's folder, with its default number of threads."""
    folder, _ = runs
    records = [f"records/{name}/{kind}.csv" for kind in ("sweep", "random", "multisine")]
    command = ["diagnose", "--model", "te-early-unloaded", "--fit", *records[:2], "--check", records[2], "-o", str(tmp_path / "by-hand")]
    by_hand = subprocess.run([product.program(), *command], cwd=folder / "data", capture_output=True, text=True)
    assert by_hand.returncode == 0, by_hand.stderr
    for file in FILES:
        assert content(folder / "dask" / name / file) == content(tmp_path / "by-hand" / file), file


def test_a_second_call_keeps_what_is_finished_and_makes_anew_what_has_changed(runs):
    folder, _ = runs
    before = files(folder / "dask")
    (folder / "dask" / "worn" / "job.json").write_text("{}")  # as if made from other files
    stamps = {name: (folder / "dask" / name / "diagnosis.json").stat().st_mtime_ns for name in NAMES}
    again = on_dask("diagnose", "data/manifest.toml", "-o", "dask", "--here", cwd=folder)
    assert "1 done, 1 kept from before, 1 failed" in again.stdout, again.stdout + again.stderr
    after = {name: (folder / "dask" / name / "diagnosis.json").stat().st_mtime_ns for name in NAMES}
    assert after["new"] == stamps["new"] and after["worn"] > stamps["worn"]
    assert files(folder / "dask") == before


def test_a_folder_of_someone_else_is_left_alone(runs):
    folder, _ = runs
    (folder / "foreign" / "new").mkdir(parents=True)
    (folder / "foreign" / "new" / "thesis.txt").write_text("all of it")
    done = on_dask("diagnose", "data/manifest.toml", "-o", "foreign", "--here", cwd=folder)
    assert done.returncode == 1 and "holds no job.json" in done.stdout
    assert (folder / "foreign" / "new" / "thesis.txt").read_text() == "all of it"
    assert (folder / "foreign" / "worn" / "diagnosis.json").is_file()


@pytest.mark.slow
def test_runs_under_many_noises_are_counted_drawn_and_repeatable(runs):
    folder, _ = runs
    options = ("monte-carlo", "data/worn.toml", "--runs", 2, "--duration", DURATION_S)
    dask = on_dask(*options, "-o", "spread", "--workers", 2, cwd=folder)
    assert dask.returncode == 0, dask.stdout + dask.stderr
    result = json.loads((folder / "spread" / "monte-carlo.json").read_text())
    (gap,) = result["parameters"]
    assert result["runs"] == 2 and result["right"] == 2 and gap["parameter"] == "backlash.gap"
    # Two runs, each within five of the stated standard errors: a wrong scale of noise or truth would be far outside.
    assert abs(gap["mean"] - gap["truth"]) < 5 * gap["stated_std_error"]
    assert (folder / "spread" / "monte-carlo.png").read_bytes().startswith(b"\x89PNG")
    here = on_dask(*options, "--first-seed", 2, "--runs", 1, "-o", "alone", "--here", cwd=folder)
    assert here.returncode == 0, here.stderr
    assert files(folder / "spread" / "runs" / "seed-00002") == files(folder / "alone" / "runs" / "seed-00002")


@pytest.mark.slow
def test_a_job_that_kills_its_worker_costs_no_other_job(runs):
    """The program of one job ends the worker's process, as a lack of memory would; Dask retries it on others, and then gives up."""
    folder, _ = runs
    deadly = folder / "deadly"
    deadly.write_text(f'#!/bin/sh\ncase "$*" in */.doomed-*) kill -9 $PPID ;; *) exec "{product.program()}" "$@" ;; esac\n')
    deadly.chmod(0o755)
    job = '[[job]]\nname = "{}"\nmodel = "te-early-unloaded"\nfit = ["records/worn/sweep.csv"]\n'
    (folder / "data" / "deadly.toml").write_text(job.format("doomed") + job.format("sound"))
    command = [sys.executable, "-B", str(PROGRAM), "diagnose", "data/deadly.toml", "-o", "killed", "--workers", "2", "--program", str(deadly)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "1 failed" in done.stdout, done.stdout + done.stderr
    doomed, sound = json.loads((folder / "killed" / "summary.json").read_text())
    assert "KilledWorker" in doomed["failed"] and sound["verdict"] == "named"


@pytest.mark.parametrize(
    "text, thing",
    [("", "no jobs"), ("[[job]]\nname = '../x'\n", "letters"), ("[[job]]\nname = 'a'\nmodel = 'm'\n", "no records"),
     ("[[job]]\nname = 'a'\nmodel = 'm'\nfit = ['r']\nchek = ['r']\n", "chek"), ("[[job", "manifest")],
)  # fmt: skip
def test_a_mistake_in_the_manifest_is_refused_with_what_is_allowed(tmp_path, text, thing):
    (tmp_path / "manifest.toml").write_text(text)
    refused = on_dask("diagnose", "manifest.toml", "-o", "out", "--here", cwd=tmp_path)
    assert refused.returncode == 2 and thing in refused.stderr and "allowed" in refused.stderr


def test_a_cluster_without_workers_is_said_and_not_waited_for(monkeypatch):
    cluster = imported(monkeypatch)
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.2)
    with distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as empty, distributed.Client(empty) as connected:
        job = cluster.diagnosis_jobs.Job(name="alone", base=".", folder="alone", program="actuator", model="te-early-unloaded", fit=())
        with pytest.raises(cluster.NoWorkers, match="for 1 jobs"):
            list(cluster.on_dask(connected, [job], lambda outcome: outcome))


def test_what_a_broken_cluster_leaves_is_done_by_another(monkeypatch):
    cluster = imported(monkeypatch)
    jobs = [SimpleNamespace(name=name) for name in ("first", "second", "third")]

    def breaks_after_one(_, left, tell):
        yield cluster.diagnosis_jobs.Outcome(left[0].name, "finished")
        raise cluster.NoWorkers("as said")

    monkeypatch.setattr(cluster, "client", lambda options: contextlib.nullcontext())
    monkeypatch.setattr(cluster, "on_dask", breaks_after_one)
    outcomes = cluster.run_all(jobs, SimpleNamespace(here=False))
    assert [outcome.name for outcome in outcomes] == ["first", "second", "third"]

    def breaks_at_once(*_):
        raise cluster.NoWorkers

    monkeypatch.setattr(cluster, "on_dask", breaks_at_once)
    with pytest.raises(cluster.NoWorkers):
        cluster.run_all(jobs, SimpleNamespace(here=False))


def imported(monkeypatch):
    """The example's module of clusters."""
    monkeypatch.syspath_prepend(PROGRAM.parent)
    return importlib.import_module("cluster")
