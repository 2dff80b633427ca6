"""Steps through fmpy: ours, an empty FMU, and the same servo in Python."""

import contextlib
import io
import shutil
import tempfile
import time as clock
import zipfile
from pathlib import Path

import fmpy
import numpy as np
from against_c import run as against_c
from fmpy.fmi2 import FMU2Slave

from .context import BASE, ROOT
from .fmu import CUSTOM, SECOND_ORDER
from .measure import Line, agree, in_turn, run

STEP_S = 0.005
SERVO = {"order": SECOND_ORDER, "source": CUSTOM} | {f"custom.{name}": value for name, value in zip(("k", "omega", "zeta"), BASE)}


def empty_fmu(folder):
    """Compiles and packs the empty FMU."""
    source, path = ROOT / "benches" / "empty_fmu", folder / "Empty.fmu"
    library = against_c.shared(source / "empty.c", folder / f"Empty{fmpy.sharedLibraryExtension}")
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(source / "modelDescription.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{fmpy.platform}/{library.name}")
    return path


def python_fmu(folder):
    """Packs the servo in Python."""
    if shutil.which("pythonfmu") is None:
        raise RuntimeError("pythonfmu is not on the PATH: run ./bench, which installs it")
    run(["pythonfmu", "build", "-f", ROOT / "benches" / "python_actuator.py", "-d", folder])
    return folder / "PythonActuator.fmu"


class Stepped:
    """One FMU in fmpy: its calls one by one."""

    def __init__(self, path, folder, start=()):
        self.path, self.start = str(path), dict(start)
        self.unpacked = fmpy.extract(self.path, str(folder))
        self.description = fmpy.read_model_description(self.unpacked)
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.kinds = {variable.name: variable.type for variable in self.description.modelVariables}

    @contextlib.contextmanager
    def instance(self):
        description = self.description
        fmu = FMU2Slave(guid=description.guid, unzipDirectory=self.unpacked, modelIdentifier=description.coSimulation.modelIdentifier)
        fmu.instantiate()
        for name, value in self.start.items():
            (fmu.setReal if self.kinds[name] == "Real" else fmu.setInteger)([self.references[name]], [value])
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        yield fmu
        fmu.terminate()
        fmu.freeInstance()

    def steps(self, commands):
        """Seconds of all steps, and the positions."""
        command, position, found = [self.references["command"]], [self.references["position"]], []
        with self.instance() as fmu:
            start = clock.perf_counter()
            for number, value in enumerate(commands):
                fmu.setReal(command, [value])
                fmu.doStep(number * STEP_S, STEP_S)
                found += fmu.getReal(position)
            return clock.perf_counter() - start, np.array(found)

    def simulated(self, commands):
        """Seconds of fmpy's own loop, without unpacking."""
        time = np.arange(len(commands)) * STEP_S
        signals = np.array(list(zip(time, commands)), dtype=[("time", float), ("command", float)])
        with self.instance() as fmu:
            fmu.reset()
            start = clock.perf_counter()
            with contextlib.redirect_stdout(io.StringIO()):  # it warns about inputs left at their start values
                fmpy.simulate_fmu(
                    self.unpacked, model_description=self.description, fmu_instance=fmu, start_values=self.start, stop_time=time[-1],
                    step_size=STEP_S, output_interval=STEP_S, input=signals, output=["position"], terminate=False,
                )  # fmt: skip
            return clock.perf_counter() - start


def commands(count):
    return [float(value) for value in 8.0 * (np.random.default_rng(1).random(count) - 0.5)]


def seconds(work):
    """A run that measures its own time."""
    return work()


def fmpy_floor(context):
    values = commands(500 if context.quick else 10_000)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = Stepped(context.fmu, folder / "ours", SERVO)
        empty = Stepped(empty_fmu(folder), folder / "empty")
        rounds = context.rounds(15)
        calls = in_turn(rounds, lambda: ours.steps(values)[0], lambda: empty.steps(values)[0], by=seconds)
        loops = in_turn(rounds, lambda: ours.simulated(values), lambda: empty.simulated(values), by=seconds)
    lines = []
    for key, what, (own, other) in (("calls", "setReal + doStep + getReal of FMU2Slave", calls), ("loop", "simulate_fmu, a step of 5 ms", loops)):
        own, other = (side.scaled(1e6 / len(values)) for side in (own, other))
        lines.append(Line(f"fmpy.{key}", what, "us", own, "an FMU that does nothing", other))
    return lines, []


def pythonfmu(context):
    values = commands(500 if context.quick else 10_000)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = Stepped(context.fmu, folder / "ours", SERVO)
        packed = python_fmu(folder)
        size_kb = packed.stat().st_size / 1e3
        other = Stepped(packed, folder / "python", dict(zip(("k", "omega", "zeta"), BASE)))
        own_positions, positions = ours.steps(values)[1], other.steps(values)[1]
        said = agree("position", np.abs(own_positions - positions).max() / np.abs(positions).max(), 1e-9)
        times = in_turn(context.rounds(15), lambda: ours.steps(values)[0], lambda: other.steps(values)[0], by=seconds)
    own, theirs = (side.scaled(1e6 / len(values)) for side in times)
    what = f"setReal + doStep + getReal of FMU2Slave (theirs: {size_kb:.0f} kB, needs Python where it runs)"
    return [Line("pythonfmu", what, "us", own, "pythonfmu", theirs, said)], []
