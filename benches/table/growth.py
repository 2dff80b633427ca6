"""Growth of costs: with instances, effects, length of a record, searches. Logarithmic axes, fitted slopes."""

import sys
import tomllib

import numpy as np
from against_c import run as against_c

from . import diagnosis, simulation
from .context import ROOT
from .measure import Curve, Picture

INSTANCES = (10, 100, 1000, 10_000, 100_000)
EFFECTS = (1, 2, 3, 5, 8, 12, 16, 20)
LENGTHS_S = (5.0, 50.0, 500.0, 5000.0)
CASES = (("single", 57), ("single", 58), ("single", 59), ("single", 61), ("pair", 11), ("pair", 13), ("outside", 9))


def instances(context):
    sizes = INSTANCES[: 2 if context.quick else None]
    curves = {"ours, a life of each": [], "C, a life of each": [], "ours, a step of each": [], "C, a step of each": []}
    with against_c.prepared(context.fmu) as bench:
        for unit, library, guid in (("ours", bench.library, bench.guid), ("C", bench.peer, "")):
            bench.library, bench.guid = library, guid
            for size in sizes:
                rounds = [list(map(float, bench.run("instances", size)[0][1:])) for _ in range(context.rounds(3))]
                life, step = np.median(rounds, axis=0)
                curves[f"{unit}, a life of each"].append(1e-3 * life * size)
                curves[f"{unit}, a step of each"].append(1e-3 * step * size)
    drawn = [Curve(name, list(sizes), values) for name, values in curves.items()]
    return [], [Picture("benchmarks-instances.svg", "Instances alive at once", "instances", "time, us", drawn)]


def strengths():
    """{effect: {variable of the FMU: value}}, in the order of the chain."""
    sys.path.insert(0, str(ROOT / "fmpy-tests"))
    import export_table

    tables = {name: tomllib.loads(text) for name, text in export_table.EFFECTS.items()}
    return {name: {f"{name}.{key}": quantity["value"] for key, quantity in table.items()} for name, table in tables.items()}


def effects(context):
    """A step with the first effect of the chain, with the first two, and so on."""
    sizes, cost, active = [], [], {}
    with against_c.prepared(context.fmu) as bench:
        for number, values in enumerate(strengths().values(), 1):
            active |= values
            if number not in EFFECTS[: 2 if context.quick else None]:
                continue
            words = [word for name, value in active.items() for word in (bench.references[name], value)]
            sizes.append(number)
            cost.append(float(bench.run("cost", *words)[0][2]) * 1e-3)
    title = "Effects at once, first in the chain first"
    return [], [Picture("benchmarks-effects.svg", title, "effects", "a step, us", [Curve("ours", sizes, cost)])]


def length(context):
    """Simulations over the length of the command."""
    sizes, ours, limited = [], [], []
    model = context.model("rate_limit", simulation.EFFECTS["rate_limit"][1])
    for duration_s in LENGTHS_S[: 2 if context.quick else None]:
        command = context.command("random", duration_s, 8.0)
        sizes.append(round(duration_s * simulation.RATE_HZ))
        ours.append(simulation.Library(context, simulation.SET, command, 3).seconds() * 1e3)
        limited.append(simulation.Library(context, model, command, 1).seconds() * 1e3)
    curves = [Curve("linear", sizes, ours), Curve("rate limit", sizes, limited)]
    return [], [Picture("benchmarks-length.svg", "A simulation", "samples", "time, ms", curves)]


def searches(context):
    """Diagnoses with few searches, and with many."""
    points = []
    for kind, seed in CASES[: 2 if context.quick else None]:
        searched, seconds = diagnosis.cost(context, diagnosis.drawn(context, kind, seed))
        points.append((searched, seconds))
    sizes, cost = map(list, zip(*sorted(points), strict=True))
    title = "A diagnosis, one thread"
    return [], [Picture("benchmarks-searches.svg", title, "searches", "processor time, s", [Curve("cases", sizes, cost)])]
