"""The 17 tabulated parameter sets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List

from ._program import run_json


@dataclass(frozen=True)
class Quantity:
    """A value with its unit."""

    value: float
    unit: str


@dataclass(frozen=True)
class ParameterSet:
    """One identified actuator of NASA/TM-1998-208452."""

    set_number: int
    name: str
    surface: str
    stage: str
    load_case: str
    k: Quantity
    p: Quantity
    omega: Quantity
    zeta: Quantity
    source: str


def sets() -> List[ParameterSet]:
    """All 17, in the order of their numbers."""
    quantities = ("k", "p", "omega", "zeta")
    return [
        ParameterSet(**{name: Quantity(**value) if name in quantities else value for name, value in row.items()})
        for row in run_json(["sets"])
    ]
