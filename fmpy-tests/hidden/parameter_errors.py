"""Errors of the parameters of a correctly named effect."""

from reference.plant import NEUTRAL

NEVER_SCORED = {"chatter.phase"}  # it has no meaning across records


def parameter_errors(truth, effect):
    """Relative errors of a correctly named effect; relative to the distance from neutral where neutral is not zero."""
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
