"""The loop as two FMUs, BactWing and BactActuator, stepped here as any importer with a fixed step does, in twenty lines.

`side_by_side` (Jacobi) exchanges both outputs and then steps both; `in_turn` (Gauss-Seidel) steps the actuator on the
command and its derivative, then the wing on the deflection that moves linearly to the new value.
"""

import contextlib

import numpy as np

from actuator_fmu import Actuator, unpacked
from flutter import loop

WING_OUTPUTS = ("plunge", "pitch", "command")


@contextlib.contextmanager
def opened(actuator_path, wing_path):
    """(actuator, wing): an instance of each FMU."""
    with unpacked(actuator_path) as first, unpacked(wing_path) as second:
        with Actuator(first, "actuator") as actuator, Actuator(second, "wing") as wing:
            yield actuator, wing


def side_by_side(units, actuator_parameters, wing_parameters, duration_s, step_s=loop.STEP_S):
    """Both with the values at the start of the step held."""
    actuator, wing = _started(units, actuator_parameters, wing_parameters)
    rows = [_row(units)]
    for _ in range(round(duration_s / step_s)):
        command, deflection = wing["command"], actuator[loop.DEFLECTION_OUTPUT]
        actuator["command"], wing["deflection"] = command, deflection
        actuator.step(step_s)
        wing.step(step_s)
        rows.append(_row(units))
    return _response(rows, step_s)


def in_turn(units, actuator_parameters, wing_parameters, duration_s, step_s=loop.STEP_S):
    """The actuator first, both with inputs that are linear within the step."""
    actuator, wing = _started(units, actuator_parameters, wing_parameters)
    rows, command = [_row(units)], wing.vr("command")
    for _ in range(round(duration_s / step_s)):
        before = actuator[loop.DEFLECTION_OUTPUT]
        actuator["command"] = wing["command"]
        actuator.set_slope(wing.fmu.getRealOutputDerivatives([command], [1])[0])
        actuator.step(step_s)
        wing["deflection"] = before
        wing.set_slope((actuator[loop.DEFLECTION_OUTPUT] - before) / step_s, "deflection")
        wing.step(step_s)
        rows.append(_row(units))
    return _response(rows, step_s)


def _started(units, actuator_parameters, wing_parameters):
    for unit, parameters in zip(units, (actuator_parameters, wing_parameters)):
        unit.restart(parameters)
    return units


def _row(units):
    actuator, wing = units
    return [wing[name] for name in WING_OUTPUTS] + [actuator[loop.DEFLECTION_OUTPUT]]


def _response(rows, step_s):
    return loop.Response(step_s * np.arange(len(rows)), *np.array(rows).T)
