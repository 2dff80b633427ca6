"""Scores on records without information: refusal with the cause, or no name, within ten seconds.

    refused           exit code 2, and the message states the cause
    refused_unclear   exit code 2 with other words
    silent            a diagnosis that names nothing
    named             a diagnosis with a name, `parameter_shift` among them
    crashed           another exit code, or output that cannot be read
    late              none of these within `TIME_LIMIT_S`
"""

from .garbage import TIME_LIMIT_S

OUTCOMES = ("refused", "silent", "refused_unclear", "named", "crashed", "late", "failed")
GOOD = ("refused", "silent")
BAD_INPUT = 2  # exit code
NAMING = ("named", "leading", "ambiguous")


def refusal(truth, code, message, seconds):
    """The score of a run that ended without a diagnosis."""
    clear = any(word.lower() in message.lower() for word in truth["words"])
    outcome = "crashed" if code != BAD_INPUT else "refused" if clear else "refused_unclear"
    return {"outcome": "late" if seconds > TIME_LIMIT_S else outcome, "named": [], "alternatives": [], "error": message[-300:], "seconds": seconds}


def score(truth, diagnosis, seconds):
    stated = diagnosis["effects"] if diagnosis["verdict"] in NAMING else []
    outcome = "named" if stated else "silent"
    return {"outcome": "late" if seconds > TIME_LIMIT_S else outcome, "verdict": diagnosis["verdict"], "named": [effect["name"] for effect in stated],
            "alternatives": [], "seconds": seconds}  # fmt: skip
