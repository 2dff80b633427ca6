"""Visibility of an effect: its ENR, and the strength that gives the wanted ENR.

ENR, the effect-to-noise ratio: rms of the gap on the fit records after a refit of the base, over that of the noise.
"""

import numpy as np

from . import linear_base, plant
from .linear_base import rms

TWO_SIDED = ("command_limit", "command_rate_limit", "rate_limit", "position_limit")
LEAST_ENR_OF_A_SIDE = 0.1
NEAR_ENOUGH = 1.3  # the wanted ENR is met within this factor
TRIES = 9


def severe_enough(case, name, family, wanted):
    """The parameters whose ENR is the wanted one, or the closest that the family reaches, and their ENR.

    Secants in logarithms (a limit's gap grows with a high power of its severity), within a bracket.
    """
    least, most, target = np.log(family.least), np.log(family.most), np.log(wanted)
    at, power = 0.5 * (least + most), 1.0
    tried = []  # (distance to the target, severity, ENR), logarithms except the last
    for _ in range(TRIES):
        found = enr(case, name, family.parameters(float(np.exp(at))), family.seen_before_refit)
        distance = np.log(max(found, 1e-3)) - target
        if tried and at != tried[-1][1]:
            power = np.clip((distance - tried[-1][0]) / (at - tried[-1][1]), 0.5, 20.0)
        tried.append((distance, at, found))
        if abs(distance) < np.log(NEAR_ENOUGH) or most - least < 0.05:
            break
        least, most = (at, most) if distance < 0.0 else (least, at)
        at -= distance / power
        if not least < at < most:
            at = 0.5 * (least + most)
    _, at, found = min(tried, key=lambda each: abs(each[0]))
    return family.parameters(float(np.exp(at))), found


def enr(case, name, parameters, before_refit):
    base, effects = (shifted(case.base, parameters), {}) if name == "parameter_shift" else (case.base, {name: parameters})
    fitted = case.records[:2]
    positions = [behind_noise(case, record, base, effects) for record in fitted]
    rows = [(record.command, record.load, position) for record, position in zip(fitted, positions)]
    if before_refit:
        gaps = [position - linear_base.respond(case.base, case.order, command, load, case.sample_time_s, case.hold) for command, load, position in rows]
    else:
        _, gaps = linear_base.refit(case.base, case.order, rows, case.sample_time_s, case.hold)
    return rms(np.concatenate(gaps)) / case.noise_rms


def enr_of_check(case):
    """Residual on the check record of the base refitted to the other two records."""
    rows = [(r.command, r.load, behind_noise(case, r, case.base, case.effects)) for r in case.records]
    base = case.model if case.gap_is_before_refit else linear_base.refit(case.base, case.order, rows[:2], case.sample_time_s, case.hold)[0]
    command, load, position = rows[2]
    return rms(position - linear_base.respond(base, case.order, command, load, case.sample_time_s, case.hold)) / case.noise_rms


def enr_beside(case, name):
    """The contribution of one of two effects in the presence of the other, less the part that the base explains."""
    fitted = case.records[:2]
    others = {other: values for other, values in case.effects.items() if other != name}
    differences = [behind_noise(case, r, case.base, case.effects) - behind_noise(case, r, case.base, others) for r in fitted]
    rows = [(record.command, record.load, None) for record in fitted]
    return rms(linear_base.without_base(case.base, case.order, rows, differences, case.sample_time_s, case.hold)) / case.noise_rms


def unreached(case):
    """Sides of two-sided effects that contribute less than `LEAST_ENR_OF_A_SIDE` of the noise: the data do not determine their value."""
    unseen = []
    for name in case.effects.keys() & set(TWO_SIDED):
        for parameter in case.effects[name]:
            one_sided = {key: value for key, value in case.effects[name].items() if key != parameter}
            less = case.effects | {name: one_sided}
            gaps = [record.clean - move(case, record, case.base, less) for record in case.records[:2]]
            if rms(np.concatenate(gaps)) < LEAST_ENR_OF_A_SIDE * case.noise_rms:
                unseen.append(f"{name}.{parameter}")
    return unseen


def behind_noise(case, record, base, effects):
    """The rounded sum of position and noise, less the noise."""
    noise = case.noise_rms * record.unit_noise
    return rounded(move(case, record, base, effects) + noise, effects) - noise


def move(case, record, base, effects):
    load, hidden = record.load, dict(effects)
    turbulence = hidden.pop("turbulence", None)
    if turbulence:
        load = turbulence["rms"] * record.turbulence + (0.0 if load is None else load)
    if "chatter" in hidden:
        hidden["chatter"] = hidden["chatter"] | {"phase": hidden["chatter"]["phase"] + record.chatter_phase}
    return plant.simulate(base, hidden, record.time, record.command, load, case.order, case.hold)


def rounded(position, effects):
    """An encoder rounds position plus noise."""
    step = effects.get("quantisation", {}).get("step", 0.0)
    return np.round(position / step) * step if step else position


def measure(case):
    for record in case.records:
        record.clean = move(case, record, case.base, case.effects)
        record.position = rounded(record.clean + case.noise_rms * record.unit_noise, case.effects)


def shifted(base, factors):
    return (base[0] * factors["k"], base[1], base[2] * factors["omega"], base[3] * factors["zeta"])
