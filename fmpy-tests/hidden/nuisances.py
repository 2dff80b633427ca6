"""Disturbances of a record: lost rows, clock jitter, spikes, hum. With an effect in every other round, without in the others.

    dropped_rows      10 % of the rows                      gaps               five, of 0.1 to 0.5 s
    written_jitter    samples at uneven, recorded instants  unwritten_jitter   the same up to 10 % of a sample, recorded as even
    spikes            0.1 % of the samples, 30 times noise  level_step         the sensor slips once
    hum               50 Hz, or its alias                   start_in_motion    the record begins in mid-motion
    slow_rate         50 samples/s                          fast_rate          2000 samples/s
"""

import numpy as np

from . import plant, wide
from .strengths import FAMILIES

DROPPED_SHARE, SPIKE_SHARE, SPIKE_SIZE = 0.10, 0.001, 30.0
GAPS, GAP_S = 5, (0.1, 0.5)
WRITTEN_JITTER, UNWRITTEN_JITTER = 0.3, 0.10  # of a sampling period, at most
LEVEL_STEP = (5.0, 20.0)  # of the noise
HUM_HZ, HUM = 50.0, (0.5, 3.0)  # of the noise, rms
CUT_SHARE = (0.1, 0.3)  # of the record, before it begins
RATES_HZ = (100.0, 200.0, 500.0, 1000.0)
LEAST_ENR = 1.0
# Those whose meaning does not depend on when the record begins.
EFFECTS = ("backlash", "rate_limit", "position_limit", "coulomb_friction", "dead_zone", "delay", "acceleration_limit", "command_limit",
           "command_dead_zone", "command_backlash", "asymmetric_gain", "structural_mode", "amplitude_gain")  # fmt: skip


def columns(time, command, position):
    return {"time": time, "command": command, "position": position}


def as_it_is(rng, case, record):
    return columns(record.time, record.command, record.position)


def dropped_rows(rng, case, record):
    kept = rng.random(len(record.time)) >= DROPPED_SHARE
    kept[0] = True
    return columns(record.time[kept], record.command[kept], record.position[kept])


def gaps(rng, case, record):
    kept = np.ones(len(record.time), bool)
    for start in rng.uniform(0.05, 0.9, GAPS) * record.time[-1]:
        kept &= (record.time < start) | (record.time >= start + rng.uniform(*GAP_S))
    return columns(record.time[kept], record.command[kept], record.position[kept])


def jittered(rng, case, record, share):
    """Sampled at uneven instants, at which the command also changes."""
    uneven = record.time + share * case.sample_time_s * rng.uniform(-1.0, 1.0, len(record.time))
    uneven[0] = 0.0
    moved = plant.simulate(case.base, case.effects, uneven, record.command, None, case.order, case.hold)
    return uneven, moved + case.noise_rms * record.unit_noise


def written_jitter(rng, case, record):
    uneven, position = jittered(rng, case, record, WRITTEN_JITTER)
    return columns(uneven, record.command, position)


def unwritten_jitter(rng, case, record):
    _, position = jittered(rng, case, record, UNWRITTEN_JITTER)
    return columns(record.time, record.command, position)


def spikes(rng, case, record):
    count = max(1, round(SPIKE_SHARE * len(record.time)))
    position = record.position.copy()
    position[rng.choice(len(position), count, replace=False)] += SPIKE_SIZE * case.noise_rms * rng.choice([-1.0, 1.0], count)
    return columns(record.time, record.command, position)


def level_step(rng, case, record):
    slip = rng.uniform(*LEVEL_STEP) * case.noise_rms * rng.choice([-1.0, 1.0])
    return columns(record.time, record.command, record.position + slip * (record.time > rng.uniform(0.2, 0.8) * record.time[-1]))


def hum(rng, case, record):
    wave = np.sin(2.0 * np.pi * HUM_HZ * record.time + rng.uniform(-np.pi, np.pi))
    return columns(record.time, record.command, record.position + np.sqrt(2.0) * rng.uniform(*HUM) * case.noise_rms * wave)


def start_in_motion(rng, case, record):
    cut = int(rng.uniform(*CUT_SHARE) * len(record.time))
    return columns(record.time[cut:] - record.time[cut], record.command[cut:], record.position[cut:])


# Nuisance, and the sampling rates at which it is drawn.
NUISANCES = {
    "dropped_rows": (dropped_rows, RATES_HZ), "gaps": (gaps, RATES_HZ), "written_jitter": (written_jitter, RATES_HZ),
    "unwritten_jitter": (unwritten_jitter, RATES_HZ), "spikes": (spikes, RATES_HZ), "level_step": (level_step, RATES_HZ),
    "hum": (hum, RATES_HZ), "start_in_motion": (start_in_motion, RATES_HZ), "slow_rate": (as_it_is, (50.0,)), "fast_rate": (as_it_is, (2000.0,)),
}  # fmt: skip
INHERENT = {"hum": ["chatter"]}  # a hum is equivalent to chatter


def draw(seed, kind="nuisance"):
    """The nuisance cycles with the seed; rounds alternate between with and without an effect, and effects cycle with the rounds."""
    name = list(NUISANCES)[seed % len(NUISANCES)]
    spoil, rates = NUISANCES[name]
    case, rng, situation = wide.without_effects(seed, kind, rates)
    round_number = seed // len(NUISANCES)
    if round_number % 2 == 0:
        effect = EFFECTS[(round_number // 2 + seed % len(NUISANCES)) % len(EFFECTS)]
        wide.add_one(case, situation, rng, effect, FAMILIES, LEAST_ENR)
    wide.finish(case)
    bundle = wide.bundle(case, rng, lambda record: spoil(rng, case, record))
    bundle.truth |= {"nuisance": name, "inherent": INHERENT.get(name, [])}
    return bundle
