"""Runs the SSP in libcosim (libcosimpy): `python run_in_libcosim.py JOB.json`, watched values to the standard output."""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

NANOSECONDS = 1e9

job = json.load(open(sys.argv[1]))
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_ssp_file(ssp_path=job["ssp"], step_size=round(job["step_s"] * NANOSECONDS))
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
slaves = {unit: execution.slave_index_from_instance_name(unit) for unit in ("wing", "actuator")}
references = {
    unit: {variable.name.decode(): variable.reference for variable in execution.slave_variables(slave)}
    for unit, slave in slaves.items()
}
rows = []
for _ in range(job["steps"]):
    assert execution.step()
    rows.append([observer.last_real_values(slaves[unit], [references[unit][name]])[0] for unit, name in job["watched"]])
print(json.dumps(rows))
