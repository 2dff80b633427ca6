"""The given model of a case: fitted to a healthy record, of order 2 or 3, alone or behind a delay; and its residual on other records.

`plain_enough` searches for an effect whose residual is several times that. Records are on a uniform clock here; jitter is ignored.
"""

from typing import NamedTuple

import numpy as np
from scipy import optimize

from . import linear_fit
from .rig_cases import rms

MODEL_ROWS = 12_000  # of the record that the model is fitted to
LATEST = 0.15  # delay of a model, over the period of the bandwidth
SHARE_LATE = 1.0 / 3.0  # of the models
MOST_MISSED = 0.12  # residual of the model of a healthy rig, relative to the motion
MORE = (3.2, 9.0)  # difference from the model with the effect over that without, both rms
# The same in single records: all but one; at least one fit and one check record; and the largest difference relative to the motion.
MORE_IN_EACH, MORE_IN_ONE, MOST_OF_MOTION = 2.0, (3.0, 2.5), 0.5


class Model(NamedTuple):
    base: tuple
    order: int
    delay_s: float


def fitted(columns, order, is_late, bandwidth_hz, rate_hz):
    """A model of a healthy record, with or without a delay."""
    time, command, position = (values[:MODEL_ROWS] for values in columns.values())
    start, _ = linear_fit.fit(time, command, position, order, bandwidth_hz, most_rows=MODEL_ROWS)
    if not is_late:
        return Model(start, order, 0.0)

    def of_delay(delay_s):
        return linear_fit.fit(time, late(command, delay_s * rate_hz), position, order, bandwidth_hz, start, MODEL_ROWS)

    best = optimize.minimize_scalar(lambda delay_s: rms(of_delay(delay_s)[1]), bounds=(0.0, LATEST / bandwidth_hz), method="bounded",
                                    options={"maxiter": 12})  # fmt: skip
    return Model(of_delay(best.x)[0], order, float(best.x))


def late(command, samples):
    """A held command delayed by a fraction of a sample or more, at the samples."""
    whole = int(samples)
    first, second = (np.r_[np.full(n, command[0]), command[: len(command) - n]] for n in (whole, whole + 1))
    return first + (samples - whole) * (second - first)


def left(model, columns):
    """Residual of a model on a record about its level, rms."""
    time, command, position = columns.values()
    sample_time = (time[-1] - time[0]) / (len(time) - 1)
    gap = position - linear_fit.respond(model.base, model.order, late(command, model.delay_s / sample_time), sample_time)
    return float(np.std(gap))


def motion(columns):
    return float(np.std(columns["position"]))


def plain_enough(rng, model, measure, effect, severities, fits, missed, of_record=left):
    """Values, records and how much more these differ from the model, at the weakest sufficient severity; no values if there is none.
    `measure(name, values)` returns the records, of which the first `fits` are fit records; `missed` is the residual on the healthy ones."""
    wanted, found = rng.uniform(*MORE), ({}, [], 0.0)
    for severity in np.geomspace(effect.least, effect.most, severities):
        values = {key: float(value) for key, value in effect.parameters(severity).items()}
        records = measure(effect.name, values)
        gaps = np.array([of_record(model, columns) for columns in records])
        if np.max(gaps / [motion(columns) for columns in records]) > MOST_OF_MOTION:
            break
        more, each = rms(gaps) / rms(missed), gaps / missed
        to_fit, to_check = each[:fits].max(), each[fits:].max()
        if np.sum(each >= MORE_IN_EACH) >= len(each) - 1 and to_fit >= MORE_IN_ONE[0] and to_check >= MORE_IN_ONE[1]:
            found = values, records, float(more)
            if more >= wanted:
                break
    return found
