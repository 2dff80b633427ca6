"""Effects of a data logger: samples of the two columns at instants other than the recorded ones, dropped rows, noise.

    synchronous    both columns at the recorded time
    asynchronous   the position is sampled up to a period later than the command, with jitter; some rows are dropped
"""

from dataclasses import dataclass

import numpy as np

LATE = (0.0, 1.0)  # of a sampling period: position behind command
JITTER = (0.02, 0.15)  # of a sampling period, rms
DROPPED = (0.0, 0.05)  # of the rows


@dataclass
class Log:
    name: str
    late: float = 0.0
    jitter: float = 0.0
    dropped: float = 0.0
    jitter_is_written: bool = True


def draw(rng, rig_name):
    """Every rig has a synchronous logger except the one that is about the logger."""
    if rig_name != "logger":
        return Log("synchronous")
    return Log("asynchronous", float(rng.uniform(*LATE)), float(rng.uniform(*JITTER)), float(rng.uniform(*DROPPED)), bool(rng.random() < 0.5))


def record(rng, log, repeat, fine, noise_rms, rate, step=0.0):
    """Columns of one record; an encoder rounds position plus noise to its steps."""
    h, position = fine
    instants = repeat.time + (log.jitter * np.clip(rng.standard_normal(len(repeat.time)), -3.0, 3.0)) / rate
    instants[0] = repeat.time[0]
    instants = np.maximum.accumulate(np.clip(instants, 0.0, None))
    ends = h * np.arange(1, len(position) + 1)
    sampled = np.interp(instants + log.late / rate, ends, position) + noise_rms * repeat.unit_noise
    if step > 0.0:
        sampled = step * np.round(sampled / step)
    # The command in force at the instant; with jitter it may be the previous one.
    in_force = np.clip(np.floor(instants * rate + 1e-6).astype(int), 0, len(repeat.command) - 1)
    command = repeat.command[in_force]
    time = instants if log.jitter_is_written and log.jitter > 0.0 else repeat.time
    kept = np.ones(len(time), bool)
    kept[1:] = (rng.random(len(time) - 1) >= log.dropped) & (np.diff(time) > 0.05 / rate)
    return {"time": time[kept], "command": command[kept], "position": sampled[kept]}
