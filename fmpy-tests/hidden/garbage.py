"""Records without information about the actuator, or in the wrong unit: typical mistakes of users.

The product refuses them (exit 2) and states the cause, or names no effect; either within `TIME_LIMIT_S`. The fit records and the check
record have the same fault. `write(kind, seed, folder)` writes one kind; the underlying plant is a plain servo.
"""

import numpy as np

from . import linear_fit, motions
from .bundle import Bundle, model_text
from .bundle import write as write_bundle

TIME_LIMIT_S = 10.0
RATE_HZ, DURATION_S = 200.0, 20.0
BASE = (1.0, 5000.0, 80.0, 0.7)
HIGHEST_HZ = 8.0
AMPLITUDE_DEG = (1.0, 8.0)
NOISE_SHARE = (0.005, 0.03)
LATE_S = 2.0
FACTOR = 1e200
MOTIONS = ("sweep", "noise_band", "multisine")


def dead_surface(rng, time, command, position, other):
    return time, command, np.full_like(position, np.round(rng.uniform(-1.0, 1.0), 3))


def dead_with_noise(rng, time, command, position, other):
    return time, command, position.std() * rng.uniform(0.005, 0.05) * rng.standard_normal(len(time))


def reversed_column(rng, time, command, position, other):
    return time, command, position[::-1]


def white_against_white(rng, time, command, position, other):
    return time, rng.standard_normal(len(time)), rng.standard_normal(len(time))


def random_walk(rng, time, command, position, other):
    walk = np.cumsum(rng.standard_normal(len(time)))
    return time, command, walk * np.abs(position).max() / np.abs(walk).max()


def crossed(rng, time, command, position, other):
    return time, command, other


def two_seconds_late(rng, time, command, position, other):
    late = int(LATE_S * RATE_HZ)
    return time, command, np.r_[np.zeros(late), position[:-late]]


def milliseconds(rng, time, command, position, other):
    return 1e3 * time, command, position


def huge(rng, time, command, position, other):
    return time, FACTOR * command, FACTOR * position


def swapped(rng, time, command, position, other):
    return time, position, command


def degrees_against_radians(rng, time, command, position, other):
    return time, command, np.deg2rad(position)


def opposite_sign(rng, time, command, position, other):
    return time, command, -position


def unrelated(rng, time, command, position, other):
    """The position of a slower actuator on another day, unrelated to this command."""
    wandering = motions.command(rng, "noise_band", time, 0.2 * HIGHEST_HZ)
    return time, command, np.abs(position).max() * wandering + 0.01 * np.abs(position).max() * rng.standard_normal(len(time))


# A refusal contains at least one of these words, in upper or lower case.
KINDS = {
    "dead_surface": (dead_surface, ("does not move", "never moves", "constant", "not follow", "dead", "stuck")),
    "dead_with_noise": (dead_with_noise, ("not follow", "noise", "no relation", "dead", "not move")),
    "reversed_column": (reversed_column, ("not follow", "no relation", "reversed", "explain")),
    "white_against_white": (white_against_white, ("not follow", "no relation", "noise", "explain")),
    "random_walk": (random_walk, ("not follow", "no relation", "drift", "explain")),
    "crossed": (crossed, ("not follow", "no relation", "explain", "another record")),
    "two_seconds_late": (two_seconds_late, ("late", "lag", "delay", "not follow", "shift")),
    "milliseconds": (milliseconds, ("time", "unit", "millisecond", "ms")),
    "huge": (huge, ("overflow", "large", "range", "magnitude", "unit")),
    "swapped": (swapped, ("swap", "ahead", "precede", "before", "column", "lead")),
    "degrees_against_radians": (degrees_against_radians, ("unit", "rad", "gain", "scale")),
    "opposite_sign": (opposite_sign, ("sign", "opposite", "invert", "negative")),
    "unrelated": (unrelated, ("not follow", "no relation", "explain")),
}  # fmt: skip
TWELVE = tuple(name for name in KINDS if name != "unrelated")
PLAIN = (*TWELVE, "unrelated")


def draw(seed, kind="garbage"):
    """Names cycle with the seed."""
    return of_kind(PLAIN[seed % len(PLAIN)], seed)


def of_kind(name, seed):
    rng = np.random.default_rng([seed, list(KINDS).index(name)])
    spoil, words = KINDS[name]
    amplitude = float(np.exp(rng.uniform(*np.log(AMPLITUDE_DEG))))
    noise = float(rng.uniform(*NOISE_SHARE))
    files, colour = {}, motions.draw_colour(rng)
    for motion in MOTIONS:
        files[f"{motion}.csv"] = _spoiled(rng, spoil, motion, amplitude, noise, colour)
    truth = {"seed": seed, "kind": "garbage", "garbage": name, "words": list(words), "truth": [], "effects": {}, "enr": 0.0, "enr_of": {},
             "enr_check": 0.0, "unseen": [], "noise": colour, "noise_rms": noise * amplitude, "model_is_off": False, "load_recorded": False,
             "time_limit_s": TIME_LIMIT_S, "base": dict(zip(("k", "p", "omega", "zeta"), BASE))}  # fmt: skip
    *fit, check = files
    return Bundle(files, fit, [check], model_text(BASE, 2), truth)


def _spoiled(rng, spoil, motion, amplitude, noise, colour):
    time = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    command, position = _servo(rng, time, motion, amplitude, noise, colour)
    _, other = _servo(rng, time, "random_steps" if motion != "sweep" else "noise_band", amplitude, noise, colour)
    time, command, position = spoil(rng, time, command, position, other)
    return {"time": time, "command": command, "position": position}


def _servo(rng, time, motion, amplitude, noise, colour):
    command = amplitude * motions.command(rng, motion, time, HIGHEST_HZ)
    position = linear_fit.respond(BASE, 2, command, 1.0 / RATE_HZ)
    return command, position + noise * position.std() * motions.noise(rng, colour, len(time))


def write(name, seed, folder):
    """Writes the records and the model of one kind of garbage to a folder; returns the bundle, whose `arguments` run the product."""
    bundle = of_kind(name, seed)
    write_bundle(bundle, folder)
    return bundle
