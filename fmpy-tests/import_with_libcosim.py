"""Steps the FMU in libcosim (libcosimpy): `python import_with_libcosim.py FMU JOB.json`, positions to the standard output.

A process of its own, because libcosim ends with a segmentation fault when an FMU does not load.
"""

import json
import sys

from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

NANOSECONDS = 1e9
assert CosimVariableType.REAL.value == 0

fmu, job = sys.argv[1], json.load(open(sys.argv[2]))
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_step_size(round(job["step_s"] * NANOSECONDS))
slave = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="actuator"))
reference = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
assert execution.add_manipulator(manipulator) and execution.add_observer(observer)
for name, value in job["integers"].items():
    assert execution.integer_initial_value(slave, reference[name], value), name
positions = []
for command in job["commands"]:
    assert manipulator.slave_real_values(slave, [reference["command"]], [command])
    assert execution.step()
    positions += observer.last_real_values(slave, [reference["position"]])
print(json.dumps(positions))
