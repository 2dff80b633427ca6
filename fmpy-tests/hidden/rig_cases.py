"""One seed, one case on a rig whose structure is not that of the product's servo, healthy or with one dominant effect.

    rig_healthy   all records are healthy repeats, the model was fitted to another one (or is in error): no nameable effect is missing
    rig_effect    the same kinds of rig with one effect, whose gap exceeds that of the structure beyond a linear model, the logger and the noise
    rig_sensor    the same with an effect of the sensor: an oscillation, a level that drifts, coarse steps

`DIVISIONS` consecutive seeds are one rig and one set of repeats, divided differently into fit and check records: the verdict should be the same.
"""

import zlib
from dataclasses import dataclass

import numpy as np

from . import linear_fit, motions, recorder, rig_effects, rigs
from .bundle import Bundle, model_text

DIVISIONS = 3
RATES_HZ = (50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
SAMPLES_PER_BANDWIDTH = 12.0  # at least, so that the command is not a staircase in the band
LONGEST_S, MOST_ROWS, CYCLES = 25.0, 16000, 60.0
NOISE_SHARE = (0.001, 0.02)  # of the rms of the motion
MODEL_OFF = 0.30
GAIN_IS_BETTER_KNOWN = np.array([0.3, 1.0, 1.0, 1.0])  # relative to that, for k, p, omega and zeta
MODEL_SHARES = (0.4, 0.35, 0.25)  # fitted to a healthy repeat, in error, fitted to a repeat with the effect
DOMINANCE = (1.5, 8.0)  # gap of the effect over the residual due to structure, logger and noise together, in rms
LEAST_DOMINANCE = 1.0  # minimum for every effect
ROUNDING = np.sqrt(12.0)  # step over rms of the rounding
SEARCH_STEPS = 10
NEAR_ENOUGH = 1.15
# Divisions of the five repeats; the model is fitted to the sixth.
ROLES = (((0, 1), (2, 3)), ((2, 1), (0, 4)), ((3, 4, 0), (1,)))
REPEATS = 6
EFFECTS = {"rig_effect": (rig_effects.NAMES, rig_effects.draw), "rig_sensor": (rig_effects.SENSOR_NAMES, rig_effects.draw_of_sensor)}
FITTED = 2  # of these, those that set the strength of an effect


@dataclass
class Repeat:
    """One session's command, before any effect, and the resulting motion."""

    motion: str
    time: np.ndarray
    command: np.ndarray
    day: rigs.Session
    unit_noise: np.ndarray


def draw(seed, kind):
    rng = np.random.default_rng([seed // DIVISIONS, zlib.crc32(kind.encode())])
    number = seed // DIVISIONS
    name = list(rigs.RIGS)[number % len(rigs.RIGS)]
    drawn = rigs.draw(rng, name)
    rate = draw_rate(rng, drawn)
    repeats, colour = draw_repeats(rng, drawn, rate)
    order = int(rng.choice([2, 3]))
    healthy = [simulate(drawn, repeat, rate) for repeat in repeats]
    noise_rms = float(np.exp(rng.uniform(*np.log(NOISE_SHARE)))) * rms(healthy[0])
    log = recorder.draw(rng, name)


    def fitted_to(position):
        last = repeats[-1]
        return linear_fit.fit(last.time, last.command, position + noise_rms * last.unit_noise, order, drawn.bandwidth_hz)[0]

    model = fitted = fitted_to(healthy[-1])
    model_from = str(rng.choice(["repeat", "off", "effect" if kind == "rig_effect" else "repeat"], p=MODEL_SHARES))
    if model_from == "off":
        factors = 1.0 + rng.uniform(-MODEL_OFF, MODEL_OFF, 4) * GAIN_IS_BETTER_KNOWN
        model = tuple(float(value * factor) for value, factor in zip(model, factors))

    effect, values, dominance = None, {}, 0.0
    if kind in EFFECTS:
        effect, values, dominance = dominant(rng, kind, drawn, repeats, healthy, rate, noise_rms, order, number, fitted, log)
    positions = [simulate(drawn, repeat, rate, effect, values) for repeat in repeats] if effect else healthy
    if model_from == "effect":
        model = fitted_to(positions[-1])
    structure = structural_share(drawn, repeats[:2], healthy[:2], order, fitted)

    fit, check = ROLES[seed % DIVISIONS]
    files = {}
    for index in dict.fromkeys(fit + check):
        fine = fine_motion(drawn, repeats[index], rate, effect, values)
        step = max(drawn.plant.encoder_step, values.get("step", 0.0))
        files[f"{repeats[index].motion}_{index}.csv"] = recorder.record(row_rng(number, index), log, repeats[index], fine, noise_rms, rate, step)
    names = {index: f"{repeats[index].motion}_{index}.csv" for index in fit + check}
    truth = {
        "seed": seed, "kind": kind, "rig": name, "number": number, "division": seed % DIVISIONS, "truth": [effect.name] if effect else [],
        "effects": {effect.name: values} if effect else {}, "strength_scored": bool(effect and effect.scored),
        "unseen": unreached(effect, values, repeats, positions, fit),
        "inherent": list(drawn.inherent), "bandwidth_hz": drawn.bandwidth_hz, "rate_hz": rate, "order": order, "model": list(model),
        "model_from": model_from, "model_is_off": True, "noise": colour,
        "noise_rms": float(np.hypot(noise_rms, drawn.plant.encoder_step / ROUNDING)), "structure_share": structure,
        "dominance": dominance, "enr": dominance, "enr_of": {effect.name: dominance} if effect else {}, "enr_check": dominance,
        "motions": [repeat.motion for repeat in repeats], "logger": log.name, "base": dict(zip(("k", "p", "omega", "zeta"), model)),
        "load_recorded": False, "plant": {key: float(value) for key, value in drawn.plant._asdict().items()},
    }  # fmt: skip
    return Bundle(files, [names[i] for i in fit], [names[i] for i in check], model_text(model, order), truth)


def draw_rate(rng, drawn):
    allowed = [rate for rate in RATES_HZ if rate >= SAMPLES_PER_BANDWIDTH * drawn.bandwidth_hz]
    return float(rng.choice(allowed))


def draw_repeats(rng, drawn, rate):
    """About three motions, each once or more; amplitude changes from repeat to repeat by up to a third."""
    duration = min(LONGEST_S, MOST_ROWS / rate, max(8.0, CYCLES / drawn.bandwidth_hz))
    time = np.arange(int(duration * rate)) / rate
    chosen = [str(name) for name in rng.choice(list(motions.MOTIONS), 3, replace=False)]
    colour = motions.draw_colour(rng)
    repeats = []
    for index in range(REPEATS):
        motion = chosen[index % len(chosen)]
        size = drawn.amplitude_deg * rng.uniform(0.75, 1.0)
        command = np.round(size * motions.command(rng, motion, time, drawn.highest_hz), 6)
        repeats.append(Repeat(motion, time, command, rigs.session(rng, drawn), motions.noise(rng, colour, len(time))))
    return repeats, colour


def fine_motion(drawn, repeat, rate, effect=None, values=None):
    """Step, and the sensor's value at the ends of the steps, before noise and rounding."""
    h = rigs.fine_step(rate)
    reference = np.repeat(repeat.command, int(round(1.0 / (rate * h))))
    reference = rig_effects.in_reference("delay", {"time": repeat.day.latency_s}, reference, h)
    plant = rigs.on_the_day(drawn.plant, repeat.day)
    if effect:
        reference, plant = rig_effects.in_reference(effect.name, values, reference, h), rig_effects.in_rig(effect.name, values, plant)
    position, _ = rigs.move(drawn, plant, reference, h)
    if effect:
        position = rig_effects.at_output(effect.name, values, position)
    measured = repeat.day.scale * position + repeat.day.offset_deg
    if effect:
        phase = 1e3 * float(repeat.unit_noise[0])
        measured = rig_effects.at_sensor(effect.name, values, measured, h * np.arange(1, len(measured) + 1), phase)
    return h, measured


def simulate(drawn, repeat, rate, effect=None, values=None):
    """The sensor's value at the samples: at the beginning of each held command."""
    h, position = fine_motion(drawn, repeat, rate, effect, values)
    per_sample = int(round(1.0 / (rate * h)))
    sampled = np.concatenate([position[:1], position[per_sample - 1 :: per_sample][: len(repeat.time) - 1]])
    return values["step"] * np.round(sampled / values["step"]) if effect and "step" in values else sampled


def structural_share(drawn, repeats, positions, order, start):
    """Residual of a linear model on the healthy motion, relative to the motion, both rms."""
    gaps = [linear_fit.fit(r.time, r.command, y, order, drawn.bandwidth_hz, start)[1] for r, y in zip(repeats, positions)]
    return rms(np.concatenate(gaps)) / rms(np.concatenate(positions))


def dominant(rng, kind, drawn, repeats, healthy, rate, noise_rms, order, number, start, log):
    """An effect that suits the rig, at the severity for a random dominance, by bisection in the logarithm of the severity. One that a rig
    hides at any severity, as an integrator does a dead zone, is replaced by the next."""
    first = number // len(rigs.RIGS)
    logged = [evenly_logged(number, i, log, drawn, repeats[i], healthy[i], rate) for i in range(FITTED)]
    left = [linear_fit.fit(repeats[i].time, *columns, order, drawn.bandwidth_hz, start)[1] for i, columns in enumerate(logged)]
    else_left = np.hypot(rms(np.concatenate(left)), noise_rms)
    names, draw_one = EFFECTS[kind]
    for place in range(len(names)):
        name = names[(first + place) % len(names)]
        if drawn.name == "hydraulic" and name == "acceleration_limit":
            name = "rate_limit"  # a valve has no torque to saturate
        found = as_strong_as_drawn(draw_one(rng, name, drawn), rng, drawn, repeats, healthy, rate, else_left, order, start)
        if found[2] >= LEAST_DOMINANCE:
            break
    return found


def as_strong_as_drawn(effect, rng, drawn, repeats, healthy, rate, else_left, order, start):
    """The effect, its values and its dominance, where that is closest to a random one."""
    fitted = range(FITTED)
    linear = [linear_fit.fit(repeats[i].time, repeats[i].command, healthy[i], order, drawn.bandwidth_hz, start)[1] for i in fitted]
    wanted = float(np.exp(rng.uniform(*np.log(DOMINANCE))))

    def dominance(severity):
        values = effect.parameters(severity)
        gaps = []
        for i in fitted:
            moved = simulate(drawn, repeats[i], rate, effect, values)
            gaps.append(linear_fit.fit(repeats[i].time, repeats[i].command, moved, order, drawn.bandwidth_hz, start)[1])
        return np.sqrt(max(rms(np.concatenate(gaps)) ** 2 - rms(np.concatenate(linear)) ** 2, 0.0)) / else_left

    low, high = np.log(effect.least), np.log(effect.most)
    tried = []
    for _ in range(SEARCH_STEPS):
        middle = 0.5 * (low + high)
        found = dominance(float(np.exp(middle)))
        tried.append((abs(np.log(max(found, 1e-6) / wanted)), middle, found))
        if tried[-1][0] < np.log(NEAR_ENOUGH):
            break
        low, high = (middle, high) if found < wanted else (low, middle)
    _, best, found = min(tried)
    return effect, {key: float(value) for key, value in effect.parameters(float(np.exp(best))).items()}, float(found)


def evenly_logged(number, index, log, drawn, repeat, position, rate):
    """Command and position as recorded, without noise, on a uniform clock: lost or displaced rows are interpolated from their neighbours."""
    if log.name == "synchronous":
        return repeat.command, position
    rows = recorder.record(row_rng(number, index), log, repeat, fine_motion(drawn, repeat, rate), 0.0, rate)
    return tuple(np.interp(repeat.time, rows["time"], rows[column]) for column in ("command", "position"))


def row_rng(number, index):
    return np.random.default_rng([number, index, zlib.crc32(b"recorder")])


def unreached(effect, values, repeats, positions, fit):
    """Sides of a limit that no fit record reaches: the data do not determine their value."""
    if effect is None or effect.name not in ("position_limit", "command_limit"):
        return []
    waves = [positions[i] if effect.name == "position_limit" else repeats[i].command for i in fit]
    lowest, highest = min(w.min() for w in waves), max(w.max() for w in waves)
    met = {"min": lowest <= 0.99 * values["min"], "max": highest >= 0.99 * values["max"]}
    return [f"{effect.name}.{side}" for side in ("min", "max") if not met[side]]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
