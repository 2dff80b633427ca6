"""Scores on rigs, whose structure is not the product's: by family, and by agreement between divisions of the same rig.
`independent` and `drive` count as `rig_healthy` does; `rig_sensor`, `independent_effect` and `drive_effect` as `rig_effect`.

    rig_healthy   nothing_missing, unexplained        no name: right
                  inherent                            only effects that the rig truly has (its friction, its encoder), as the name or as a tied one,
                                                      or shifted parameters
                  ambiguous, leading, named           false names
    rig_effect    family_named, family_leading,       the family of the dominant effect, and none that the rig has not; the last word is
                  family_ambiguous                    the verdict
                  spurious                            that family and one that the rig has not
                  wrong                               another family
                  abstained                           no name

A name counts as false in the strict rate of `rig_healthy` even where it is `inherent`: the model was fitted to a rig with the same effect.
"""

from .cases import FAMILY_OF
from .parameter_errors import parameter_errors

HEALTHY = ("nothing_missing", "unexplained", "inherent", "ambiguous", "leading", "named", "failed")
FAMILY = {"named": "family_named", "leading": "family_leading", "ambiguous": "family_ambiguous"}
EFFECT = (*FAMILY.values(), "spurious", "wrong", "abstained", "failed")
GOOD = ("nothing_missing", "unexplained", "inherent", *FAMILY.values())
WITHOUT_EFFECT, WITH_EFFECT = ("rig_healthy", "independent", "drive"), ("rig_effect", "rig_sensor", "independent_effect", "drive_effect")
NAMING = ("named", "leading", "ambiguous")
STRENGTH_TOLERANCE = 0.20  # relative


def score(truth, diagnosis):
    verdict = diagnosis["verdict"]
    stated = diagnosis["effects"] if verdict in NAMING else []
    outcome = healthy(truth, verdict, stated) if truth["kind"] in WITHOUT_EFFECT else with_effect(truth, verdict, stated)
    return {
        "outcome": outcome, "named": [effect["name"] for effect in stated], "family_right": outcome in FAMILY.values(),
        "alternatives": [name for effect in stated for name in effect.get("alternatives", [])],
        "strength_errors": strength_errors(truth, stated), "strength_right": strength_right(truth, stated), "parameter_errors": {},
    }  # fmt: skip


def healthy(truth, verdict, stated):
    if not stated:
        return verdict if verdict not in NAMING else "nothing_missing"
    there = {*truth["inherent"], "parameter_shift"}
    said = ({effect["name"], *effect.get("alternatives", [])} for effect in stated)
    return "inherent" if all(there & names for names in said) else verdict


def with_effect(truth, verdict, stated):
    wanted = {FAMILY_OF[name] for name in truth["truth"]}
    also_there = {*truth["inherent"], "parameter_shift"}
    blamed = [effect for effect in stated if FAMILY_OF.get(effect["name"]) in wanted or effect["name"] not in also_there]
    if not blamed:
        return "abstained" if not stated else "wrong"
    right = [effect for effect in blamed if FAMILY_OF.get(effect["name"]) in wanted]
    if len(right) == len(blamed):
        return FAMILY[verdict]
    return "spurious" if right else "wrong"


def strength_errors(truth, stated):
    """Relative errors of the correctly named effect where its strength has a counterpart in the rig and the records reach it."""
    if not truth.get("strength_scored"):
        return {}
    there = [effect for effect in stated if effect["name"] in truth["effects"]]
    return {label: error for effect in there for label, error in parameter_errors(truth, effect).items()}


def strength_right(truth, stated):
    """None if there is no strength to compare."""
    errors = strength_errors(truth, stated)
    return all(error <= STRENGTH_TOLERANCE for error in errors.values()) if errors else None
