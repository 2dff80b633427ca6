"""User-defined actuators for tests: model files, records and FMUs made by the program `actuator`."""

import json
import subprocess

import numpy as np

import schemas
from own_program import PROGRAM

PERIOD_S = 0.005

# Unit of position: a suitable size of motions, and its definition as (metre, second, radian, factor).
UNITS = {
    "rad": (0.02, (0, 0, 1, 1.0)),
    "mm": (4.0, (1, 0, 0, 1e-3)),
    "m": (0.004, (1, 0, 0, 1.0)),
    "deg": (2.0, (0, 0, 1, np.pi / 180)),
    "1": (0.5, (0, 0, 0, 1.0)),
}


def actuator(*arguments, succeeds=True):
    """Output of the program: standard output, or standard error of a refusal. JSON is validated against its schema."""
    command = [str(PROGRAM), *map(str, arguments)]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == (0 if succeeds else 2), f"{command}\n{outcome.stdout}\n{outcome.stderr}"
    if succeeds and "--json" in arguments:
        schemas.check(arguments[0], json.loads(outcome.stdout))
    return outcome.stdout if succeeds else outcome.stderr


def model_file(path, unit, gap_share=0.0, name=None, description=None, order=2, omega=60.0):
    """A model file with positions in `unit`, and backlash of this share of its usual motions."""
    lines = ["[model]", f'unit = "{unit}"']
    lines += [f'name = "{name}"'] if name else []
    lines += [f'description = "{description}"'] if description else []
    lines += ["[base]", f"order = {order}", f'k = {{ value = 0.95, unit = "{unit}/{unit}" }}']
    lines += ['p = { value = 2000.0, unit = "1/s" }'] if order == 3 else []
    lines += [f'omega = {{ value = {omega}, unit = "rad/s" }}', 'zeta = { value = 0.7, unit = "1" }']
    if gap_share:
        lines += ["[effects.backlash]", f'gap = {{ value = {gap_share * UNITS[unit][0]!r}, unit = "{unit}" }}']
    path.write_text("\n".join(lines) + "\n")
    return path


def sweep(size, duration_s=20.0):
    """Times and a command from 0.5 to 8 Hz, held between samples."""
    time = np.arange(round(duration_s / PERIOD_S)) * PERIOD_S
    return time, size * np.sin(2 * np.pi * (0.5 * time + 7.5 * time**2 / (2 * duration_s)))


def write_csv(path, **columns):
    rows = zip(*columns.values())
    path.write_text(",".join(columns) + "\n" + "\n".join(",".join(repr(float(v)) for v in row) for row in rows) + "\n")
    return path


def read_csv(path):
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: table[name] for name in table.dtype.names}
