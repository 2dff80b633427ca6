"""Steps the FMU in Ecos (ecospy): `python import_with_ecos.py FMU JOB.json`, positions to the standard output.

A process of its own, because Ecos ends with a segmentation fault when an FMU does not load. Exit code 77: ecospy itself
does not load here, as it needs libtbb.so.12 (Debian: `apt install libtbb12`).
"""

import json
import sys

NOT_HERE = 77

try:
    from ecospy import EcosSimulation, EcosSimulationStructure
except OSError as reason:
    print(reason, file=sys.stderr)
    sys.exit(NOT_HERE)

fmu, job = sys.argv[1], json.load(open(sys.argv[2]))
with EcosSimulationStructure() as structure:
    structure.add_model("actuator", fmu)
    structure.add_parameter_set("chosen", {f"actuator::{name}": value for name, value in job["integers"].items()})
    with EcosSimulation(structure=structure, step_size=job["step_s"]) as simulation:
        assert simulation.init(parameter_set="chosen")
        positions = []
        for command in job["commands"]:
            simulation.set_real("actuator::command", command)
            simulation.step()
            positions.append(simulation.get_real("actuator::position"))
        simulation.terminate()
print(json.dumps(positions))
