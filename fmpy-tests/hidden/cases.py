"""One seed, one case: a plant with hidden effects, three records of it, and the given model.

    single   one effect, its ENR (gap after a refit of the base / noise) between 0.3 and 10
    clean    none; half of them with coloured noise, a third with a model in error by some per cent
    outside  an effect that the library does not contain
    pair     two effects of different families, each visible beside the other

Names cycle with the seed, everything else is drawn from it.
"""

import zlib
from dataclasses import dataclass, field

import numpy as np

import bact

from . import excitation, linear_base
from .linear_base import rms
from .strengths import FAMILIES, OUTSIDE_FAMILIES, Situation
from .visibility import enr_beside, enr_of_check, measure, severe_enough, shifted, unreached

KINDS = ("single", "clean", "outside", "pair")
FAMILY_OF = {name: family for family, names in {
    "play": ("backlash", "dead_zone", "coulomb_friction", "command_backlash", "command_dead_zone"),
    "limit": ("rate_limit", "acceleration_limit", "position_limit", "command_limit", "command_rate_limit"),
    "lag": ("delay", "sensor_lag", "parameter_shift", "structural_mode"),
    "gain": ("amplitude_gain", "asymmetric_gain", "gain_drift", "hinge_load"),
    "sensor": ("sensor_bias", "quantisation", "chatter"),
}.items() for name in names}  # fmt: skip

DURATIONS_S, DURATION_SHARES = (25.0, 15.0, 40.0), (0.7, 0.15, 0.15)
AMPLITUDE_DEG = (1.0, 8.0)
NOISE_SHARE = (0.005, 0.03)  # of the rms of the sweep's position
TURBULENCE_HZ = (0.5, 8.0)
LOAD_RMS_DEG = (0.3, 1.5)
OFF = 0.05  # largest relative error in k, omega and zeta of models in error
LEAST_ENR, MOST_ENR = 0.3, 10.0
LEAST_ENR_OUTSIDE, LEAST_ENR_IN_PAIR = 1.0, 1.0
PAIR_TRIES = 40


@dataclass
class Record:
    name: str
    time: np.ndarray
    command: np.ndarray
    load: np.ndarray | None  # recorded
    turbulence: np.ndarray  # not recorded, rms 1
    unit_noise: np.ndarray
    chatter_phase: float  # added to that of the effect: in half of the cases the phase of chatter is independent of the start of a record
    clean: np.ndarray = None  # without noise and rounding
    position: np.ndarray = None  # as measured


@dataclass
class Case:
    seed: int
    kind: str
    set_name: str
    order: int
    base: tuple  # of the plant
    model: tuple  # the given model
    effects: dict  # parameters that are not neutral; without parameter_shift, which is the difference of `base` and `model`
    noise: dict
    noise_rms: float
    records: list
    check: str  # kind of the check record's command
    enr: float = 0.0
    enr_of: dict = field(default_factory=dict)  # of each effect, in a pair in the presence of the other
    enr_check: float = 0.0  # on the check record, which may hardly show an effect: slow triangles never reach a rate limit
    gap_is_before_refit: bool = False  # a refit would leave no gap: the ENR is that of the gap of the given model
    unseen: list = field(default_factory=list)  # "effect.parameter" of limits that the fitted records do not reach
    sample_time_s: float = excitation.SAMPLE_TIME_S
    hold: bool = True  # the plant's command is held between samples; otherwise straight lines

    @property
    def truth(self):
        """Names of what is hidden."""
        return list(self.enr_of)

    @property
    def model_is_off(self):
        return self.base != self.model


def draw(seed, kind):
    """The case of this seed and kind."""
    assert kind in KINDS, f"{kind} is drawn elsewhere: kinds.py"
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    case, situation = _without_effects(rng, seed, kind)
    if kind == "single":
        add_one(case, situation, rng, list(FAMILIES)[seed % len(FAMILIES)], FAMILIES, LEAST_ENR)
    elif kind == "outside":
        add_one(case, situation, rng, list(OUTSIDE_FAMILIES)[seed % len(OUTSIDE_FAMILIES)], OUTSIDE_FAMILIES, LEAST_ENR_OUTSIDE)
    elif kind == "pair":
        _add_two(case, situation, rng)
    measure(case)
    case.unseen = unreached(case)
    case.enr_check = enr_of_check(case)
    return case


def _without_effects(rng, seed, kind):
    chosen = bact.SETS[rng.integers(len(bact.SETS))]
    base = (chosen.k, chosen.p, chosen.omega, chosen.zeta)
    order = 2 if rng.random() < 0.2 else 3
    off = rng.random() < (0.33 if kind == "clean" else 0.5)
    factors = 1.0 + rng.uniform(-OFF, OFF, 3) if off else np.ones(3)
    model = (base[0] * factors[0], base[1], base[2] * factors[1], base[3] * factors[2])

    amplitude = float(np.exp(rng.uniform(*np.log(AMPLITUDE_DEG))))
    duration = float(rng.choice(DURATIONS_S, p=DURATION_SHARES))
    quiet = rng.random() < 0.3
    noise = excitation.draw_noise_kind(rng, coloured=rng.random() < 0.5)
    time = excitation.time(duration)
    chatter_is_free = rng.random() < 0.5
    check = str(rng.choice(excitation.CHECKS))
    records = []
    for name, wave, size in (("sweep", "sweep", 1.0), ("random", "random", 0.5), ("check", check, float(rng.uniform(0.5, 1.0)))):
        command = excitation.command(rng, wave, time, amplitude * size, quiet)
        turbulence = excitation.band_limited(rng, len(time), *TURBULENCE_HZ)
        phase = float(rng.uniform(-np.pi, np.pi)) if chatter_is_free else 0.0
        records.append(Record(name, time, command, None, turbulence, excitation.noise(rng, noise, len(time)), phase))
    positions = [linear_base.respond(base, order, record.command) for record in records]
    noise_rms = float(rng.uniform(*NOISE_SHARE)) * rms(positions[0])
    case = Case(seed, kind, chosen.name, order, base, model, {}, noise, noise_rms, records, check)
    situation = Situation(amplitude, float(np.abs(np.concatenate(positions)).max()), base[2], duration)
    return case, situation


def add_one(case, situation, rng, name, families, least):
    family = families[name](rng, situation)
    wanted = float(np.exp(rng.uniform(np.log(least), np.log(MOST_ENR))))
    if family.needs_load:
        add_load(case, rng)
    case.effects[name], case.enr = severe_enough(case, name, family, wanted)
    case.enr_of[name] = case.enr
    case.gap_is_before_refit = family.seen_before_refit
    if name == "parameter_shift":
        # the tabulated set is the given model; the plant is shifted from it
        shift = case.effects.pop("parameter_shift")
        case.model, case.base = case.base, shifted(case.base, shift)
    elif family.seen_before_refit:
        case.model = case.base


def add_load(case, rng):
    size = float(rng.uniform(*LOAD_RMS_DEG))
    for record in case.records:
        record.load = np.round(size * excitation.hinge_load(rng, record.time), excitation.COMMAND_DIGITS)


def _add_two(case, situation, rng):
    """Two of different families; redrawn until each is visible in the presence of the other."""
    names = [name for name in FAMILIES if name != "parameter_shift"]
    for _ in range(PAIR_TRIES):
        case.effects.clear()
        for record in case.records:
            record.load = None
        first = names[case.seed % len(names)]
        second = str(rng.choice([name for name in names if FAMILY_OF[name] != FAMILY_OF[first]]))
        families = {name: FAMILIES[name](rng, situation) for name in (first, second)}
        unseen = any(family.seen_before_refit for family in families.values())
        same = {first, second} == {"hinge_load", "sensor_bias"}  # both kinds of bias are equivalent
        if unseen or same:
            continue
        if any(family.needs_load for family in families.values()):
            add_load(case, rng)
        for name, family in families.items():
            wanted = float(np.exp(rng.uniform(np.log(2.0), np.log(MOST_ENR))))
            others = dict(case.effects)
            case.effects.clear()
            strength, _ = severe_enough(case, name, family, wanted)
            case.effects.update(others | {name: strength})
        case.enr_of = {name: enr_beside(case, name) for name in (first, second)}
        case.enr = min(case.enr_of.values())
        if case.enr >= LEAST_ENR_IN_PAIR:
            case.effects = {name: case.effects[name] for name in FAMILIES if name in case.effects}
            return
    raise RuntimeError(f"seed {case.seed}: no two effects are visible beside each other in {PAIR_TRIES} tries")
