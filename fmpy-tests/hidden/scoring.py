"""What a diagnosis is worth against the truth.

Physically the same, so that either name is right: a steady `sensor_bias` and `hinge_load.bias`; `hinge_load.stiffness` without a
recorded load and `parameter_shift`. A `parameter_shift` named besides is no error where the model given is off.

    single, pair     right      verdict `named`: exactly the effects that are there
                     first      verdict `ambiguous`, the effects that are there come first
                     listed     each effect is a name or a stated alternative
                     partly     of a pair, one; nothing that is not there
                     spurious   an effect that is there, and one that is not
                     wrong      only effects that are not there
                     abstained  `unexplained` or `nothing_missing`
    clean, outside   named, ambiguous (both are false names), nothing_missing, unexplained
    all              failed     no diagnosis: error, no file, or out of time
"""

from reference.plant import NEUTRAL

from .cases import FAMILY_OF

OUTCOMES = {
    "single": ("right", "first", "listed", "spurious", "wrong", "abstained", "failed"),
    "pair": ("right", "first", "listed", "partly", "spurious", "wrong", "abstained", "failed"),
    "clean": ("nothing_missing", "unexplained", "ambiguous", "named", "failed"),
    "outside": ("unexplained", "nothing_missing", "ambiguous", "named", "failed"),
}
GOOD = ("right", "first", "listed", "partly", "nothing_missing", "unexplained")
NAMING = ("named", "ambiguous")
VERDICTS = (*NAMING, "nothing_missing", "unexplained")
NEVER_SCORED = {"chatter.phase"}  # it means nothing from one record to another


def score(truth, diagnosis):
    """The outcome of one case, with what it named, how far the gap closed and the errors of the parameters."""
    verdict = diagnosis["verdict"]
    if verdict not in VERDICTS:
        raise ValueError(f"verdict {verdict!r}: must be one of {', '.join(VERDICTS)}")
    stated = stated_effects(truth, diagnosis)
    exact, listed, spurious = matched(truth, stated)
    return {
        "outcome": outcome(truth["kind"], verdict, len(truth["truth"]), len(exact), len(listed), len(spurious), len(stated)),
        "verdict": verdict,
        "named": [effect["name"] for effect in stated],
        "alternatives": [name for effect in stated for name in effect.get("alternatives", [])],
        "family_right": family_right(truth, stated, exact, listed),
        "closed": diagnosis["gap"].get("closed"),
        "noise_ratio": diagnosis["gap"]["noise_rms"] / truth["noise_rms"],
        "parameter_errors": {key: value for effect in exact.values() for key, value in parameter_errors(truth, effect).items()},
    }


def stated_effects(truth, diagnosis):
    """The effects of a diagnosis that names any, less what a model that is off explains."""
    if diagnosis["verdict"] not in NAMING:
        return []
    forgiven = "parameter_shift" if truth["model_is_off"] and "parameter_shift" not in truth["truth"] else None
    return [effect for effect in diagnosis["effects"] if effect["name"] != forgiven]


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
    """{true name: stated effect} by name and by alternatives, and the stated effects that are left over."""
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
    if kind in ("clean", "outside"):
        return verdict if stated or verdict not in NAMING else "nothing_missing"
    if not stated:
        return "abstained"
    if spurious:
        return "spurious" if exact + listed else "wrong"
    if exact == hidden:
        return "right" if verdict == "named" else "first"
    return "listed" if exact + listed == hidden else "partly"


def family_right(truth, stated, exact, listed):
    """Each effect that is there was found, listed, or at least one of its family named."""
    families = {FAMILY_OF.get(effect["name"]) for effect in stated}
    return bool(truth["truth"]) and all(
        name in exact or name in listed or FAMILY_OF.get(name, "none") in families for name in truth["truth"])  # fmt: skip


def parameter_errors(truth, effect):
    """Relative errors of a rightly named effect; of what its parameter is away from neutral, where neutral is not nothing."""
    name = effect["name"]
    if name == "parameter_shift":
        true, neutral = {key: truth["base"][key] for key in ("k", "omega", "zeta")}, {}
    else:
        true, neutral = truth["effects"].get(name, {}), NEUTRAL.get(name, {}) if name == "asymmetric_gain" else {}
    errors = {}
    for key, value in true.items():
        label = f"{name}.{key}"
        if label in NEVER_SCORED or label in truth["unseen"] or key not in effect["parameters"]:
            continue
        found = effect["parameters"][key]["value"]
        errors[label] = abs(found - value) / abs(value - neutral.get(key, 0.0))
    return errors
