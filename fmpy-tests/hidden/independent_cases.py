"""One seed, one case on one of six rigs with sensors and loggers of their own (`independent_rigs.py`); the rigs go round with the seed.

    independent          all records are of the healthy rig
    independent_effect   one effect; the records to fit and to check differ from the model several times as much as healthy ones do

The model was fitted to a healthy record of its own: order 2 or 3, with or without a delay. A healthy rig that it misses by too much, and an
effect that is too weak or too strong for its records at every severity, are drawn again, the effect as the next one of the rig.
"""

import zlib
from typing import NamedTuple

import numpy as np
from scipy import optimize

from . import independent_commands, independent_effects, independent_rigs, independent_sensors, linear_fit, rig_effects
from .bundle import Bundle, model_text
from .independent_equations import STEP_S
from .rig_cases import ROUNDING, rms, unreached

TRIES, TRIES_OF_A_NAME = 24, 3
CYCLES, DURATION_S, MOST_ROWS = (60.0, 240.0), (10.0, 60.0), 40_000
MODEL_ROWS = 12_000  # of the record that the model is fitted to
LATEST = 0.15  # delay of a model, over the period of the bandwidth
SHARE_LATE = 1.0 / 3.0  # of the models
MOST_MISSED = 0.12  # of the motion, by the model of a healthy rig
SEVERITIES = 16
MORE = (3.2, 9.0)  # difference from the model with the effect over that without, both rms
# Of that in single records: all but one; one to fit and one to check, at least; and the most that the difference may be of the motion.
MORE_IN_EACH, MORE_IN_ONE, MOST_OF_MOTION = 2.0, (3.0, 2.5), 0.5
DIGITS = 12  # written: of a clock that began an hour ago


class Run(NamedTuple):
    name: str
    command: np.ndarray
    seed: tuple  # of sensor and logger


class Model(NamedTuple):
    base: tuple
    order: int
    delay_s: float


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
    model = fitted(drawn, measured(drawn, model_run), int(rng.choice([2, 3])), rng.random() < SHARE_LATE)
    records = [measured(drawn, run) for run in fit + check]
    missed = np.array([left(model, columns) for columns in records])
    if np.max(missed / [motion(columns) for columns in records]) > MOST_MISSED:
        return None
    effect, values, more = None, {}, 0.0
    if kind == "independent_effect":
        chosen = independent_effects.name(drawn, seed, len(independent_rigs.RIGS), attempt // TRIES_OF_A_NAME)
        effect = independent_effects.draw(rng, chosen, drawn, model.delay_s > 0.0)
        values, records, more = plain_enough(rng, drawn, model, fit, check, effect, missed)
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


def fitted(drawn, columns, order, is_late):
    """A model of a healthy record, with a delay or without."""
    time, command, position = (values[:MODEL_ROWS] for values in columns.values())
    start, _ = linear_fit.fit(time, command, position, order, drawn.bandwidth_hz, most_rows=MODEL_ROWS)
    if not is_late:
        return Model(start, order, 0.0)

    def of_delay(delay_s):
        return linear_fit.fit(time, late(command, delay_s * drawn.sensor.rate_hz), position, order, drawn.bandwidth_hz, start, MODEL_ROWS)

    best = optimize.minimize_scalar(lambda delay_s: rms(of_delay(delay_s)[1]), bounds=(0.0, LATEST / drawn.bandwidth_hz), method="bounded",
                                    options={"maxiter": 12})  # fmt: skip
    return Model(of_delay(best.x)[0], order, float(best.x))


def late(command, samples):
    """A held command later by part of a sample or more, at the samples."""
    whole = int(samples)
    first, second = (np.r_[np.full(n, command[0]), command[: len(command) - n]] for n in (whole, whole + 1))
    return first + (samples - whole) * (second - first)


def left(model, columns):
    """What a model leaves of a record, less its mean, rms."""
    time, command, position = columns.values()
    sample_time = (time[-1] - time[0]) / (len(time) - 1)
    gap = position - linear_fit.respond(model.base, model.order, late(command, model.delay_s / sample_time), sample_time)
    return float(np.std(gap))


def motion(columns):
    return float(np.std(columns["position"]))


def plain_enough(rng, drawn, model, fit, check, effect, missed):
    """Values, records and how much more these differ from the model, from the weakest severity on that is plain; no values if there is none."""
    wanted, found = rng.uniform(*MORE), ({}, [], 0.0)
    for severity in np.geomspace(effect.least, effect.most, SEVERITIES):
        values = {key: float(value) for key, value in effect.parameters(severity).items()}
        records = [measured(drawn, run, effect.name, values) for run in fit + check]
        gaps = np.array([left(model, columns) for columns in records])
        if np.max(gaps / [motion(columns) for columns in records]) > MOST_OF_MOTION:
            break
        more, each = rms(gaps) / rms(missed), gaps / missed
        to_fit, to_check = each[: len(fit)].max(), each[len(fit) :].max()
        if np.sum(each >= MORE_IN_EACH) >= len(each) - 1 and to_fit >= MORE_IN_ONE[0] and to_check >= MORE_IN_ONE[1]:
            found = values, records, float(more)
            if more >= wanted:
                break
    return found


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
