"""Steps the FMU, or an SSP system around it, in libcosim: `python import_with_libcosim.py F.fmu|F.ssp JOB.json`.

Prints the positions of each run of the job as JSON. A process of its own, because libcosim ends with a segmentation fault when an
FMU does not load. Of a system, the parameter set that it binds is applied by libcosim itself.
"""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

NANOSECONDS = 1e9


def execute(path, step_ns):
    """An execution with one slave, and its index."""
    if path.endswith(".ssp"):
        return CosimExecution.from_ssp_file(path, step_ns), 0
    execution = CosimExecution.from_step_size(step_ns)
    return execution, execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="actuator"))


def positions(path, step_ns, integers, commands):
    execution, slave = execute(path, step_ns)
    reference = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator) and execution.add_observer(observer)
    for name, value in integers.items():
        assert execution.integer_initial_value(slave, reference[name], value), name
    for command in commands:
        assert manipulator.slave_real_values(slave, [reference["command"]], [command])
        assert execution.step()
        yield observer.last_real_values(slave, [reference["position"]])[0]


path, job = sys.argv[1], json.load(open(sys.argv[2]))
log_output_level(CosimLogLevel.WARNING)
step_ns = round(job["step_s"] * NANOSECONDS)
print(json.dumps([list(positions(path, step_ns, run["integers"], run["commands"])) for run in job["runs"]]))
