"""The response of a model to a command."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Dict, Optional

import numpy as np

from ._inputs import Model, format_arguments, model_argument, read_csv, write_csv
from ._program import run_json


@dataclass(frozen=True)
class Response:
    """The response of an actuator, at the times of the command."""

    time: np.ndarray
    command: np.ndarray
    position: np.ndarray
    deflection: np.ndarray
    rate: np.ndarray
    unit: str

    def as_dict(self) -> Dict[str, np.ndarray]:
        """The columns by name, as `pandas.DataFrame` takes them."""
        return {name: getattr(self, name) for name in ("time", "command", "position", "deflection", "rate")}


def simulate(
    model: Model,
    time: Any,
    command: Any,
    *,
    interpolation: Optional[str] = None,
    unit: Optional[str] = None,
    fmu: Optional[str] = None,
) -> Response:
    """Steps the model through a command, from rest at its first value; with `fmu`, that FMU with the values of the model.

    Between samples the command is held, or moves linearly with `interpolation="linear"`. Positions are in the unit of the model; a command
    in another unit of the same kind is converted with `unit`.
    """
    with TemporaryDirectory(prefix="actuator-") as name:
        folder = Path(name)
        write_csv(folder / "command.csv", {"time": time, "command": command})
        arguments = ["simulate", model_argument(model, folder), folder / "command.csv", "-o", folder / "response.csv"]
        arguments += ["--fmu", Path(fmu).resolve()] if fmu else []
        said = run_json(arguments + format_arguments(unit, None, None, interpolation), words="simulating")
        columns = read_csv(folder / "response.csv")
    missing = np.full(len(columns["time"]), np.nan)
    wanted = {name: columns.get(name, missing) for name in ("time", "command", "position", "deflection", "rate")}
    return Response(**wanted, unit=said["unit"])
