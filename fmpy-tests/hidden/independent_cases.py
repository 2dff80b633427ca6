"""One seed, one case on one of six rigs with separate sensors and loggers (`independent_rigs.py`); the rigs cycle with the seed.

    independent          all records are of the healthy rig
    independent_effect   one effect; the fit and check records differ from the model several times as much as healthy ones do

The model was fitted to a separate healthy record: order 2 or 3, with or without a delay. A healthy rig that the model describes too poorly is
redrawn; an effect that is too weak or too strong for its records at every severity is replaced by the next one of the rig.
"""

import zlib

import numpy as np

from . import independent_commands, independent_effects, independent_rigs, independent_sensors, rig_effects
from .given_model import MOST_MISSED, SHARE_LATE, fitted, left, motion, plain_enough
from .independent_equations import STEP_S
from .one_effect import bundle, first_found, runs

TRIES, TRIES_OF_A_NAME = 24, 3
CYCLES, DURATION_S, MOST_ROWS = (60.0, 240.0), (10.0, 60.0), 40_000
SEVERITIES = 16


def draw(seed, kind):
    return first_found(seed, kind, list(independent_rigs.RIGS), TRIES, draw_once)


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
    stated = independent_effects.stated(effect.name, values, drawn) if effect else {}
    return bundle(seed, kind, drawn, model, fit, check, records, effect, values, stated, more, noise={"kind": drawn.sensor.colour})


def draw_runs(rng, drawn, key):
    """A run for the model, two or three fit records, one or two check records."""
    rate = drawn.sensor.rate_hz
    duration = max(DURATION_S[0], min(rng.uniform(*CYCLES) / drawn.bandwidth_hz, DURATION_S[1], MOST_ROWS / rate))
    time = np.arange(int(duration * rate)) / rate
    kinds = [str(rng.choice(independent_commands.EVEN)), *map(str, rng.permutation(list(independent_commands.COMMANDS)))]
    fits, checks = int(rng.integers(2, 4)), int(rng.integers(1, 3))
    sizes = [1.0, 1.0, *rng.choice([1.0, 1.0, 0.6, 0.8], fits - 1), *rng.choice([1.0, 1.0, 0.8], checks)]

    def command(kind):
        return drawn.amplitude_deg * independent_commands.command(rng, kind, time, drawn.bandwidth_hz)

    model_run, *others = runs(key, kinds, sizes, command, independent_commands.DIGITS)
    return model_run, others[:fits], others[fits:]


def measured(drawn, run, name=None, values=None):
    """Columns of one record, with or without an effect; noise and clock are the same for both."""
    sensor, plant = drawn.sensor, drawn.plant
    reference = np.repeat(run.command, round(1.0 / (sensor.rate_hz * STEP_S)))
    reference = rig_effects.in_reference("delay", {"time": drawn.latency_s}, reference, STEP_S)
    if name:
        reference, plant = independent_effects.in_reference(name, values, reference, STEP_S), independent_effects.in_rig(name, values, drawn)
    seen = independent_rigs.move(plant, reference)
    drift = values["rate"] if name == "gain_drift" else 0.0
    return independent_sensors.record(np.random.default_rng(run.seed), sensor, run.command, seen, drift)
