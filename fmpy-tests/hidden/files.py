"""A case as files: the inputs of the product (records, model), and the truth, which the product does not read."""

import json

import numpy as np

from .bundle import model_text as model
from .cases import Case


def write(case: Case, folder):
    """sweep.csv, random.csv, check.csv, model.toml and truth.json in this folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for record in case.records:
        named = columns(record)
        np.savetxt(folder / f"{record.name}.csv", np.column_stack(list(named.values())), "%.7f", ",",
                   header=",".join(named), comments="")  # fmt: skip
    (folder / "model.toml").write_text(model(case.model, case.order))
    (folder / "truth.json").write_text(json.dumps(truth(case), indent=2) + "\n")


def columns(record):
    named = {"time": record.time, "command": record.command, "position": record.position}
    return named if record.load is None else named | {"load": record.load}


def truth(case):
    """Everything that the score and a reader need to know about a case."""
    names = ("k", "p", "omega", "zeta")
    return {
        "seed": case.seed, "kind": case.kind, "set": case.set_name, "order": case.order, "effects": case.effects,
        "truth": case.truth, "enr": case.enr, "enr_of": case.enr_of, "enr_check": case.enr_check, "base": dict(zip(names, case.base)),
        "model": dict(zip(names, case.model)), "model_is_off": case.model_is_off, "noise": case.noise,
        "noise_rms": case.noise_rms, "unseen": case.unseen, "gap_is_before_refit": case.gap_is_before_refit, "load_recorded": case.records[0].load is not None,
        "duration_s": float(len(case.records[0].time) * (case.records[0].time[1] - case.records[0].time[0])),
        "check": case.check, "peak_command": max(float(np.abs(r.command).max()) for r in case.records),
    }  # fmt: skip
