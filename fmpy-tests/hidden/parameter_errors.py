"""How far the parameters of an effect that was rightly named are from those that are there."""

from reference.plant import NEUTRAL

NEVER_SCORED = {"chatter.phase"}  # it means nothing from one record to another


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
