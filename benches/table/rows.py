"""The rows: name, what it compares, and the module whose function `measure(context)` returns its lines and charts."""

import importlib
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    name: str
    title: str
    module: str
    function: str = "measure"
    long: bool = False  # only run on request

    def measure(self, context):
        """[Line], [Picture]"""
        return getattr(importlib.import_module(f".{self.module}", __package__), self.function)(context)


ROWS = [
    Row("fmu", "The packaged FMU and a second-order unit in C, in one C loop", "fmu"),
    Row("fmpy", "The FMU in fmpy, and an FMU that does nothing", "importers", "fmpy_floor"),
    Row("pythonfmu", "The FMU and an actuator in Python, packaged by pythonfmu, in fmpy", "importers", "pythonfmu"),
    Row("linear", "A linear actuator through 15 000 samples: scipy, python-control", "simulation", "linear"),
    Row("nonlinear", "Rate limit, backlash through 15 000 samples: numba, 5 inner steps", "simulation", "nonlinear"),
    Row("simulators", "The same servo in JSBSim and MuJoCo", "simulators"),
    Row("frf", "Frequency response of 1e4 to 1e7 samples: pandas and scipy", "responses"),
    Row("fit", "Fit of one set, and of 17 sets from 8 starts each: scipy", "fits"),
    Row("diagnosis", "Diagnosis per search: scipy and numba", "diagnosis"),
    Row("monte-carlo", "100 000 actuators: numba", "monte_carlo"),
    Row("program", "Start and size of the program, size of the FMU", "program"),
    Row("growth-instances", "Cost over the number of instances", "growth", "instances"),
    Row("growth-effects", "Cost over the number of effects", "growth", "effects"),
    Row("growth-length", "Cost over the length of a record", "growth", "length"),
    Row("growth-searches", "Cost over the number of searches", "growth", "searches"),
    Row("campaign", "A test of 2300 points of 5 minutes, in full", "campaign", long=True),
]


def named(names):
    """The rows with these names, in order of the table."""
    unknown = set(names) - {row.name for row in ROWS}
    if unknown:
        raise SystemExit(f"no row {', '.join(sorted(unknown))}; there are {', '.join(row.name for row in ROWS)}")
    return [row for row in ROWS if row.name in names]
