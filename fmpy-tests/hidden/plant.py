"""A servo-actuator in short steps of time: the plant behind the records of the hidden-effect suite.

The third formulation of the same equations in this repository, made for thousands of records: short Runge-Kutta steps compiled by
numba, where `reference` solves by collocation and is a hundred times slower. Beyond the effects of `reference` it has some that the library
does not contain (`OUTSIDE`).

    command side  straight lines and jumps, that of `reference.command_side`, exact
    servo         closed form between the corners of the command                                        loop.py
    loop          Runge-Kutta, order 4, cut at the changes of motion                                    loop.py
    output side   plays, structural mode, lag                                                           output.py
    sensor        bias and chatter, here; noise comes next and rounding last (`records.py`)

Its error against `reference` is about 1e-5 of the motion (`test_plant.py`), far below noise/sqrt(N) of a record.
"""

import numpy as np

from reference import command_side
from reference.plant import complete

from . import loop, output

# Not in the library of effects. Neutral values; equations in loop.py and output.py.
OUTSIDE = {
    "distributed_play": {"share": 0.0, "first": 0.0, "last": 0.0, "count": 0},
    "bouc_wen": {"hysteresis": 0.0, "reach": 1.0},
    "drifting_omega": {"drift": 0.0, "swing": 0.0, "period": 10.0},
}
# In the order of the chain.
COMMAND_SIDE = {
    "delay": command_side.delay, "command_limit": command_side.clamp, "command_rate_limit": command_side.rate_limit,
    "command_dead_zone": command_side.dead_zone, "command_backlash": command_side.play, "asymmetric_gain": command_side.asymmetric_gain,
}  # fmt: skip
SAME_INSTANT_S = 1e-12


def simulate(base, effects, time, command, load=None, order=3, hold=True):
    """Position before noise and rounding [deg]; command held or linear between samples, load held; at rest at 0 before time[0].

    base: (k, p, omega, zeta); effects: as in `reference.simulate`, and those of OUTSIDE.
    """
    full = complete({name: values for name, values in effects.items() if name not in OUTSIDE})
    full |= {name: {**neutral, **effects.get(name, {})} for name, neutral in OUTSIDE.items()}
    time = np.asarray(time, float)
    shaped = command_side.sampled(time, np.asarray(command, float), hold, 0.0, time[-1] + 1.0)
    shaped = _command_side(shaped, {name: full[name] for name in effects if name not in OUTSIDE})

    corners = np.unique(np.concatenate([shaped.start, time]))
    corners = corners[np.r_[np.diff(corners) > SAME_INSTANT_S, True] & (corners <= time[-1] + SAME_INSTANT_S)]
    piece = np.searchsorted(shaped.start, corners + SAME_INSTANT_S, side="right") - 1
    commands = shaped.value[piece] + shaped.slope[piece] * (corners - shaped.start[piece])
    loads = np.zeros(len(time)) if load is None else np.asarray(load, float)
    loads = loads[np.searchsorted(time, corners + SAME_INSTANT_S, side="right") - 1]

    instants, drive, at_corner = loop.march(corners, commands, shaped.slope[piece], loads, loop.constants(base, full, order))
    measured = output.follow(instants, drive, *output.plays(full), output.constants(full))
    sample_of = np.searchsorted(corners, time - SAME_INSTANT_S)
    return _sensor(measured[at_corner[sample_of]], time, full)


def _command_side(signal, effects):
    """As `command_side.shape`, which also evaluates neutral effects."""
    for name, operator in COMMAND_SIDE.items():
        if name in effects:
            signal = operator(signal, *effects[name].values())
    return signal


def _sensor(position, time, full):
    bias, chatter = full["sensor_bias"], full["chatter"]
    position = position + bias["offset"] + bias["drift"] * time
    return position + chatter["amplitude"] * np.sin(2.0 * np.pi * chatter["frequency"] * time + chatter["phase"])
