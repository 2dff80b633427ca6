"""The FMU integrated by CVode (BDF, fmpy's own build of it), with an input that is exact at every instant.

fmpy's `simulate_fmu` sets the input only at the end of a step of CVode, so that CVode sees a changing command late, but steps in time.
Here the input follows the solver. Between samples a signal is held or linear; every sample is an input event, between which
CVode sees straight lines.
"""

import contextlib
from ctypes import c_double, c_uint
from dataclasses import dataclass, field

import numpy as np
from fmpy.fmi2 import FMU2Model
from fmpy.sundials import CVodeSolver

from actuator_fmu import Instance

OUTPUTS = ("position", "deflection", "rate")
TOLERANCE = 1e-10  # tolerance of CVode: relative, and absolute times the nominal values
LONGEST_STEP_S = 0.001


class Lines:
    """Inputs that are linear from the last sample on."""

    def __init__(self, exchange, names):
        self.fmu, self.references = exchange.fmu, (c_uint * len(names))(*map(exchange.vr, names))
        self.start, self.values, self.slopes = 0.0, np.zeros(len(names)), np.zeros(len(names))
        self.buffer = (c_double * len(names))()

    def apply(self, time):
        self.buffer[:] = self.values + self.slopes * (time - self.start)
        self.fmu.fmi2SetReal(self.fmu.component, self.references, len(self.buffer), self.buffer)


class Curve(Lines):
    """A command that is any function of time."""

    def __init__(self, exchange, function):
        super().__init__(exchange, ["command"])
        self.function = function

    def apply(self, time):
        self.buffer[0] = self.function(time)
        self.fmu.fmi2SetReal(self.fmu.component, self.references, 1, self.buffer)


class Solver(CVodeSolver):
    """fmpy's, with the input set wherever the derivatives are asked for."""

    def f(self, t, y, ydot, user_data):
        self.set_time(t)
        self.input.apply(t)
        self.set_x(self.px_of(y), self.nx)
        self.get_dx(self.px_of(ydot), self.nx)
        return 0

    @staticmethod
    def px_of(vector):
        from fmpy.sundials.nvector_serial import NV_DATA_S

        return NV_DATA_S(vector)


@dataclass
class Trajectory:
    outputs: dict  # {name: array}, just before the event at each sample
    state_events: list = field(default_factory=list)  # [(time, indicators that changed sign)]
    time_events: list = field(default_factory=list)
    step_events: int = 0


class Exchange(Instance):
    """An instance for model exchange."""

    def __init__(self, package, logging=True):
        description = package.description
        super().__init__(FMU2Model, description.modelExchange.modelIdentifier, package, "exchange", logging)
        self.next_event = None
        self.states, self.indicators = description.numberOfContinuousStates, description.numberOfEventIndicators

    def initialize(self, values=None, start_time=0.0):
        """From instantiated or any other mode to continuous-time mode."""
        self.fmu.reset()
        for name, value in (values or {}).items():
            self[name] = value
        self.fmu.setupExperiment(startTime=start_time)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = start_time
        self.iterate()
        return self

    def iterate(self):
        """Event mode to continuous-time mode."""
        needed = True
        while needed:
            needed, _, _, _, defined, time = self.fmu.newDiscreteStates()
        self.next_event = time if defined else None
        self.fmu.enterContinuousTimeMode()

    def margins(self):
        values = (c_double * self.indicators)()
        self.fmu.getEventIndicators(values, self.indicators)
        return np.array(values)

    def get_states(self):
        values = (c_double * self.states)()
        self.fmu.getContinuousStates(values, self.states)
        return np.array(values)

    def derivatives(self):
        values = (c_double * self.states)()
        self.fmu.getDerivatives(values, self.states)
        return np.array(values)

    def set_states(self, values):
        self.fmu.setContinuousStates((c_double * self.states)(*values), self.states)

    def integrate(self, time, inputs, hold=True, discrete=None, outputs=OUTPUTS, tolerance=TOLERANCE):
        """Through inputs {name: one value per time}, from the present time of the instance; `discrete`: the same for Integers."""
        fmu, lines = self.fmu, Lines(self, list(inputs))
        columns = np.array(list(inputs.values()), dtype=float)
        lines.start = self.time
        solver = self.solver(lines, tolerance)
        found = Trajectory({name: [self[name]] for name in outputs})
        for i in range(len(time) - 1):
            start, end = float(time[i]), float(time[i + 1])
            before = columns[:, i - 1] if i else None
            if not hold or before is None or (before != columns[:, i]).any() or self.changes(discrete, i):
                fmu.enterEventMode()
                lines.start, lines.values = start, columns[:, i]
                lines.slopes = np.zeros(len(columns)) if hold else (columns[:, i + 1] - columns[:, i]) / (end - start)
                lines.apply(start)
                for name, values in (discrete or {}).items():
                    self[name] = int(values[i])
                self.iterate()
                solver.reset(start)
            self.run_to(end, solver, lines, found)
            for name in outputs:
                found.outputs[name].append(self[name])
        found.outputs = {name: np.array(values, dtype=float) for name, values in found.outputs.items()}
        return found

    def solver(self, lines, tolerance=TOLERANCE):
        fmu = self.fmu
        return Solver(
            nx=self.states, nz=self.indicators, get_x=fmu.getContinuousStates, set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives, get_z=fmu.getEventIndicators, get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=fmu.setTime, input=lines, startTime=self.time, maxStep=LONGEST_STEP_S, relativeTolerance=tolerance,
            maxNumSteps=100_000,
        )  # fmt: skip

    def follow(self, function, accepted_s, steps):
        """Positions at the end of steps of this length, each announced as completed, under a command of any form."""
        curve, found = Curve(self, function), Trajectory({})
        solver, positions = self.solver(curve), []
        for i in range(steps):
            self.run_to(accepted_s * (i + 1), solver, curve, found)
            positions.append(self["position"])
        return np.array(positions)

    @staticmethod
    def changes(discrete, i):
        return i == 0 or any(values[i] != values[i - 1] for values in (discrete or {}).values())

    def run_to(self, end, solver, lines, found):
        while self.time < end:
            until = end if self.next_event is None else min(end, self.next_event)
            state_event, roots, self.time = solver.step(self.time, until)
            self.fmu.setTime(self.time)
            lines.apply(self.time)
            step_event, _ = self.fmu.completedIntegratorStep()
            time_event = self.time == self.next_event
            if state_event:
                found.state_events.append((self.time, np.flatnonzero(roots)))
            if time_event:
                found.time_events.append(self.time)
            found.step_events += step_event
            if state_event or time_event or step_event:
                self.fmu.enterEventMode()
                self.iterate()
                solver.reset(self.time)


@contextlib.contextmanager
def exchange(package):
    made = Exchange(package)
    try:
        yield made
    finally:
        made.close()
