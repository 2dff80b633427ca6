"""The actuator FMU in the loop, stepped by a script: the wing here, exactly; the actuator in its FMU.

Two ways to step, with communication step H:

`in_turn` (Gauss-Seidel)  The actuator first, on the command and its slope at the start of the step (the slope follows from
    the wing's states); then the wing, on the deflection that moves linearly from its old value to the new one. No delay
    is added: there remains a gain error of (w H)^2/6 and (w H)^2/12, together 3e-4 at 5.3 Hz and 1 ms.

`side_by_side` (Jacobi)   Both with the values at the start of the step held, as importers of FMUs do. Each hold adds H/2, the
    loop has a delay of H. The wing can predict the command H ahead for a constant deflection (`prediction_s` = H), which
    removes that delay up to (w H)^2.
"""

from ctypes import c_double, c_int, c_uint
from dataclasses import dataclass

import numpy as np
from fmpy.fmi2 import fmi2OK

from flutter import wing

STEP_S = 0.001  # communication step: 190 steps in a period of 5.3 Hz
DEFLECTION_OUTPUT = "deflection"  # before the sensor: the aerodynamic deflection


@dataclass(frozen=True)
class Response:
    """Results of a run; arrays over the communication points."""

    time: np.ndarray  # s
    plunge: np.ndarray  # ft
    pitch: np.ndarray  # deg
    command: np.ndarray  # deg, demand of the control law
    deflection: np.ndarray  # deg

    def after(self, time_s):
        """The part from this time on."""
        keep = self.time >= time_s
        return Response(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))


class ActuatorSteps:
    """Steps an actuator FMU with as little Python per step as ctypes allows."""

    def __init__(self, actuator, parameters):
        actuator.restart(parameters)
        self._actuator, self._dll, self._component = actuator, actuator.fmu.dll, actuator.fmu.component
        self._input, self._output = ((c_uint * 1)(actuator.vr(name)) for name in ("command", DEFLECTION_OUTPUT))
        self._order, self._value = (c_int * 1)(1), (c_double * 1)()
        self._time = 0.0

    def step(self, command, slope, step_s):
        """Deflection [deg] at the end of a step in which the command [deg] has this slope [deg/s]."""
        value, dll, component = self._value, self._dll, self._component
        value[0] = command
        status = dll.fmi2SetReal(component, self._input, 1, value)
        if slope is not None:
            value[0] = slope
            status |= dll.fmi2SetRealInputDerivatives(component, self._input, 1, self._order, value)
        status |= dll.fmi2DoStep(component, self._time, step_s, 1)
        status |= dll.fmi2GetReal(component, self._output, 1, value)
        if status != fmi2OK:
            raise RuntimeError(f"the actuator FMU at {self._time} s: status {status}: {self._actuator.text}")
        self._time += step_s
        return value[0]


def in_turn(
    actuator, parameters, pressure_psf, duration_s, plunge_ft=0.01, gain=1.0, step_s=STEP_S, gust_ft_s=None, bound_deg=np.inf
):
    """The loop, actuator before wing. `gust_ft_s(time)` is a gust; a pitch beyond `bound_deg` ends the run."""
    steps = round(duration_s / step_s)
    a, _, command_row = wing.wing_with_control(pressure_psf, gain=gain)
    slope_row = command_row @ a  # no input acts on pitch or on the control law's states at once
    phi, held, moving = wing.transition(pressure_psf, wing.SPEED_FT_S, step_s)
    gusts = np.zeros(steps + 1) if gust_ft_s is None else gust_ft_s(step_s * np.arange(steps + 1))
    gust_part = np.outer(gusts[:-1], held[:, wing.GUST]) + np.outer(np.diff(gusts) / step_s, moving[:, wing.GUST])
    # d + (d+ - d)/H t through the step:  G0 d + G1 (d+ - d)/H
    from_new = moving[:, wing.DEFLECTION] / step_s
    from_old = held[:, wing.DEFLECTION] - from_new
    fmu = ActuatorSteps(actuator, parameters)
    states, deflections = np.zeros((steps + 1, wing.STATES)), np.zeros(steps + 1)
    states[0, wing.PLUNGE] = plunge_ft
    state, deflection, bound = states[0], 0.0, np.radians(bound_deg)
    for i in range(steps):
        new = fmu.step(command_row @ state, slope_row @ state, step_s)
        state = phi @ state + from_old * deflection + from_new * new + gust_part[i]
        deflection = new
        states[i + 1], deflections[i + 1] = state, new
        if abs(state[wing.PITCH]) > bound:
            steps = i + 1
            break
    return _response(states[: steps + 1], deflections[: steps + 1], command_row, step_s)


def side_by_side(actuator, parameters, pressure_psf, duration_s, plunge_ft=0.01, gain=1.0, step_s=STEP_S, prediction_s=0.0):
    """The loop, both stepped with the values at the start of the step held; `command` is the predicted output of the wing."""
    steps = round(duration_s / step_s)
    _, _, command_row = wing.wing_with_control(pressure_psf, gain=gain)
    phi, held, _ = wing.transition(pressure_psf, wing.SPEED_FT_S, step_s)
    ahead, ahead_held, _ = wing.transition(pressure_psf, wing.SPEED_FT_S, prediction_s)
    ahead_row, ahead_deflection = command_row @ ahead, command_row @ ahead_held[:, wing.DEFLECTION]
    fmu = ActuatorSteps(actuator, parameters)
    states, deflections, commands = np.zeros((steps + 1, wing.STATES)), np.zeros(steps + 1), np.zeros(steps + 1)
    states[0, wing.PLUNGE] = plunge_ft
    state, deflection, known = states[0], 0.0, 0.0  # `known`: the last deflection passed to the wing
    commands[0] = ahead_row @ state + ahead_deflection * known
    for i in range(steps):
        new = fmu.step(commands[i], None, step_s)
        state, known = phi @ state + held[:, wing.DEFLECTION] * deflection, deflection
        deflection = new
        states[i + 1], deflections[i + 1] = state, new
        commands[i + 1] = ahead_row @ state + ahead_deflection * known
    return _response(states, deflections, command_row, step_s, commands)


def _response(states, deflections, command_row, step_s, commands=None):
    return Response(
        step_s * np.arange(len(states)), states[:, wing.PLUNGE], np.degrees(states[:, wing.PITCH]),
        states @ command_row if commands is None else commands, deflections,
    )  # fmt: skip
