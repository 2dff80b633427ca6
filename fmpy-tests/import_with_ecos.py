"""Steps the FMU, or an SSP system around it, in Ecos (ecospy): `python import_with_ecos.py F.fmu|F.ssp JOB.json`.

Prints the positions of each run of the job as JSON; if its `commands` are those of several components, by their names.
A separate process, because Ecos ends with a segmentation fault when an FMU does not load. Ecos applies a parameter set of a
system by its name: `"set"` of the job. Exit code 77: ecospy itself does not load here, as it needs libtbb.so.12 (Debian: `apt install libtbb12`).
"""

import contextlib
import json
import sys

NOT_HERE = 77

try:
    from ecospy import EcosSimulation, EcosSimulationStructure
except OSError as reason:
    print(reason, file=sys.stderr)
    sys.exit(NOT_HERE)


@contextlib.contextmanager
def simulation(path, step_s, integers):
    """The simulation of a system, or of the FMU alone with these integers as its parameter set `chosen`."""
    if path.endswith(".ssp"):
        with EcosSimulation(ssp_path=path, step_size=step_s) as simulation:
            yield simulation
        return
    with EcosSimulationStructure() as structure:
        structure.add_model("actuator", path)
        structure.add_parameter_set("chosen", {f"actuator::{name}": value for name, value in integers.items()})
        with EcosSimulation(structure=structure, step_size=step_s) as simulation:
            yield simulation


def positions(path, step_s, run, commands):
    measured = {name: [] for name in commands}
    with simulation(path, step_s, run["integers"]) as s:
        chosen = run.get("set", "chosen")
        assert s.init(parameter_set=chosen) if chosen else s.init()
        for row in zip(*commands.values()):
            for name, command in zip(commands, row):
                s.set_real(f"{name}::command", command)
            s.step()
            for name in commands:
                measured[name].append(s.get_real(f"{name}::position"))
        s.terminate()
    return measured


def answer(path, step_s, run):
    if isinstance(run["commands"], dict):
        return positions(path, step_s, run, run["commands"])
    return positions(path, step_s, run, {"actuator": run["commands"]})["actuator"]


path, job = sys.argv[1], json.load(open(sys.argv[2]))
print(json.dumps([answer(path, job["step_s"], run) for run in job["runs"]]))
