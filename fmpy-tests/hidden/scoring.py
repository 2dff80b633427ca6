"""The score of a diagnosis against the truth.

Physically equivalent, so that either name is right: a steady `sensor_bias` and `hinge_load.bias`; `hinge_load.stiffness` without a
recorded load and `parameter_shift`. An additional `parameter_shift` is no error where the given model is in error.

    one or more effects: single, pair, wide, wide_pair, triple, and nuisance with one
                     right      verdict `named`: exactly the true effects
                     leading    the same, verdict `leading`
                     first      verdict `ambiguous`, the true effects come first
                     listed     each effect is a name or a stated alternative
                     partly     one of a pair, and no false effect
                     spurious   a true effect and a false one
                     wrong      only false effects
                     abstained  `unexplained` or `nothing_missing`
    none: clean, wide_clean, and nuisance without one
                     named, leading, ambiguous (all are false names), nothing_missing, unexplained
    outside, wide_outside: the same, and
                     missed     `nothing_missing` where the gap is visible
                     refused    a sensor without sign: exit code 2, and the message says so
    check_only       suspected  `unexplained`, the effect or its family among the leads or the stated suspicions; or the error of the model leads,
                                and that is said of the check record
                     right, leading, first, listed, wrong, spurious, missed (`nothing_missing`), abstained
    rigs, garbage    scoring_rigs.py, scoring_garbage.py
    all              failed     no diagnosis: error, no file, or out of time
"""

import json

from . import scoring_garbage, scoring_rigs
from .cases import FAMILY_OF
from .parameter_errors import parameter_errors

EFFECTS = ("right", "first", "leading", "listed", "partly", "spurious", "wrong", "abstained", "failed")
NONE = ("nothing_missing", "unexplained", "ambiguous", "leading", "named", "failed")
OUTSIDE = ("unexplained", "missed", *NONE[:1], *NONE[2:])
OUTCOMES = {
    "single": tuple(name for name in EFFECTS if name != "partly"), "clean": NONE, "outside": OUTSIDE, "pair": EFFECTS,
    **dict.fromkeys(scoring_rigs.WITHOUT_EFFECT, scoring_rigs.HEALTHY), **dict.fromkeys(scoring_rigs.WITH_EFFECT, scoring_rigs.EFFECT),
    "nuisance": EFFECTS, "nuisance without effect": NONE,
    "garbage": scoring_garbage.OUTCOMES, "wide": EFFECTS, "wide_clean": NONE, "wide_pair": EFFECTS, "triple": EFFECTS,
    "check_only": ("suspected", "right", "first", "leading", "listed", "spurious", "wrong", "abstained", "missed", "failed"),
    "wide_outside": ("refused", *OUTSIDE),
}  # fmt: skip
FALSE_NAMES = ("named", "leading", "ambiguous")
# Not among the cases to examine: nothing is false, and nothing visible is missed.
GOOD = ("right", "first", "listed", "partly", "nothing_missing", "unexplained", "suspected", "silent", *scoring_rigs.GOOD, *scoring_garbage.GOOD)
NAMING = ("named", "leading", "ambiguous")
VERDICTS = (*NAMING, "nothing_missing", "unexplained")
VISIBLE_ENR = 0.5  # from this ENR on, `nothing_missing` has missed the effect
VISIBLE_ENR_OF_DRIFT = 0.3  # a drifting omega is more visible: its gap varies with time
WIDER = 1e-6  # relative; a gap on the check record that grew by more than rounding


def score(truth, diagnosis):
    """The outcome of one case, with the names, the closed part of the gap and the errors of the parameters."""
    verdict = diagnosis["verdict"]
    if verdict not in VERDICTS:
        raise ValueError(f"verdict {verdict!r}: must be one of {', '.join(VERDICTS)}")
    kind = kind_of(truth)
    if kind in (*scoring_rigs.WITHOUT_EFFECT, *scoring_rigs.WITH_EFFECT):
        return common(truth, diagnosis) | scoring_rigs.score(truth, diagnosis)
    stated = stated_effects(truth, diagnosis)
    exact, listed, spurious = matched(truth, stated)
    if kind == "check_only":
        said = outcome_of_check_only(truth, diagnosis, verdict, exact, listed, spurious, stated)
    else:
        said = outcome(kind, verdict, len(truth["truth"]), len(exact), len(listed), len(spurious), len(stated))
    if kind in ("outside", "wide_outside") and said == "nothing_missing" and truth["enr"] > visible_enr(truth):
        said = "missed"
    return common(truth, diagnosis) | {
        "outcome": said,
        "named": [effect["name"] for effect in stated],
        "alternatives": [name for effect in stated for name in effect.get("alternatives", [])],
        "family_right": family_right(truth, stated, exact, listed),
        "parameter_errors": {key: value for effect in exact.values() for key, value in parameter_errors(truth, effect).items()},
    }


def refusal(truth, code, message, seconds):
    """The score of a run that ended without a diagnosis, if that is right; otherwise None."""
    is_right = "unsigned_sensor" in truth["truth"] and code == scoring_garbage.BAD_INPUT and "sign" in message
    return {"outcome": "refused", "named": [], "alternatives": [], "error": message[-300:], "seconds": seconds} if is_right else None


def kind_of(truth):
    """The kind whose outcomes apply: it depends on whether a nuisance case has an effect."""
    return "nuisance without effect" if truth["kind"] == "nuisance" and not truth["truth"] else truth["kind"]


def common(truth, diagnosis):
    """The items recorded for every diagnosis."""
    gap = diagnosis["gap"]
    return {"verdict": diagnosis["verdict"], "closed": gap.get("closed"), "noise_ratio": gap["noise_rms"] / truth["noise_rms"], "widened": widened(diagnosis)}


def widened(diagnosis):
    """Whether the gap on the check record grew, which no verdict may cause; None if none is stated."""
    before, after = (diagnosis["gap"].get(when, {}).get("check_rms") for when in ("before", "after"))
    return None if before is None or after is None else bool(after > before * (1.0 + WIDER))


def visible_enr(truth):
    return VISIBLE_ENR_OF_DRIFT if "drifting_omega" in truth["truth"] else VISIBLE_ENR


def outcome_of_check_only(truth, diagnosis, verdict, exact, listed, spurious, stated):
    if verdict == "nothing_missing":
        return "missed"
    said = outcome("check_only", verdict, len(truth["truth"]), len(exact), len(listed), len(spurious), len(stated))
    is_suspected = suspected(truth, diagnosis) if verdict == "unexplained" else said == "abstained" and shown_alone(truth, diagnosis)
    return "suspected" if is_suspected else said


def shown_alone(truth, diagnosis):
    """For a model in error: the true effect, or one of its family, is stated for the check record beside a leading base."""
    families = {FAMILY_OF.get(lead["name"], lead["name"]) for lead in diagnosis.get("leads", []) if lead.get("only_in")}
    return any(FAMILY_OF[name] in families for name in truth["truth"])


def suspected(truth, diagnosis):
    """The true effect, or one of its family, is among the leads or in the report's statements on the check record."""
    leads = {lead["name"] for lead in diagnosis.get("leads", [])}
    families = {FAMILY_OF.get(name, name) for name in leads}
    text = json.dumps([diagnosis.get("suspicion"), diagnosis.get("where")])
    return any(FAMILY_OF[name] in families or name in text for name in truth["truth"])


def stated_effects(truth, diagnosis):
    """The effects named by a diagnosis, less those due to a model in error and other true ones; an effect that lists a true one as its alternative
    counts as that one."""
    if diagnosis["verdict"] not in NAMING:
        return []
    forgiven = set(truth.get("inherent", ()))
    if truth["model_is_off"]:
        forgiven |= {"parameter_shift"}
    forgiven -= set(truth["truth"])
    present = {right for name in truth["truth"] for right in same_as(truth, name)}
    return [effect for effect in diagnosis["effects"] if effect["name"] not in forgiven or present & set(effect.get("alternatives", []))]


def same_as(truth, name):
    """All names that are right for one effect of the truth."""
    used = set(truth["effects"].get(name, ()))
    if name == "hinge_load" and used == {"bias"}:
        return {name, "sensor_bias"}
    if name == "sensor_bias" and used == {"offset"}:
        return {name, "hinge_load"}
    if name == "hinge_load" and used == {"stiffness"} and not truth["load_recorded"]:
        return {name, "parameter_shift"}
    return {name}


def matched(truth, stated):
    """{true name: stated effect} by name and by alternatives, and the remaining stated effects."""
    left, exact, listed = list(stated), {}, {}
    for name in truth["truth"]:
        effect = next((effect for effect in left if effect["name"] in same_as(truth, name)), None)
        if effect:
            exact[name] = effect
            left.remove(effect)
    for name in truth["truth"]:
        effect = next((effect for effect in left if same_as(truth, name) & set(effect.get("alternatives", []))), None)
        if name not in exact and effect:
            listed[name] = effect
            left.remove(effect)
    return exact, listed, left


def outcome(kind, verdict, hidden, exact, listed, spurious, stated):
    if not hidden or kind in ("outside", "wide_outside"):
        return verdict if stated or verdict not in NAMING else "nothing_missing"
    if not stated:
        return "abstained"
    if spurious:
        return "spurious" if exact + listed else "wrong"
    if exact == hidden:
        return {"named": "right", "leading": "leading", "ambiguous": "first"}[verdict]
    return "listed" if exact + listed == hidden else "partly"


def family_right(truth, stated, exact, listed):
    """Each true effect was found or listed, or at least one of its family was named."""
    families = {FAMILY_OF.get(effect["name"]) for effect in stated}
    return bool(truth["truth"]) and all(
        name in exact or name in listed or FAMILY_OF.get(name, "none") in families for name in truth["truth"])  # fmt: skip
