"""Common to the kinds of cases on rigs with one effect or none: runs, the repeated draw, records and truth as a bundle."""

from typing import NamedTuple

import numpy as np

from .bundle import Bundle, model_text
from .rig_cases import ROUNDING, unreached

DIGITS = 12  # recorded, of a clock that was started an hour ago


class Run(NamedTuple):
    name: str
    command: np.ndarray
    seed: tuple  # of sensor and logger


def first_found(seed, kind, names, tries, draw_once):
    """The first draw that gives a case; the rigs cycle with the seed."""
    name = names[seed % len(names)]
    for attempt in range(tries):
        try:
            found = draw_once(seed, kind, name, attempt)
        except FloatingPointError:
            continue
        if found:
            return found
    raise RuntimeError(f"seed {seed}: no {kind} on {name} in {tries} tries")


def runs(key, kinds, sizes, command, digits):
    """A run of each kind and size; `command(kind)` has unit size."""
    return [Run(f"{kind}_{index}.csv", np.round(size * command(kind), digits), (*key, index)) for index, (kind, size) in enumerate(zip(kinds, sizes))]


def bundle(seed, kind, drawn, model, fit, check, records, effect, values, stated, more, **of_kind):
    """`stated`: values of the effect in terms of the sensor output; `of_kind`: further truth of this kind."""
    sensor, names = drawn.sensor, [run.name for run in fit + check]
    positions = [columns["position"] for columns in records]
    truth = {
        "seed": seed, "kind": kind, "rig": drawn.name, "number": seed, "truth": [effect.name] if effect else [],
        "effects": {effect.name: stated} if effect else {}, "in_rig": values, "strength_scored": bool(effect and effect.scored),
        "unseen": unreached(effect, stated, fit, positions, range(len(fit))), "inherent": list(drawn.inherent), "outside": list(drawn.outside),
        "coasts": drawn.coasts, "bandwidth_hz": drawn.bandwidth_hz, "rate_hz": sensor.rate_hz, "order": model.order, "model": list(model.base),
        "model_delay_s": model.delay_s, "model_is_off": True, "noise_rms": float(np.hypot(sensor.noise_rms, sensor.step / ROUNDING)), "enr": more,
        "enr_of": {effect.name: more} if effect else {}, "enr_check": more, "base": dict(zip(("k", "p", "omega", "zeta"), model.base)),
        "load_recorded": False, "sensor": vars(sensor), "plant": {key: float(value) for key, value in drawn.plant._asdict().items()},
    }  # fmt: skip
    text = model_text(model.base, model.order, model.delay_s)
    return Bundle(dict(zip(names, records)), names[: len(fit)], names[len(fit) :], text, truth | of_kind, digits=DIGITS)
