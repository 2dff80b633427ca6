"""All kinds of cases by name: each is drawn from a seed, as files, a command line and a truth."""

from . import cases, drive_cases, garbage, independent_cases, nuisances, rig_cases, wide
from .bundle import Bundle

DRAWS = {
    **dict.fromkeys(("rig_healthy", "rig_effect", "rig_sensor"), rig_cases.draw), "nuisance": nuisances.draw, "garbage": garbage.draw,
    **dict.fromkeys(("independent", "independent_effect"), independent_cases.draw), **dict.fromkeys(wide.KINDS, wide.draw),
    **dict.fromkeys(("drive", "drive_effect"), drive_cases.draw),
}  # fmt: skip
KINDS = (*cases.KINDS, *DRAWS)
# Enough for rates to a few per cent, in complete rounds: rigs by divisions, effects and nuisances by name.
NUMBERS = {"single": 168, "clean": 600, "outside": 64, "pair": 60, "rig_healthy": 210, "rig_effect": 231, "rig_sensor": 63, "nuisance": 200, "garbage": 130,
           "independent": 120, "independent_effect": 180, "wide": 210, "wide_clean": 200, "wide_pair": 60, "triple": 40, "check_only": 60,
           "wide_outside": 60, "drive": 120, "drive_effect": 200}  # fmt: skip


def draw(seed, kind) -> Bundle:
    """A case of a kind other than those of `cases.py`, whose files `files.py` writes."""
    return DRAWS[kind](seed, kind)
