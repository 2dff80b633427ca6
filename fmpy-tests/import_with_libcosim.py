"""Steps the FMU, or an SSP system around it, in libcosim: `python import_with_libcosim.py F.fmu|F.ssp JOB.json`.

Prints the positions of each run of the job as JSON; if its `commands` are those of several components, by their names.
A separate process, because libcosim ends with a segmentation fault when an FMU does not load. For a system,
libcosim itself applies the parameter set that the system binds.
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
    """An execution of a system, or of one slave `actuator`."""
    if path.endswith(".ssp"):
        return CosimExecution.from_ssp_file(path, step_ns)
    execution = CosimExecution.from_step_size(step_ns)
    execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="actuator"))
    return execution


def positions(path, step_ns, integers, commands):
    execution = execute(path, step_ns)
    slaves = {name: execution.slave_index_from_instance_name(name) for name in commands}
    references = {
        name: {v.name.decode(): v.reference for v in execution.slave_variables(slave)} for name, slave in slaves.items()
    }
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator) and execution.add_observer(observer)
    for name, slave in slaves.items():
        for variable, value in integers.items():
            assert execution.integer_initial_value(slave, references[name][variable], value), variable
    measured = {name: [] for name in commands}
    for row in zip(*commands.values()):
        for name, command in zip(commands, row):
            assert manipulator.slave_real_values(slaves[name], [references[name]["command"]], [command])
        assert execution.step()
        for name, slave in slaves.items():
            measured[name] += observer.last_real_values(slave, [references[name]["position"]])
    return measured


def answer(path, step_ns, run):
    if isinstance(run["commands"], dict):
        return positions(path, step_ns, run["integers"], run["commands"])
    return positions(path, step_ns, run["integers"], {"actuator": run["commands"]})["actuator"]


path, job = sys.argv[1], json.load(open(sys.argv[2]))
log_output_level(CosimLogLevel.WARNING)
step_ns = round(job["step_s"] * NANOSECONDS)
print(json.dumps([answer(path, step_ns, run) for run in job["runs"]]))
