"""One seed, one case on one of eight drives with separate sensors, loggers and commands (`drive_rigs.py`); the drives cycle with the seed.

    drive          all records are of the healthy drive
    drive_effect   one effect; the fit and check records differ from the model several times as much as healthy ones do

Every record is a session: friction, gain, offset and the phase of the bus are redrawn. The model was fitted to a separate healthy record
(`given_model.py`). A healthy drive that the model describes too poorly is redrawn; an effect that is too weak or too strong for its records at every
severity is replaced by the next one of the drive.
"""

import zlib

import numpy as np

from . import drive_commands, drive_effects, drive_rigs, drive_sensors
from .given_model import MOST_MISSED, SHARE_LATE, fitted, left, motion, plain_enough
from .one_effect import bundle, first_found, runs

TRIES, TRIES_OF_A_NAME = 30, 3
CYCLES, DURATION_S, MOST_ROWS = (40.0, 150.0), (9.0, 40.0), 30_000
SEVERITIES = 12
SIZES = (1.0, 0.85, 0.7, 0.55)  # of the records' amplitudes, to one another


def draw(seed, kind):
    return first_found(seed, kind, list(drive_rigs.RIGS), TRIES, draw_once)


def draw_once(seed, kind, name, attempt):
    key = (seed, zlib.crc32(kind.encode()), attempt)
    rng = np.random.default_rng(key)
    drawn = drive_rigs.draw(rng, name)
    model_run, fit, check = draw_runs(rng, drawn, key)
    first = evenly(measured(drawn, model_run), drawn.sensor)
    model = fitted(first, int(rng.choice([2, 3])), rng.random() < SHARE_LATE, drawn.bandwidth_hz, drawn.sensor.rate_hz)

    def measure(name=None, values=None):
        return [measured(drawn, run, name, values) for run in fit + check]

    def gap(model, columns):
        return left(model, evenly(columns, drawn.sensor))

    records = measure()
    missed = np.array([gap(model, columns) for columns in records])
    if np.max(missed / [motion(columns) for columns in records]) > MOST_MISSED:
        return None
    effect, values, more = None, {}, 0.0
    if kind == "drive_effect":
        chosen = drive_effects.name(drawn, seed, len(drive_rigs.RIGS), attempt // TRIES_OF_A_NAME)
        effect = drive_effects.draw(rng, chosen, drawn, model.delay_s > 0.0)
        values, records, more = plain_enough(rng, model, measure, effect, SEVERITIES, len(fit), missed, gap)
        if not values:
            return None
    stated = drive_effects.stated(effect.name, values, drawn) if effect else {}
    return bundle(seed, kind, drawn, model, fit, check, records, effect, values, stated, more, noise=drawn.sensor.colour, tries=attempt + 1, bus_s=drawn.bus_s)


def draw_runs(rng, drawn, key):
    """A run for the model, two or three fit records, one or two check records; one of each has the full amplitude."""
    rate = drawn.sensor.rate_hz
    duration = max(DURATION_S[0], min(rng.uniform(*CYCLES) / drawn.bandwidth_hz, DURATION_S[1], MOST_ROWS / rate))
    time = np.arange(int(duration * rate)) / rate
    kinds = [str(rng.choice(drive_commands.EVEN)), *map(str, rng.permutation(list(drive_commands.COMMANDS)))]
    fits, checks = int(rng.integers(2, 4)), int(rng.integers(1, 3))
    sizes = [1.0, *rng.permutation([1.0, *rng.choice(SIZES, fits - 1)]), *rng.permutation([1.0, *rng.choice(SIZES, checks - 1)])]

    def command(kind):
        return drawn.amplitude_deg * drive_commands.command(rng, kind, time, drawn.bandwidth_hz)

    model_run, *others = runs(key, kinds, sizes, command, drawn.sensor.digits)
    return model_run, others[:fits], others[fits:]


def measured(drawn, run, name=None, values=None):
    """Columns of one record, with or without an effect; session, noise and clock are the same for both."""
    rng, sensor = np.random.default_rng(run.seed), drawn.sensor
    h = drive_rigs.step_s(sensor.rate_hz)
    plant, phase = drive_rigs.on_a_day(rng, drawn), rng.random()
    reference = np.repeat(run.command, round(1.0 / (sensor.rate_hz * h)))
    if name:
        reference, plant = drive_effects.in_reference(name, values, reference, h), drive_effects.in_plant(name, values, plant)
    seen = drive_rigs.move(plant, drive_rigs.set_points(drawn, reference, h, phase), h)
    if name:
        seen = drive_effects.at_output(name, values, seen, plant, h)
    return drive_sensors.record(rng, sensor, run.command, seen, h, (name, values) if name in drive_effects.OF_SENSOR else None)


def evenly(columns, sensor):
    """The same record on a uniform clock: lost rows are filled from their neighbours, the command from the previous row."""
    time, command, position = columns.values()
    if not sensor.lost:
        return columns
    even = np.linspace(time[0], time[-1], round((time[-1] - time[0]) / sensor.clock * sensor.rate_hz) + 1)
    before = np.searchsorted(time, even + 0.5 / sensor.rate_hz) - 1
    return {"time": even, "command": command[np.clip(before, 0, None)], "position": np.interp(even, time, position)}
