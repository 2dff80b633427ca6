"""One seed, one case on one of six rigs with sensors and loggers of their own (`independent_rigs.py`); the rigs go round with the seed.

    independent          all records are of the healthy rig
    independent_effect   one effect; the records to fit and to check differ from the model several times as much as healthy ones do

The model was fitted to a healthy record of its own: order 2 or 3, with or without a delay. A healthy rig that it misses by too much, and an
effect that is too weak or too strong for its records at every severity, are drawn again, the effect as the next one of the rig.
"""

import zlib
from typing import NamedTuple

import numpy as np

from . import independent_commands, independent_effects, independent_rigs, independent_sensors, rig_effects
from .bundle import Bundle, model_text
from .given_model import MOST_MISSED, SHARE_LATE, fitted, left, motion, plain_enough
from .independent_equations import STEP_S
from .rig_cases import ROUNDING, unreached

TRIES, TRIES_OF_A_NAME = 24, 3
CYCLES, DURATION_S, MOST_ROWS = (60.0, 240.0), (10.0, 60.0), 40_000
SEVERITIES = 16
DIGITS = 12  # written: of a clock that began an hour ago


class Run(NamedTuple):
    name: str
    command: np.ndarray
    seed: tuple  # of sensor and logger


def draw(seed, kind):
    name = list(independent_rigs.RIGS)[seed % len(independent_rigs.RIGS)]
    for attempt in range(TRIES):
        try:
            found = draw_once(seed, kind, name, attempt)
        except FloatingPointError:
            continue
        if found:
            return found
    raise RuntimeError(f"seed {seed}: no {kind} on {name} in {TRIES} tries")


def draw_once(seed, kind, name, attempt):
    key = (seed, zlib.crc32(kind.encode()), attempt)
    rng = np.random.default_rng(key)
    drawn = independent_rigs.draw(rng, name)
    model_run, fit, check = draw_runs(rng, drawn, key)
    healthy = measured(drawn, model_run)
    model = fitted(healthy, int(rng.choice([2, 3])), rng.random() < SHARE_LATE, drawn.bandwidth_hz, drawn.sensor.rate_hz)
    records = [measured(drawn, run) for run in fit + check]
    missed = np.array([left(model, columns) for columns in records])
    if np.max(missed / [motion(columns) for columns in records]) > MOST_MISSED:
        return None
    effect, values, more = None, {}, 0.0
    if kind == "independent_effect":
        chosen = independent_effects.name(drawn, seed, len(independent_rigs.RIGS), attempt // TRIES_OF_A_NAME)
        effect = independent_effects.draw(rng, chosen, drawn, model.delay_s > 0.0)

        def measure(name, values):
            return [measured(drawn, run, name, values) for run in fit + check]

        values, records, more = plain_enough(rng, model, measure, effect, SEVERITIES, len(fit), missed)
        if not values:
            return None
    return bundle(seed, kind, drawn, model, fit, check, records, effect, values, more)


def draw_runs(rng, drawn, key):
    """A run for the model, two or three to fit, one or two to check."""
    rate = drawn.sensor.rate_hz
    duration = max(DURATION_S[0], min(rng.uniform(*CYCLES) / drawn.bandwidth_hz, DURATION_S[1], MOST_ROWS / rate))
    time = np.arange(int(duration * rate)) / rate
    kinds = [str(rng.choice(independent_commands.EVEN)), *map(str, rng.permutation(list(independent_commands.COMMANDS)))]
    fits, checks = int(rng.integers(2, 4)), int(rng.integers(1, 3))
    sizes = [1.0, 1.0, *rng.choice([1.0, 1.0, 0.6, 0.8], fits - 1), *rng.choice([1.0, 1.0, 0.8], checks)]
    runs = []
    for index, (kind, size) in enumerate(zip(kinds, sizes)):
        command = drawn.amplitude_deg * size * independent_commands.command(rng, kind, time, drawn.bandwidth_hz)
        runs.append(Run(f"{kind}_{index}.csv", np.round(command, independent_commands.DIGITS), (*key, index)))
    return runs[0], runs[1 : 1 + fits], runs[1 + fits :]


def measured(drawn, run, name=None, values=None):
    """Columns of one record, with an effect or without; noise and clock are the same for either."""
    sensor, plant = drawn.sensor, drawn.plant
    reference = np.repeat(run.command, round(1.0 / (sensor.rate_hz * STEP_S)))
    reference = rig_effects.in_reference("delay", {"time": drawn.latency_s}, reference, STEP_S)
    if name:
        reference, plant = independent_effects.in_reference(name, values, reference, STEP_S), independent_effects.in_rig(name, values, drawn)
    seen = independent_rigs.move(plant, reference)
    drift = values["rate"] if name == "gain_drift" else 0.0
    return independent_sensors.record(np.random.default_rng(run.seed), sensor, run.command, seen, drift)


def bundle(seed, kind, drawn, model, fit, check, records, effect, values, more):
    sensor, names = drawn.sensor, [run.name for run in fit + check]
    stated = independent_effects.stated(effect.name, values, drawn) if effect else {}
    positions = [columns["position"] for columns in records]
    truth = {
        "seed": seed, "kind": kind, "rig": drawn.name, "number": seed, "truth": [effect.name] if effect else [],
        "effects": {effect.name: stated} if effect else {}, "in_rig": values, "strength_scored": bool(effect and effect.scored),
        "unseen": unreached(effect, stated, fit, positions, range(len(fit))), "inherent": list(drawn.inherent), "outside": list(drawn.outside),
        "coasts": drawn.coasts, "bandwidth_hz": drawn.bandwidth_hz, "rate_hz": sensor.rate_hz, "order": model.order, "model": list(model.base),
        "model_delay_s": model.delay_s, "model_is_off": True, "noise": {"kind": sensor.colour},
        "noise_rms": float(np.hypot(sensor.noise_rms, sensor.step / ROUNDING)), "enr": more, "enr_of": {effect.name: more} if effect else {},
        "enr_check": more, "base": dict(zip(("k", "p", "omega", "zeta"), model.base)), "load_recorded": False, "sensor": vars(sensor),
        "plant": {key: float(value) for key, value in drawn.plant._asdict().items()},
    }  # fmt: skip
    text = model_text(model.base, model.order, model.delay_s)
    return Bundle(dict(zip(names, records)), names[: len(fit)], names[len(fit) :], text, truth, digits=DIGITS)
