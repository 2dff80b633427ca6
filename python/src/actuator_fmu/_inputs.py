"""User inputs: models and records of any kind, written as the files that the program reads."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._program import ActuatorError

if TYPE_CHECKING:
    from ._fit import Fit

Model = Union[str, "os.PathLike[str]", "Fit"]
"""A set name (`te-early-unloaded`), the path of a model file, or a fit."""

Record = Union[str, "os.PathLike[str]", Tuple[Any, Any, Any], Any]
"""The path of a CSV file, (time, command, position), or a pandas frame."""

ROLES = ("time", "command", "position", "load")


def model_argument(model: Model, folder: Path) -> str:
    """A model as an argument of the program."""
    text = getattr(model, "model", None)
    if text is not None:
        path = folder / f"{getattr(model, 'name', None) or 'fitted'}.toml"
        path.write_text(text, encoding="utf-8")
        return str(path)
    name = os.fspath(model)  # type: ignore[arg-type]
    return str(Path(name).resolve()) if Path(name).exists() else str(name)


def is_record(records: Any) -> bool:
    """Whether this is one record, as opposed to a list of them."""
    if isinstance(records, (str, os.PathLike)) or hasattr(records, "columns"):
        return True
    return isinstance(records, tuple) and len(records) in (3, 4) and np.ndim(records[0]) == 1 and not isinstance(records[0], str)


def as_list(records: Any) -> List[Any]:
    """One record or several, as a list."""
    if records is None:
        return []
    return [records] if is_record(records) else list(records)


def record_arguments(records: Any, folder: Path, role: str, columns: Optional[Mapping[str, str]]) -> List[str]:
    """Paths of records; those that are not files are written to `folder`, with the column names that `columns` declares."""
    names = {name: (columns or {}).get(name, name) for name in ROLES}
    paths = []
    for number, record in enumerate(as_list(records), start=1):
        if isinstance(record, (str, os.PathLike)):
            paths.append(str(Path(record).resolve()))
            continue
        path = folder / f"{role}-{number}.csv"
        write_csv(path, _columns(record, names))
        paths.append(str(path))
    return paths


def _columns(record: Any, names: Mapping[str, str]) -> Dict[str, np.ndarray]:
    if hasattr(record, "columns"):
        there = [name for name in names.values() if name in record.columns]
        return {name: np.asarray(record[name], dtype=float) for name in there}
    return dict(zip((names[role] for role in ROLES), (np.asarray(values, dtype=float) for values in record)))


def write_csv(path: Path, columns: Mapping[str, Sequence[float]]) -> None:
    """Columns with all their digits."""
    arrays = [np.asarray(values, dtype=float) for values in columns.values()]
    lengths = [array.shape for array in arrays]
    if any(array.ndim != 1 or array.shape != arrays[0].shape for array in arrays):
        raise ActuatorError(f"{', '.join(columns)}: found arrays of shapes {lengths}; allowed: one dimension and one length")
    np.savetxt(path, np.column_stack(arrays), fmt="%.17g", delimiter=",", header=",".join(columns), comments="")


def read_csv(path: Path) -> Dict[str, np.ndarray]:
    """Columns by name."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    values = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return {name: values[:, column].copy() for column, name in enumerate(names)}


def format_arguments(
    unit: Optional[str], columns: Optional[Mapping[str, str]], time_unit: Optional[str], interpolation: Optional[str]
) -> List[str]:
    """Options that define how records are read."""
    arguments: List[str] = []
    if unit is not None:
        arguments += ["--unit", unit]
    if columns:
        arguments += ["--columns", ",".join(f"{role}={name}" for role, name in columns.items())]
    if time_unit is not None:
        arguments += ["--time-unit", time_unit]
    if interpolation is not None:
        if interpolation not in ("hold", "linear"):
            raise ActuatorError(f"interpolation: found {interpolation!r}; allowed: 'hold' or 'linear'")
        arguments.append(f"--{interpolation}")
    return arguments
