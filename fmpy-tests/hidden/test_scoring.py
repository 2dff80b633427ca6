"""The score of a diagnosis: who is right, who is nearly right, and what is the same physics under another name."""

import pytest

from . import tables
from .scoring import score


def truth(kind, effects, **more):
    """A case with these effects; a shift of the parameters is one without parameters."""
    base = {"k": 1.0, "omega": 150.0, "zeta": 0.6}
    names = list(effects)
    known = {name: values for name, values in effects.items() if name != "parameter_shift"}
    return {"kind": kind, "seed": 1, "truth": names, "effects": known, "base": base, "model_is_off": False, "load_recorded": False,
            "unseen": [], "noise_rms": 0.02, "enr": 3.0, "enr_check": 3.0, "enr_of": dict.fromkeys(names, 3.0),
            "noise": {"kind": "white"}} | more  # fmt: skip


def diagnosis(verdict, *effects):
    """Effects as (name, parameters, alternatives)."""
    stated = [{"name": name, "family": "", "parameters": {key: {"value": value} for key, value in parameters.items()},
               "alternatives": list(alternatives)} for name, parameters, alternatives in effects]  # fmt: skip
    return {"verdict": verdict, "effects": stated, "gap": {"closed": 0.99, "noise_rms": 0.02}}


BACKLASH, FRICTION = {"backlash": {"gap": 0.2}}, {"coulomb_friction": {"level": 0.1}}
PAIR = {**BACKLASH, "delay": {"time": 0.01}}


@pytest.mark.parametrize("kind, there, said, expected", [
    ("single", BACKLASH, diagnosis("named", ("backlash", {}, ())), "right"),
    ("single", BACKLASH, diagnosis("ambiguous", ("backlash", {}, ["dead_zone"])), "first"),
    ("single", BACKLASH, diagnosis("ambiguous", ("dead_zone", {}, ["backlash"])), "listed"),
    ("single", BACKLASH, diagnosis("named", ("dead_zone", {}, ())), "wrong"),
    ("single", BACKLASH, diagnosis("named", ("backlash", {}, ()), ("delay", {}, ())), "spurious"),
    ("single", BACKLASH, diagnosis("unexplained"), "abstained"),
    ("single", BACKLASH, diagnosis("nothing_missing"), "abstained"),
    ("pair", PAIR, diagnosis("named", ("delay", {}, ()), ("backlash", {}, ())), "right"),
    ("pair", PAIR, diagnosis("named", ("delay", {}, ())), "partly"),
    ("pair", PAIR, diagnosis("ambiguous", ("sensor_lag", {}, ["delay"]), ("backlash", {}, ())), "listed"),
    ("pair", PAIR, diagnosis("named", ("delay", {}, ()), ("dead_zone", {}, ())), "spurious"),
    ("clean", {}, diagnosis("nothing_missing"), "nothing_missing"),
    ("clean", {}, diagnosis("named", ("delay", {}, ())), "named"),
    ("outside", {"turbulence": {"rms": 0.1}}, diagnosis("ambiguous", ("delay", {}, ["sensor_lag"])), "ambiguous"),
    ("outside", {"turbulence": {"rms": 0.1}}, diagnosis("unexplained"), "unexplained"),
])  # fmt: skip
def test_outcomes(kind, there, said, expected):
    assert score(truth(kind, there), said)["outcome"] == expected


@pytest.mark.parametrize("there, name, more, expected", [
    ({"sensor_bias": {"offset": 0.1}}, "hinge_load", {}, "right"),
    ({"sensor_bias": {"drift": 0.1}}, "hinge_load", {}, "wrong"),
    ({"hinge_load": {"bias": 0.1}}, "sensor_bias", {}, "right"),
    ({"hinge_load": {"stiffness": 0.1}}, "parameter_shift", {}, "right"),
    ({"hinge_load": {"stiffness": 0.1}}, "parameter_shift", {"load_recorded": True}, "wrong"),
    ({"parameter_shift": {}}, "parameter_shift", {"model_is_off": True}, "right"),
])  # fmt: skip
def test_the_same_physics_counts_under_either_name(there, name, more, expected):
    assert score(truth("single", there, **more), diagnosis("named", (name, {}, ())))["outcome"] == expected


def test_shifted_parameters_may_be_named_besides_where_the_model_is_off():
    said = diagnosis("named", ("parameter_shift", {}, ()), ("backlash", {}, ()))
    assert score(truth("single", BACKLASH, model_is_off=True), said)["outcome"] == "right"
    assert score(truth("single", BACKLASH), said)["outcome"] == "spurious"
    only = diagnosis("named", ("parameter_shift", {}, ()))
    assert score(truth("clean", {}, model_is_off=True), only)["outcome"] == "nothing_missing"
    assert score(truth("clean", {}), only)["outcome"] == "named"


def test_the_family_may_be_right_where_the_name_is_not():
    assert score(truth("single", BACKLASH), diagnosis("named", ("dead_zone", {}, ())))["family_right"]
    assert not score(truth("single", BACKLASH), diagnosis("named", ("delay", {}, ())))["family_right"]


def test_errors_of_parameters_are_relative_and_those_of_a_ratio_to_its_distance_from_one():
    found = score(truth("single", BACKLASH), diagnosis("named", ("backlash", {"gap": 0.21}, ())))
    assert found["parameter_errors"] == {"backlash.gap": pytest.approx(0.05)}
    there = {"asymmetric_gain": {"ratio": 0.9}}
    found = score(truth("single", there), diagnosis("named", ("asymmetric_gain", {"ratio": 0.91}, ())))
    assert found["parameter_errors"] == {"asymmetric_gain.ratio": pytest.approx(0.1)}
    limits = {"rate_limit": {"up": 100.0, "down": 300.0}}
    found = score(truth("single", limits, unseen=["rate_limit.down"]), diagnosis("named", ("rate_limit", {"up": 101.0, "down": 1e9}, ())))
    assert found["parameter_errors"] == {"rate_limit.up": pytest.approx(0.01)}


def test_the_tables_hold_every_case_and_the_seeds_that_failed():
    rows = []
    for kind, there, said in (("single", BACKLASH, diagnosis("named", ("backlash", {"gap": 0.2}, ()))),
                              ("single", FRICTION, diagnosis("named", ("delay", {}, ()))),
                              ("clean", {}, diagnosis("nothing_missing"))):  # fmt: skip
        case = truth(kind, there, seed=77)
        rows.append({"truth": case, "seconds": 1.0} | score(case, said))
    text = tables.all_tables(rows)
    assert "| `backlash` | 1 | 1 | 0 | 0 |  |" in text and "| `coulomb_friction` | 1 | 0 | 0 | 0 | `delay` 1 |" in text
    assert "- single 77: wrong; coulomb_friction (ENR 3), white noise; said delay" in text
