"""Outcomes of the jobs, as text and as `summary.json`. Without times and machine names, so that two runs can be compared."""

import json
from pathlib import Path


def tell(jobs, outcomes, output, listed=True):
    """Prints and writes the summary; returns the exit code."""
    rows = [row(job, outcome) for job, outcome in zip(jobs, outcomes)]
    kept = sum(outcome.ended == "kept" for outcome in outcomes)
    failed = [outcome for outcome in outcomes if outcome.ended == "failed"]
    stored = Path(output) / "summary.json"
    partial = stored.with_suffix(".json.partial")
    partial.write_text(json.dumps(rows, indent=2) + "\n")
    partial.replace(stored)
    if listed:
        width = max(len(one["name"]) for one in rows)
        for one in rows:
            print(f"{one['name']:<{width}}  {line(one)}")
    print(f"{len(rows)} jobs: {len(rows) - kept - len(failed)} done, {kept} kept from before, {len(failed)} failed; {stored}")
    if not listed:
        for outcome in failed:
            print(f"{outcome.name}: {outcome.reason}")
    return 1 if failed else 0


def row(job, outcome):
    if outcome.ended == "failed":
        return {"name": job.name, "failed": outcome.reason}
    said = json.loads((Path(job.folder) / "diagnosis.json").read_text())
    found = {f"{effect['name']}.{name}": value["value"] for effect in said["effects"] for name, value in effect["parameters"].items()}
    return {"name": job.name, "verdict": said["verdict"], "found": found, "closed": said["gap"]["closed"]}


def line(one):
    if "failed" in one:
        return f"FAILED: {one['failed']}"
    found = ", ".join(f"{name} {value:.4g}" for name, value in one["found"].items())
    return f"{one['verdict']:<16}{found}"
