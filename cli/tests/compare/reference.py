"""Differences between the tabulated actuators by another route: numpy, transfer functions as ratios of polynomials, a grid
ten times finer. Writes reference.csv beside itself: `python tests/compare/reference.py`."""

import csv
import itertools
import pathlib
import tomllib

import numpy as np

here = pathlib.Path(__file__).parent
sets = {}
for row in tomllib.loads((here / "../../src/parameters/tables.toml").read_text())["set"]:
    name = "-".join([{"trailing_edge": "te", "upper_spoiler": "us", "lower_spoiler": "ls"}[row["surface"]], row["stage"], row["load_case"]])
    sets[name] = (row["k"], row["p"], row["omega"], row["zeta"])

frequency = np.arange(500, 12001) / 1000


def response(k, p, omega, zeta, order=3):
    denominator = np.array([1, 2 * zeta * omega, omega**2])
    numerator = k * omega**2
    if order == 3:
        denominator, numerator = np.polymul(denominator, [1 / p, 1]), numerator
    return numerator / np.polyval(denominator, 2j * np.pi * frequency)


def first(values, limit):
    beyond = frequency[values > limit]
    return f"{beyond[0]:.3f}" if len(beyond) else ""


def compare(kind, a, b, of_a, of_b):
    for band, low, high in [("data", 0.5, 12), ("aeroelastic", 3, 5)]:
        inside = (frequency >= low) & (frequency <= high)
        magnitude = np.where(inside, abs(abs(of_b) - abs(of_a)), 0)
        phase = np.where(inside, abs(np.degrees(np.angle(of_b / of_a))), 0)
        yield [kind, a, b, band, f"{magnitude.max():.6f}", first(magnitude, 0.1), f"{phase.max():.5f}", first(phase, 3)]


rows = []
for a, b in itertools.combinations(sets, 2):
    (surface, stage, load), (other, later, loaded) = a.split("-"), b.split("-")
    if surface == other and load == loaded:
        rows += compare("wear", a, b, response(*sets[a]), response(*sets[b]))
    if surface == other and stage == later:
        rows += compare("load", a, b, response(*sets[a]), response(*sets[b]))
for name, values in sets.items():
    rows += compare("order", name, f"{name}, second order", response(*values), response(*values, order=2))

with open(here / "reference.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["kind", "from", "to", "band", "magnitude", "magnitude_first", "phase_deg", "phase_first"])
    writer.writerows(rows)
