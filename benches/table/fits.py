"""Fits of records: one by the program, 17 from 8 starts each by the library, against scipy on the same records."""

import json

import numpy as np

from . import scipy_fit
from .context import ONE_THREAD
from .measure import Line, Spread, agree, in_turn, processor_s, run

DURATION_S, SEED = 75.0, 7
# Ours whitens the noise, which is coloured under load, and theirs does not: estimates differ by their scatter.
TOLERANCE = 0.05


def records(context):
    """Random sequences of all 17 sets, with noise and turbulence."""
    folder = context.folder / f"sets-{DURATION_S:g}-{SEED}"
    if not (folder / "manifest.toml").exists():
        context.actuator("generate-campaign", "-o", folder, "--duration", DURATION_S, "--seed", SEED)
    return sorted((folder / "records").glob("*-random.csv"))


def apart(ours, theirs):
    return float(np.max(np.abs(np.array(ours) / np.array(theirs) - 1.0)))


def one(context, path):
    command = ["fit", path, "--order", "2", "--json"]
    found = {estimate["name"]: estimate["value"] for estimate in json.loads(context.actuator(*command))["estimates"]}
    ours = [found[name] for name in ("k", "omega", "zeta")]
    start = [(1.0, 150.0, 0.7)]

    def by_hand():
        return scipy_fit.least_squares(scipy_fit.read(path), start)

    said = agree("k, omega, zeta", apart(ours, by_hand()), TOLERANCE)
    own, theirs = in_turn(context.rounds(15), lambda: context.actuator(*command), by_hand)
    what = "one record of 15 000 samples, from the file, the start of the program included"
    return Line("fit.one", what, "s", own, "pandas and least_squares, one start", theirs, said)


def many(context, paths):
    loaded, rounds = [scipy_fit.read(path) for path in paths], context.rounds(3)
    command = [context.library, "fits", 1, *paths]
    said = run(command, env=ONE_THREAD).splitlines()
    ours = [list(map(float, line.split("\t")[1:])) for line in said[1:]]
    lines = []
    methods = {"least_squares": scipy_fit.least_squares, "BFGS": scipy_fit.bfgs}
    times = {name: [] for name in ("ours", *methods)}
    for number in range(rounds):
        times["ours"].append(float(run(command, env=ONE_THREAD).split("\n", 1)[0]))
        for name, method in methods.items():
            found = []
            times[name].append(processor_s(lambda: found.extend(method(record, scipy_fit.STARTS) for record in loaded)))
            if number == 0:
                lines.append((name, agree(f"k, omega, zeta by {name}", max(map(apart, ours, found)), TOLERANCE)))
    own = Spread.of(times["ours"])
    what = f"{len(paths)} records of 15 000 samples, {len(scipy_fit.STARTS)} starts each, one thread, in memory"
    return [Line(f"fit.{name}", what, "s", own, f"scipy, {name}", Spread.of(times[name]), agreement) for name, agreement in lines]


def measure(context):
    paths = records(context)
    return [one(context, paths[0]), *many(context, paths[:1] if context.quick else paths)], []
