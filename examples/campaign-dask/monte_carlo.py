"""One case with many realisations of the noise: the spread of the estimated parameters, and how often the name is right.

The truth is a model file. Its records are simulated once without noise; every run adds white noise with a different seed and diagnoses them.
"""

import csv
import json
import shutil
import statistics
import tomllib
from pathlib import Path

import example
from diagnosis_jobs import RECEIPT, Job
from manifest import Mistake

COVERING = 1.96  # half width of a 95 % interval in standard errors


def jobs(options):
    """Simulates the records without noise; one job per seed."""
    if not options.truth.is_file():
        raise Mistake(f"truth: no file {options.truth}; allowed: a model file")
    folder = options.output / "clean"
    folder.mkdir(exist_ok=True)
    shutil.copyfile(options.truth, folder / "truth.toml")
    commands = example.excite(options.program, folder, options.duration)
    example.simulate(options.program, folder, "truth.toml", commands, folder)
    model = options.model
    if Path(model).is_file():
        shutil.copyfile(model, folder / "given.toml")  # not model.toml, which is the name of a result
        model = "given.toml"
    use = {wanted: tuple(f"{kind}.csv" for kind, of in example.COMMANDS.items() if of == wanted) for wanted in ("fit", "check")}
    seeds = range(options.first_seed, options.first_seed + options.runs)
    return [
        Job(name=f"seed-{seed:05}", base=str(folder), folder=str(options.output / "runs" / f"seed-{seed:05}"), program=options.program,
            fmu=options.fmu, threads=options.threads, model=model, noise_rms_deg=options.noise, seed=seed, **use)
        for seed in seeds
    ]  # fmt: skip


def tell(jobs, options):
    """Prints the table, writes monte-carlo.csv (one row per parameter), monte-carlo.json and monte-carlo.png."""
    truth = effects_of(tomllib.loads(options.truth.read_text()))
    said = [diagnosis for job in jobs if (diagnosis := read(job))]
    if not said:
        return
    fitting = [one for one in said if {effect["name"] for effect in one["effects"]} == truth.keys()]
    right = [one for one in fitting if one["verdict"] in WELL]
    first = sum(one["verdict"] == "ambiguous" for one in fitting)
    verdicts = {verdict: sum(one["verdict"] == verdict for one in said) for verdict in sorted({one["verdict"] for one in said})}
    rows = [statistics_of(name, value, estimates(right, name)) for name, value in flat(truth).items()]
    counts = ", ".join(f"{verdict} {count}" for verdict, count in verdicts.items())
    print(f"name right in {len(right)} of {len(said)} runs, first of several in {first} ({counts})")
    for row in rows:
        print(sentence(row))
    result = {"runs": len(said), "right": len(right), "first": first, "verdicts": verdicts, "parameters": rows}
    (options.output / "monte-carlo.json").write_text(json.dumps(result, indent=2) + "\n")
    with open(options.output / "monte-carlo.csv", "w", newline="") as file:
        write = csv.DictWriter(file, ["parameter", *KEYS], lineterminator="\n")
        write.writeheader()
        write.writerows(rows)
    import picture

    picture.draw(flat(truth), right, estimates, verdicts, options.output / "monte-carlo.png")


WELL = ("named", "nothing_missing")  # verdicts that name an effect
KEYS = ("truth", "count", "mean", "spread", "stated_std_error", "covered")


def read(job):
    folder = Path(job.folder)
    return json.loads((folder / "diagnosis.json").read_text()) if (folder / RECEIPT).is_file() else None


def effects_of(model):
    """{effect: {parameter: value}} of a model file."""
    return {effect: {name: entry["value"] for name, entry in values.items()} for effect, values in model.get("effects", {}).items()}


def flat(effects):
    return {f"{effect}.{name}": value for effect, values in effects.items() for name, value in values.items()}


def estimates(diagnoses, name):
    """[(value, standard error)] of a parameter, from the diagnoses that contain it."""
    effect, parameter = name.split(".")
    found = [entry["parameters"].get(parameter) for one in diagnoses for entry in one["effects"] if entry["name"] == effect]
    return [(entry["value"], entry["std_error"]) for entry in found if entry]


def statistics_of(name, truth, found):
    """Spread: standard deviation over the runs. Stated: median of the standard errors in the diagnoses."""
    if len(found) < 2:
        return {"parameter": name, "truth": truth, "count": len(found)} | dict.fromkeys(KEYS[2:])
    values, errors = [value for value, _ in found], [error or 0.0 for _, error in found]
    covered = sum(abs(value - truth) <= COVERING * error for value, error in zip(values, errors)) / len(found)
    return {"parameter": name, "truth": truth, "count": len(found), "mean": statistics.fmean(values), "spread": statistics.stdev(values),
            "stated_std_error": statistics.median(errors), "covered": covered}  # fmt: skip


def sentence(row):
    if row["mean"] is None:
        return f"{row['parameter']}: true {row['truth']:g}; found in {row['count']} runs, too few for a spread"
    return (
        f"{row['parameter']}: true {row['truth']:g}, mean {row['mean']:.6g}, spread {row['spread']:.2g} (stated {row['stated_std_error']:.2g}),"
        f" {100 * row['covered']:.0f} % of the 95 % intervals hold the truth"
    )
