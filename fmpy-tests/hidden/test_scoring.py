"""The score of a diagnosis: right names, nearly right ones, and equivalent physics under another name."""

import pytest

from . import tables
from .scoring import refusal, score, widened


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
LIMIT_ALONE = {"name": "command_rate_limit", "only_in": "check.csv"}
LIMIT = {"rate_limit": {"up": 100.0, "down": 100.0}}
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
    ("outside", {"turbulence": {"rms": 0.1}}, diagnosis("nothing_missing"), "missed"),
    ("outside", {"turbulence": {"rms": 0.1}}, diagnosis("leading", ("delay", {}, ())), "leading"),
    ("single", BACKLASH, diagnosis("leading", ("backlash", {}, ())), "leading"),
    ("single", BACKLASH, diagnosis("leading", ("dead_zone", {}, ["backlash"])), "listed"),
    ("clean", {}, diagnosis("leading", ("delay", {}, ())), "leading"),
    ("nuisance", {}, diagnosis("nothing_missing"), "nothing_missing"),
    ("nuisance", BACKLASH, diagnosis("named", ("backlash", {}, ())), "right"),
    ("check_only", LIMIT, diagnosis("nothing_missing"), "missed"),
    ("check_only", LIMIT, diagnosis("unexplained"), "abstained"),
    ("check_only", LIMIT, diagnosis("unexplained") | {"leads": [{"name": "command_rate_limit"}]}, "suspected"),
    ("check_only", LIMIT, diagnosis("unexplained") | {"leads": [{"name": "delay"}]}, "abstained"),
    ("check_only", LIMIT, diagnosis("leading", ("rate_limit", {}, ())), "leading"),
    ("check_only", LIMIT, diagnosis("leading", ("parameter_shift", {}, ())) | {"leads": [LIMIT_ALONE]}, "wrong"),
])  # fmt: skip
def test_outcomes(kind, there, said, expected):
    assert score(truth(kind, there), said)["outcome"] == expected


@pytest.mark.parametrize("name, enr, expected", [
    ("turbulence", 0.4, "nothing_missing"), ("turbulence", 0.6, "missed"), ("drifting_omega", 0.4, "missed"), ("drifting_omega", 0.2, "nothing_missing"),
])  # fmt: skip
def test_outside_effects_are_missed_only_where_they_are_visible(name, enr, expected):
    assert score(truth("outside", {name: {}}, enr=enr), diagnosis("nothing_missing"))["outcome"] == expected


@pytest.mark.parametrize("said, expected", [(LIMIT_ALONE, "suspected"), (LIMIT_ALONE | {"only_in": None}, "abstained"), (LIMIT_ALONE | {"name": "delay"}, "abstained")])
def test_what_shows_alone_beside_a_model_that_was_off_is_suspected(said, expected):
    leading = diagnosis("leading", ("parameter_shift", {}, ["delay"])) | {"leads": [said]}
    assert score(truth("check_only", LIMIT, model_is_off=True), leading)["outcome"] == expected


def rig(kind, effects, **more):
    return truth(kind, effects, model_is_off=True, inherent=["coulomb_friction"], strength_scored=True, number=1) | more


@pytest.mark.parametrize("kind, there, said, expected", [
    ("rig_healthy", {}, diagnosis("unexplained"), "unexplained"),
    ("rig_healthy", {}, diagnosis("leading", ("backlash", {}, ())), "leading"),
    ("rig_healthy", {}, diagnosis("leading", ("coulomb_friction", {}, ())), "inherent"),
    ("rig_healthy", {}, diagnosis("leading", ("dead_zone", {}, ["backlash", "coulomb_friction"])), "inherent"),
    ("rig_healthy", {}, diagnosis("leading", ("dead_zone", {}, ["backlash"])), "leading"),
    ("rig_healthy", {}, diagnosis("named", ("parameter_shift", {}, ())), "inherent"),
    ("rig_healthy", {}, diagnosis("named", ("coulomb_friction", {}, ()), ("delay", {}, ())), "named"),
    ("rig_effect", BACKLASH, diagnosis("leading", ("dead_zone", {}, ())), "family_leading"),
    ("rig_effect", BACKLASH, diagnosis("named", ("backlash", {}, ()), ("parameter_shift", {}, ())), "family_named"),
    ("rig_effect", LIMIT, diagnosis("named", ("rate_limit", {}, ()), ("coulomb_friction", {}, ())), "family_named"),
    ("rig_effect", LIMIT, diagnosis("named", ("rate_limit", {}, ()), ("delay", {}, ())), "spurious"),
    ("rig_effect", LIMIT, diagnosis("ambiguous", ("delay", {}, ["rate_limit"])), "wrong"),
    ("rig_effect", LIMIT, diagnosis("leading", ("coulomb_friction", {}, ())), "wrong"),
    ("rig_effect", LIMIT, diagnosis("unexplained"), "abstained"),
    ("independent", {}, diagnosis("leading", ("coulomb_friction", {}, ())), "inherent"),
    ("independent", {}, diagnosis("leading", ("backlash", {}, ())), "leading"),
    ("independent_effect", BACKLASH, diagnosis("leading", ("dead_zone", {}, ())), "family_leading"),
    ("independent_effect", LIMIT, diagnosis("named", ("delay", {}, ())), "wrong"),
    ("drive", {}, diagnosis("named", ("coulomb_friction", {}, ())), "inherent"),
    ("drive_effect", BACKLASH, diagnosis("named", ("backlash", {}, ())), "family_named"),
])  # fmt: skip
def test_rigs_are_scored_by_family(kind, there, said, expected):
    assert score(rig(kind, there), said)["outcome"] == expected


@pytest.mark.parametrize("found, expected", [({"up": 119.0, "down": 85.0}, True), ({"up": 121.0, "down": 100.0}, False)])
def test_a_strength_is_right_within_a_fifth(found, expected):
    assert score(rig("rig_effect", LIMIT), diagnosis("leading", ("rate_limit", found, ())))["strength_right"] is expected
    assert score(rig("rig_effect", LIMIT), diagnosis("leading", ("position_limit", {"min": -1.0}, ())))["strength_right"] is None


@pytest.mark.parametrize("found, expected", [(0.952, True), (0.97, False)])
def test_the_strength_of_a_ratio_is_its_distance_from_one(found, expected):
    said = diagnosis("leading", ("asymmetric_gain", {"ratio": found}, ()))
    assert score(rig("independent_effect", {"asymmetric_gain": {"ratio": 0.95}}), said)["strength_right"] is expected


@pytest.mark.parametrize("before, after, expected", [(0.1, 0.09, False), (0.1, 0.1, False), (0.1, 0.101, True), (None, 0.1, None)])
def test_a_gap_that_grew_is_a_violation(before, after, expected):
    assert widened({"gap": {"before": {"check_rms": before}, "after": {"check_rms": after}}}) is expected


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


@pytest.mark.parametrize("there, code, message, is_right", [
    ({"unsigned_sensor": {}}, 2, "actuator: sweep.csv: record: found a sensor that tells no sign; give the position its sign", True),
    ({"unsigned_sensor": {}}, 2, "actuator: sweep.csv: line 3: found -; allowed: a number", False),
    ({"unsigned_sensor": {}}, 101, "a sensor that tells no sign", False),
    ({"turbulence": {}}, 2, "a sensor that tells no sign", False),
])  # fmt: skip
def test_a_sensor_without_sign_is_refused_for_this_reason(there, code, message, is_right):
    row = refusal(truth("wide_outside", there), code, message, 1.0)
    assert (row or {}).get("outcome") == ("refused" if is_right else None)


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


def test_the_tables_hold_intervals_the_agreement_of_divisions_and_violations():
    rows = []
    for number, verdicts in enumerate([("unexplained", "unexplained"), ("unexplained", "nothing_missing")]):
        for verdict in verdicts:
            case = rig("rig_healthy", {}, number=number, rig="cascade", seed=number)
            rows.append({"truth": case, "seconds": 1.0} | score(case, diagnosis(verdict)))
    rows[0]["widened"], rows[1]["widened"] = True, False
    text = tables.all_tables(rows)
    assert "unexplained 3 (75.0 %, 30.1 to 95.4)" in text and "Any name: 0 of 4: 0.0 % (0.0 to 49.0)" in text
    assert "Draws with the verdict of most of their rig: 3 of 4: 75.0 %" in text
    assert "agree in the verdict: 1 of 2: 50.0 %" in text and "1 of 2: 50.0 % (9.5 to 90.5).\n- rig_healthy 0" in text


@pytest.mark.parametrize("kind, name, title", [("independent", "stepper", "Independent rigs"), ("drive", "worm", "Drives of eight technologies")])
def test_the_tables_hold_the_independent_rigs_apart(kind, name, title):
    rows = []
    for of, there, said in ((kind, {}, diagnosis("leading", ("backlash", {}, ()))),
                              (f"{kind}_effect", LIMIT, diagnosis("leading", ("rate_limit", {"up": 105.0, "down": 95.0}, ())))):  # fmt: skip
        case = rig(of, there, rig=name, seed=6)
        rows.append({"truth": case, "seconds": 1.0} | score(case, said))
    text = tables.all_tables(rows)
    assert f"- **{kind}**, 1 cases" in text and "false names 1 of 1" in text and f"- {kind} 6: leading; {name}" in text
    healthy, effect = text.split(f"## {title}, healthy")[1].split(f"## {title} with one effect, by effect")
    assert f"| {name} | 1 | 1 | `backlash` 1 |" in healthy and "agree" not in healthy
    assert "| rate limit | 1 | 1 | `rate_limit` 1 |" in effect and "strength within 20 % where it has a counterpart: 1 of 1" in effect
