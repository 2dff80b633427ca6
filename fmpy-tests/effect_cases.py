"""Cases of the independent reference plant, run through the packaged FMU.

A case is the keyword arguments of `reference.simulate`. `draw` makes one at random, `run` steps the FMU through it, whole or
with every step cut into pieces; `difference` compares with the reference, `difference_between_runs` two runs of the FMU.
"""

import numpy as np

import bact
from reference import random_cases
from reference.plant import NEUTRAL

CHANNELS = ("position", "deflection", "rate")
EFFECTS = tuple(NEUTRAL)
COMMANDS = ("random", "swept", "stepped")
SMALLEST_DEG, LARGEST_DEG = 1.0, 8.0  # amplitudes of commands
LOWEST_HZ, HIGHEST_HZ = 0.5, 12.0  # the sweep covers the report's frequencies
SOFTEST = -5e-4  # 1/deg^2; the cubic spring is then stable up to 17 deg, and none of these commands makes it diverge
SAMPLES = 200  # one second of control
# Allowed differences, relative to the largest drive position (rates: times omega): from the reference, and between cuts of time.
# Only the cubic spring has no closed form between events; it is integrated by a series, truncated at a fixed size.
ALLOWED, ALLOWED_WITH_CUBIC = (1e-7, 1e-9), (1e-6, 1e-7)
TIE = 1e-4  # of the peak: a value this close to the middle between two quantiser steps may be rounded to either


def draw(rng, names, kind="random", order=3, hold=True):
    """One second of a command of this kind with these effects at random strengths, on a tabulated set."""

    def value(lower, upper, spacing=None):
        return float(np.exp(rng.uniform(np.log(lower), np.log(upper)))) if spacing else float(rng.uniform(lower, upper))

    s = bact.SETS[rng.integers(len(bact.SETS))]
    effects = {name: {key: value(*limits) for key, limits in random_cases.RANGES[name].items()} for name in names}
    if "amplitude_gain" in effects:
        effects["amplitude_gain"]["cubic"] = max(effects["amplitude_gain"]["cubic"], SOFTEST)
    time = bact.CONTROL_PERIOD_S * np.arange(SAMPLES)
    return dict(base=(s.k, s.p, s.omega, s.zeta), effects=effects, time=time, command=command(rng, kind, time), load=None,
                failure=None, hold=hold, order=order, initial_position=float(rng.choice([0.0, rng.uniform(-1.0, 1.0)])))


def command(rng, kind, time):
    """Amplitude 1 to 8 deg: a new value every 25 ms; a sine from 0.5 to 12 Hz; or from one side to the other and back."""
    size = rng.uniform(SMALLEST_DEG, LARGEST_DEG)
    if kind == "random":
        return np.repeat(rng.uniform(-size, size, len(time) // 5 + 1), 5)[: len(time)]
    if kind == "swept":
        return size * np.sin(2 * np.pi * (LOWEST_HZ + 0.5 * (HIGHEST_HZ - LOWEST_HZ) * time / time[-1]) * time)
    return size * (1.0 - 2.0 * (np.floor(time / rng.uniform(0.1, 0.3)) % 2.0))


def mirrored(case):
    """The same case mirrored: command, load, start, and every parameter that belongs to one direction."""
    effects = {}
    for name, values in case["effects"].items():
        if {"up", "down"} <= values.keys():
            values = {"up": values["down"], "down": values["up"]}
        if {"min", "max"} <= values.keys():
            values = {"min": -values["max"], "max": -values["min"]}
        if name == "chatter":
            values = {**values, "phase": values["phase"] - np.copysign(np.pi, values["phase"])}
        effects[name] = {key: -value if key in ("bias", "offset", "drift") else value for key, value in values.items()}
    load = None if case["load"] is None else -case["load"]
    return {**case, "effects": effects, "command": -case["command"], "load": load, "initial_position": -case["initial_position"]}


def start_values(case):
    """The FMU's parameters for a case."""
    k, p, omega, zeta = case["base"]
    values = {"source": "custom", "custom.k": k, "custom.p": p, "custom.omega": omega, "custom.zeta": zeta,
              "order": {2: "second", 3: "third"}[case["order"]], "initial_position": case["initial_position"]}
    return values | dotted(case["effects"])


def dotted(effects):
    """{effect: {parameter: value}} by the FMU's names."""
    return {f"{effect}.{name}": value for effect, parameters in effects.items() for name, value in parameters.items()}


def run(actuator, case, pieces=None):
    """Outputs at the sample times: {channel: array}. `pieces(i, h)` returns the lengths of the pieces of step i."""
    actuator.restart(start_values(case))
    return go_on(actuator, case, 0, pieces)


def go_on(actuator, case, first, pieces=None, last=None):
    """Outputs from sample `first`, the present one of the instance, to sample `last`."""
    time, command = case["time"], case["command"]
    linear = case.get("hold", True) is False
    results = [[actuator[name] for name in CHANNELS] + [actuator["saturated"]]]
    for i in range(first, len(time) - 1 if last is None else last):
        h = time[i + 1] - time[i]
        actuator["command"] = command[i]
        if linear:
            actuator.set_slope((command[i + 1] - command[i]) / h)
        if case["load"] is not None:
            actuator["load"] = case["load"][i]
            if linear:
                actuator.set_slope((case["load"][i + 1] - case["load"][i]) / h, "load")
        if case["failure"] is not None:
            actuator["failure"] = int(case["failure"][i]) + 1
        saturated = False
        for piece in [h] if pieces is None else pieces(i, h):
            actuator.step(piece)
            saturated |= actuator["saturated"]
        results.append([actuator[name] for name in CHANNELS] + [saturated])
    columns = np.array(results, dtype=float).T
    return dict(zip((*CHANNELS, "saturated"), columns))


def allowed(case):
    """(from the reference, between cuts of time)"""
    return ALLOWED_WITH_CUBIC if "amplitude_gain" in case["effects"] else ALLOWED


def five_pieces(_, h):
    return [h / 5] * 5


def irregular_pieces(rng, count=5):
    """A new cut of every step, at random."""
    return lambda _, h: np.diff(np.concatenate([[0.0], np.sort(rng.uniform(0.0, h, count - 1)), [h]]))


def peak(expected):
    """Largest position of the drive; errors are relative to it."""
    return max(np.abs(expected["drive"]).max(), 1e-3)


def away_from_ties(case, expected):
    """Samples whose quantisation does not depend on the last digits."""
    if "quantisation" not in case["effects"]:
        return np.ones(len(case["time"]), bool)
    step = case["effects"]["quantisation"]["step"]
    return np.abs(np.abs(expected["unquantised"] / step) % 1.0 - 0.5) > TIE * peak(expected) / step


def difference(case, found, expected):
    """Largest difference of position and deflection, relative to the peak of the drive, and of the rate, to omega times that."""
    keep, omega = away_from_ties(case, expected), case["base"][2]
    return max(np.abs(found["position"] - expected["position"])[keep].max(),
               np.abs(found["deflection"] - expected["deflection"]).max(),
               np.abs(found["rate"] - expected["rate"]).max() / omega) / peak(expected)


def difference_between_runs(case, one, other, expected):
    """The same for two runs; the reference only gives the size of the motion and the samples where a rounding is a tie."""
    return difference(case, one, {**expected, **other})
