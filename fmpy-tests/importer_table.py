"""The importers that step the FMU, and how exactly: `python fmpy-tests/importer_table.py [--write]`.

Each importer steps all 17 sets through held random commands at 200 Hz. Its positions are compared with the exact response (`bact.py`,
partial fractions, which shares nothing with the product) and with the product's internal model (`actuator simulate`). `--write` puts
the table between the markers of docs/importers.md.
"""

import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Callable

import numpy as np

import bact
from actuator_fmu import DEFAULT_FMU, REPOSITORY, Actuator, unpacked
from other_importers import NotHere, positions_from

STEPS = 400  # two seconds
LARGEST_COMMAND_DEG = 5.0
SEED = 208452
TOLERANCE = 1e-9  # relative to the largest position of a run
START, END = "<!-- importer_table.py --write: from here -->", "<!-- to here -->"
PAGE = REPOSITORY / "docs" / "importers.md"
PROGRAM = REPOSITORY / os.environ.get("ACTUATOR_PROGRAM", "target/debug/actuator")
FMI_SIM_PLACES = (REPOSITORY / "target" / "tools" / "bin" / "fmi-sim", Path.home() / ".cargo" / "bin" / "fmi-sim")


def run(*command):
    outcome = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if outcome.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}: {outcome.returncode}\n{outcome.stdout}\n{outcome.stderr}")
    return outcome.stdout


def write_command(path, commands):
    """Samples at the communication points; the last is never applied."""
    with open(path, "w") as file:
        file.write("time,command\n")
        for i, command in enumerate([*commands, commands[-1]]):
            file.write(f"{i * bact.CONTROL_PERIOD_S!r},{float(command)!r}\n")


def positions_in(path):
    """The column `position` after the first row, which is the start."""
    with open(path, newline="") as file:
        return np.array([float(row["position"]) for row in csv.DictReader(file)])[1:]


# One function per importer: positions of every set at the end of every step.


def in_fmpy(fmu, sets, commands, folder):
    with unpacked(fmu) as package:
        for s, command in zip(sets, commands):
            chosen = {"surface": s.surface, "stage": s.stage, "load_case": s.load_case}
            with Actuator(package) as actuator:
                yield actuator.initialize(chosen).run(command, bact.CONTROL_PERIOD_S)


def in_another_process(script):
    def positions(fmu, sets, commands, folder):
        runs = [{"integers": {"set_number": s.number}, "commands": list(c)} for s, c in zip(sets, commands)]
        return positions_from(script, fmu, folder, runs)

    return positions


def with_the_program(*more):
    """`actuator simulate`: the internal model, or an FMU through fmi-rs."""

    def positions(fmu, sets, commands, folder):
        for s, command in zip(sets, commands):
            source, response = Path(folder) / "command.csv", Path(folder) / "response.csv"
            write_command(source, command)
            options = [fmu if word == "FMU" else word for word in more]
            run(PROGRAM, "simulate", s.name, source, *options, "-o", response, "--force")
            yield positions_in(response)

    return positions


def fmi_sim_program():
    found = shutil.which("fmi-sim") or next((place for place in FMI_SIM_PLACES if place.is_file()), None)
    if found is None:
        raise NotHere("fmi-sim is not installed (docs/importers.md says how)")
    return found


def in_fmi_sim(fmu, sets, commands, folder):
    program = fmi_sim_program()
    for s, command in zip(sets, commands):
        source, response = Path(folder) / "command.csv", Path(folder) / "response.csv"
        write_command(source, command)
        step = bact.CONTROL_PERIOD_S
        times = ["-s", 0, "-f", len(command) * step, "--step", step, "--output-interval", step]
        files = ["--model", fmu, "--input-file", source, "--output-file", response]
        run(program, *files, "co-simulation", "--init-values", f"set_number={s.number}", *times)
        yield positions_in(response)


def version_of_fmi_sim():
    """It reports its own `--version` as an error, whose text contains the version."""
    said = subprocess.run([fmi_sim_program(), "--version"], capture_output=True, text=True)
    return re.search(r"fmi-sim (\S+)", said.stdout + said.stderr)[1]


def version_of_fmi_rs():
    lock = (REPOSITORY / "Cargo.lock").read_text()
    return lock.split('name = "fmi-rs"\nversion = "')[1].split('"')[0]


@dataclass(frozen=True)
class Importer:
    name: str
    version: Callable
    chosen_by: str
    positions: Callable


IMPORTERS = (
    Importer("fmpy", lambda: version("fmpy"), "`surface`, `stage`, `load_case`", in_fmpy),
    Importer("libcosim (libcosimpy)", lambda: version("libcosimpy"), "`set_number`", in_another_process("import_with_libcosim.py")),
    Importer("Ecos (ecospy)", lambda: version("ecospy"), "`set_number`", in_another_process("import_with_ecos.py")),
    Importer("fmi-rs", version_of_fmi_rs, "`source`, `custom.*`", with_the_program("--fmu", "FMU")),
    Importer("fmi-sim (rust-fmi)", version_of_fmi_sim, "`set_number`", in_fmi_sim),
)
internal_model = with_the_program()


def random_commands(count, steps=STEPS):
    generator = np.random.default_rng(SEED)
    return [generator.uniform(-LARGEST_COMMAND_DEG, LARGEST_COMMAND_DEG, steps) for _ in range(count)]


def deviation(measured, expected):
    """Largest difference over all sets, relative to the largest position of each; infinite if a response is incomplete."""
    each = [np.abs(m - e).max() / np.abs(e).max() if m.shape == e.shape else np.inf for m, e in zip(measured, expected)]
    return max(each) if len(each) == len(expected) else np.inf


def exact_responses(sets, commands):
    return [bact.respond(s, bact.THIRD, c, bact.CONTROL_PERIOD_S)[:, 1] for s, c in zip(sets, commands)]


def measure(importer, fmu, folder, sets=bact.SETS, steps=STEPS):
    """(from the exact response, from the internal model)."""
    commands = random_commands(len(sets), steps)
    measured = list(importer.positions(fmu, sets, commands, folder))
    inside = list(internal_model(fmu, sets, commands, folder))
    return deviation(measured, exact_responses(sets, commands)), deviation(measured, inside)


def table(fmu):
    head = "| importer | version | the set is chosen by | from the exact response | from the internal model |\n| --- | --- | --- | --- | --- |\n"
    rows, worst = [], 0.0
    for importer in IMPORTERS:
        with tempfile.TemporaryDirectory(prefix="importer-") as folder:
            try:
                exact, inside = measure(importer, fmu, folder)
                rows.append(f"| {importer.name} | {importer.version()} | {importer.chosen_by} | {exact:.1e} | {inside:.1e} |\n")
                worst = max(worst, exact, inside)
            except NotHere as reason:
                rows.append(f"| {importer.name} | - | {importer.chosen_by} | not run: {reason} | |\n")
    return head + "".join(rows), worst


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--fmu", type=Path, default=DEFAULT_FMU)
    arguments.add_argument("--write", action="store_true", help="write the table into docs/importers.md")
    arguments = arguments.parse_args()
    text, worst = table(arguments.fmu.resolve())
    print(text, end="")
    if arguments.write:
        page = PAGE.read_text()
        before, rest = page.split(START)
        PAGE.write_text(f"{before}{START}\n{text}{END}{rest.split(END)[1]}")
    if worst > TOLERANCE:
        sys.exit(f"the worst deviation, {worst:.1e}, is above {TOLERANCE:.0e}")


if __name__ == "__main__":
    main()
