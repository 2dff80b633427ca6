"""Runs the SSP in Ecos (ecospy): `python run_in_ecos.py JOB.json`, watched values to the standard output.

Exit code 77: ecospy itself does not load here, as it needs libtbb.so.12 (Debian: `apt install libtbb12`).
"""

import json
import sys

NOT_HERE = 77

try:
    from ecospy import EcosSimulation
except OSError as reason:
    print(reason, file=sys.stderr)
    sys.exit(NOT_HERE)

job = json.load(open(sys.argv[1]))
with EcosSimulation(ssp_path=job["ssp"], step_size=job["step_s"]) as simulation:
    assert simulation.init(parameter_set=job["parameter_set"])
    rows = []
    for _ in range(job["steps"]):
        simulation.step()
        rows.append([simulation.get_real(f"{unit}::{name}") for unit, name in job["watched"]])
    simulation.terminate()
print(json.dumps(rows))
