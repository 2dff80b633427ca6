"""The product's family of plants, drawn more widely than in `cases.py`: other possible actuators of users.

    wide          one effect with an ENR from 0.02 on               wide_clean    none
    wide_pair     two effects of the same family                    triple        three of different families
    check_only    a limit or a play that only the check record reaches
    wide_outside  no effect of the library: distributed play, Bouc-Wen, omega that drifts, turbulence, a sensor without sign

Pole, order, hold, sampling rate and excitation vary; a few linear commands are declared held, or the reverse. The given model is in error by up
to 30 %, or fitted to the records themselves. For `files.truth` these are `Case`s, at another rate.
"""

import zlib

import numpy as np

from . import linear_base, linear_fit, motions
from .bundle import Bundle, model_text
from .cases import FAMILY_OF, Case, Record, add_load, add_one
from .files import columns, truth
from .linear_base import rms
from .strengths import FAMILIES, OUTSIDE_FAMILIES, Situation
from .visibility import enr_beside, enr_of_check, measure, severe_enough, unreached

KINDS = ("wide", "wide_clean", "wide_pair", "triple", "check_only", "wide_outside")
OMEGA, ZETA, POLE = (30.0, 250.0), (0.35, 0.95), (60.0, 10_000.0)  # rad/s, 1, 1/s
GAIN = (0.8, 1.25)
RATES_HZ = (50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
SAMPLES_PER_OMEGA = 2.0  # minimum rate over omega
FAST_RATE_HZ = 200.0  # minimum for effects with their own frequency
LONGEST_S, MOST_ROWS = 25.0, 16000
BAND = (0.6, 1.6)  # highest frequency of the excitation over omega/2pi
HIGHEST_HZ = 14.0
AMPLITUDE_DEG, NOISE_SHARE = (1.0, 12.0), (0.002, 0.03)
LEAST_ENR, LEAST_ENR_OUTSIDE = 0.02, 0.5
LEAST_ENR_OF_EACH = 1.0  # in the presence of the others
WRONGLY_DECLARED = 0.1  # share of cases
OFF = 0.30
TRIES, TRIES_OF_A_NAME = 40, 8
NAMES = tuple(name for name in FAMILIES if name != "parameter_shift")
QUIETER, LOUDER = 0.4, 1.0  # peak of fit and of check records where only the latter reach a limit
REACHED_BY, ABOVE_FITTED = 2.0, (1.1, 1.4)
# Limits that small motions do not reach at all, so that only a larger check record shows them.
UNREACHED = ("position_limit", "command_limit", "rate_limit", "command_rate_limit", "acceleration_limit")
SMOOTH = ("sweep", "multisine", "sin_sin", "sin_time_square", "noise_band")
SAME_PHYSICS = ({"hinge_load", "sensor_bias"}, {"delay", "sensor_lag"}, {"command_dead_zone", "command_backlash"})


def draw(seed, kind):
    case, rng, situation = without_effects(seed, kind, RATES_HZ)
    if kind == "wide":
        add_one(case, situation, rng, list(FAMILIES)[seed % len(FAMILIES)], FAMILIES, LEAST_ENR)
    elif kind == "wide_pair":
        add_several(case, situation, rng, of_one_family)
    elif kind == "triple":
        add_several(case, situation, rng, of_three_families)
    elif kind == "check_only":
        add_to_check(case, rng)
    elif kind == "wide_outside":
        add_outside(case, situation, rng)
    finish(case)
    return bundle(case, rng)


def without_effects(seed, kind, rates):
    """A plant of the family and its three records, not yet simulated."""
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    omega = logarithmic(rng, OMEGA)
    base = (float(rng.uniform(*GAIN)), logarithmic(rng, POLE), omega, float(rng.uniform(*ZETA)))
    order = int(rng.choice([2, 3]))
    least = max(SAMPLES_PER_OMEGA * omega, FAST_RATE_HZ if needs_speed(seed, kind) else 0.0)
    allowed = [rate for rate in rates if rate >= least] or [max(rates)]
    rate = float(rng.choice(allowed))
    highest = min(HIGHEST_HZ, float(rng.uniform(*BAND)) * omega / (2.0 * np.pi))
    duration = min(LONGEST_S, MOST_ROWS / rate)
    time = np.arange(int(duration * rate)) / rate
    amplitude = logarithmic(rng, AMPLITUDE_DEG)
    colour = motions.draw_colour(rng)
    chosen = rng.choice(list(motions.MOTIONS), 3, replace=False)
    if kind == "check_only":  # the same motion, larger; ramps and sines, since any rate limit is visible in a jump
        chosen = np.array(SMOOTH)[rng.permutation(len(SMOOTH))[[0, 1, 0]]]
    sizes = (QUIETER, QUIETER, LOUDER) if kind == "check_only" else (1.0, float(rng.uniform(0.4, 0.9)), float(rng.uniform(0.5, 1.0)))
    hold = bool(rng.random() < 0.7)
    records = []
    for role, motion, size in zip(("sweep", "random", "check"), chosen, sizes):
        command = np.round(amplitude * size * motions.command(rng, str(motion), time, highest), 6)
        turbulence = motions.band_limited(rng, len(time), 0.5, min(8.0, 0.2 * rate), rate)
        records.append(Record(role, time, command, None, turbulence, motions.noise(rng, colour, len(time)), float(rng.uniform(-np.pi, np.pi))))
    positions = [linear_base.respond(base, order, record.command, None, 1.0 / rate, hold) for record in records]
    noise_rms = float(rng.uniform(*NOISE_SHARE)) * rms(positions[0])
    case = Case(seed, kind, "+".join(map(str, chosen)), order, base, base, {}, colour, noise_rms, records, str(chosen[2]), sample_time_s=1.0 / rate, hold=hold)
    peak = float(np.abs(np.concatenate(positions)).max())
    return case, rng, Situation(float(np.abs(records[0].command).max()), peak, omega, duration, highest)


def needs_speed(seed, kind):
    """Whether the case may contain modes or chatter of up to 40 Hz, which 50 samples/s do not resolve."""
    return kind in ("wide_pair", "triple") or kind == "wide" and list(FAMILIES)[seed % len(FAMILIES)] in ("structural_mode", "chatter")


def of_one_family(rng, first):
    return [first, str(rng.choice([name for name in NAMES if FAMILY_OF[name] == FAMILY_OF[first] and name != first]))]


def of_three_families(rng, first):
    chosen = [first]
    for _ in range(2):
        taken = {FAMILY_OF[name] for name in chosen}
        chosen.append(str(rng.choice([name for name in NAMES if FAMILY_OF[name] not in taken])))
    return chosen


def add_several(case, situation, rng, choose):
    """Redrawn until each effect is visible in the presence of the others; the first cycles with the seed as long as that succeeds."""
    for attempt in range(TRIES):
        chosen = choose(rng, NAMES[(case.seed + attempt // TRIES_OF_A_NAME) % len(NAMES)])
        if not any(same <= set(chosen) for same in SAME_PHYSICS) and add_all(case, situation, rng, chosen):
            return
    raise RuntimeError(f"seed {case.seed}: no effects are visible beside each other in {TRIES} tries")


def add_all(case, situation, rng, names):
    """Whether each of the given effects, added one by one, is visible in the presence of the others."""
    for record in case.records:
        record.load = None
    families = {name: FAMILIES[name](rng, situation) for name in names}
    if any(family.seen_before_refit for family in families.values()):
        return False
    if any(family.needs_load for family in families.values()):
        add_load(case, rng)
    strengths = {}
    for name, family in families.items():
        wanted = float(np.exp(rng.uniform(np.log(2.0), np.log(8.0))))
        case.effects.clear()
        strengths[name], _ = severe_enough(case, name, family, wanted)
    case.effects.clear()
    case.effects.update({name: strengths[name] for name in FAMILIES if name in strengths})
    case.enr_of = {name: enr_beside(case, name) for name in names}
    case.enr = min(case.enr_of.values())
    return case.enr >= LEAST_ENR_OF_EACH


def add_to_check(case, rng):
    """A limit above the demand of the fit records; the check record demands at least `REACHED_BY` times as much."""
    name = UNREACHED[case.seed % len(UNREACHED)]
    *fitted, check = case.records
    asked = max(asked_for(case, name, record) for record in fitted)
    check.command = np.round(check.command * max(1.0, REACHED_BY * asked / asked_for(case, name, check)), 6)
    limit = float(rng.uniform(*ABOVE_FITTED)) * asked
    case.effects[name] = {
        "rate_limit": {"up": limit, "down": limit}, "command_rate_limit": {"up": limit, "down": limit}, "acceleration_limit": {"value": limit},
        "position_limit": {"min": -limit, "max": limit}, "command_limit": {"min": -limit, "max": limit},
    }[name]  # fmt: skip
    case.enr_of = {name: 0.0}


def asked_for(case, name, record):
    """The largest value, in a record without effects, of the limited quantity."""
    k, _, omega, _ = case.base
    position = linear_base.respond(case.base, case.order, record.command, None, case.sample_time_s, case.hold)
    limited = {"rate_limit": np.diff(position) / case.sample_time_s, "command_rate_limit": np.diff(record.command) / case.sample_time_s,
               "acceleration_limit": omega**2 * (k * record.command - position), "position_limit": position, "command_limit": record.command}  # fmt: skip
    return float(np.abs(limited[name]).max())


def add_outside(case, situation, rng):
    names = (*OUTSIDE_FAMILIES, "unsigned_sensor")
    name = names[case.seed % len(names)]
    if name == "unsigned_sensor":
        case.enr_of, case.enr = {name: float("inf")}, float("inf")
        case.effects[name] = {}
        return
    add_one(case, situation, rng, name, OUTSIDE_FAMILIES, LEAST_ENR_OUTSIDE)


def finish(case):
    unsigned = case.effects.pop("unsigned_sensor", None)
    measure(case)
    case.unseen = unreached(case)
    case.enr_check = enr_of_check(case)
    if unsigned is not None:
        for record in case.records:
            record.position = np.abs(record.position)
        rows = [(record.command, None, record.position) for record in case.records[:2]]
        _, gaps = linear_base.refit(case.base, case.order, rows, case.sample_time_s, case.hold)
        case.enr = rms(np.concatenate(gaps)) / case.noise_rms
        case.enr_of = {"unsigned_sensor": case.enr}


def bundle(case, rng, columns_of=None):
    """Files, with a model that is right, in error by up to 30 %, or fitted to the first record; and the declared hold."""
    files = {f"{record.name}.csv": (columns_of or columns)(record) for record in case.records}
    source = str(rng.choice(["right", "off", "fitted"], p=[0.2, 0.4, 0.4]))
    if case.gap_is_before_refit:
        source = "right"  # the given model is part of the hidden difference
    if source == "off":
        factors = 1.0 + rng.uniform(-OFF, OFF, 4) * [0.3, 1.0, 1.0, 1.0]
        case.model = tuple(float(value * factor) for value, factor in zip(case.base, factors))
    elif source == "fitted":
        first = case.records[0]
        case.model, _ = linear_fit.fit(first.time, first.command, first.position, case.order, case.base[2] / (2.0 * np.pi))
    declared_hold = case.hold if rng.random() >= WRONGLY_DECLARED else not case.hold
    told = truth(case) | {"rate_hz": 1.0 / case.sample_time_s, "hold": case.hold, "declared_hold": declared_hold, "model_from": source}
    return Bundle(files, ["sweep.csv", "random.csv"], ["check.csv"], model_text(case.model, case.order), told, [] if declared_hold else ["--linear"])


def logarithmic(rng, limits):
    return float(np.exp(rng.uniform(*np.log(limits))))
