"""The list of jobs: a TOML file, paths relative to it.

    [[job]]
    name = "worn"                    # of its folder
    model = "te-early-unloaded"      # set name or model file
    fit = ["worn-sweep.csv"]
    check = ["worn-random.csv"]      # optional
    arguments = ["--unit", "rad"]    # optional, passed on to `actuator diagnose`
"""

import re
import tomllib
from pathlib import Path

from diagnosis_jobs import Job

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")  # valid as a folder name on every system
KEYS = {"name", "model", "fit", "check", "arguments"}
OURS = ("-o", "--output", "--from", "--force")  # options set by the job scheduler itself


class Mistake(Exception):
    """An error that the user can correct: item, value found, values allowed."""


def read(path, output, options):
    """The jobs of a manifest. An error in the list ends the run; an error in a record fails that job."""
    path = Path(path).resolve()
    try:
        entries = tomllib.loads(path.read_text()).get("job", [])
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Mistake(f"manifest: {error}; allowed: a readable TOML file, see manifest.py ({path})") from None
    if not isinstance(entries, list) or not entries:
        raise Mistake(f"manifest: no jobs; allowed: at least one table [[job]] ({path})")
    jobs = [job(entry, number, path.parent, output, options) for number, entry in enumerate(entries, 1)]
    names = [one.name for one in jobs]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise Mistake(f"job names: {', '.join(twice)} more than once; allowed: each once ({path})")
    return jobs


def job(entry, number, base, output, options):
    if unknown := sorted(entry.keys() - KEYS):
        raise Mistake(f"job {number}: unknown key {', '.join(unknown)}; allowed: {', '.join(sorted(KEYS))}")
    name = entry.get("name", "")
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise Mistake(f"job {number}: name {name!r}; allowed: letters, digits, '_', '-' and '.', not first '-' or '.'")
    if not isinstance(entry.get("model"), str):
        raise Mistake(f"job {name}: no model; allowed: a set name or a model file")
    lists = {key: strings(entry.get(key, []), f"job {name}: {key}") for key in ("fit", "check", "arguments")}
    if not lists["fit"]:
        raise Mistake(f"job {name}: no records to fit; allowed: fit = [\"record.csv\", ...]")
    if taken := [argument for argument in lists["arguments"] if argument.split("=")[0] in OURS]:
        raise Mistake(f"job {name}: argument {taken[0]}; allowed: those that do not say where results or FMU are")
    return Job(name=name, base=str(base), folder=str(Path(output).resolve() / name), program=options.program, fmu=options.fmu,
               threads=options.threads, model=entry["model"], **lists)  # fmt: skip


def strings(value, thing):
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise Mistake(f"{thing} is {value!r}; allowed: a list of strings")
    return tuple(value)
