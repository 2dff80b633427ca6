"""Identification of a parameter set from records."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Dict, List, Mapping, Optional, Union

from ._inputs import format_arguments, record_arguments
from ._program import ActuatorError, run_json


@dataclass(frozen=True)
class Estimate:
    """One estimated parameter; `std_error` is None if the records do not determine it."""

    name: str
    value: float
    unit: str
    std_error: Optional[float] = None
    at_bound: bool = False


@dataclass(frozen=True)
class Fit:
    """An identified actuator, accepted wherever a model is: by `simulate`, by `diagnose`, and saved by `actuator build`."""

    model: str
    """The text of the model file."""
    order: int
    unit: str
    estimates: List[Estimate]
    residual_rms: float
    converged: bool
    notes: List[str]
    warnings: List[str]
    name: Optional[str] = None
    json: Dict[str, Any] = field(default_factory=dict, repr=False)
    """The complete output of `actuator fit --json`."""

    def __getitem__(self, name: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.name == name:
                return estimate
        raise KeyError(name)

    def save(self, path: Union[str, Path]) -> Path:
        """Writes the model file, which the program and other tools read."""
        path = Path(path)
        path.write_text(self.model, encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(e.name)}</td><td>{e.value:.6g}</td><td>{'' if e.std_error is None else f'± {e.std_error:.2g}'}</td>"
            f"<td>{escape(e.unit)}</td></tr>"
            for e in self.estimates
        )
        notes = "".join(f"<li>{escape(note)}</li>" for note in [*self.notes, *self.warnings])
        head = f"Order {self.order}, residual {self.residual_rms:.4g} {escape(self.unit)} rms"
        return f"<p>{head}</p><table>{rows}</table><ul>{notes}</ul>"


def fit(
    records: Any,
    *,
    check: Any = None,
    method: str = "likelihood",
    order: Union[int, str] = "auto",
    delay: Union[float, str] = 0.0,
    unit: Optional[str] = None,
    columns: Optional[Mapping[str, str]] = None,
    time_unit: Optional[str] = None,
    interpolation: Optional[str] = None,
    name: Optional[str] = None,
    report: Union[str, Path, None] = None,
    force: bool = False,
) -> Fit:
    """Identifies k, p, omega and zeta from one or more records.

    A record is the path of a CSV file, a pandas frame with the columns `time`, `command` and `position` (`columns` names others), or a tuple
    (time, command, position). `method` is `"likelihood"` or `"report"`, `order` 2, 3 or `"auto"`, `delay` a number of seconds or `"free"`.
    `report` names an HTML page to write: parameters, measured and modelled response, residual; an existing one is overwritten with `force`.
    """
    with TemporaryDirectory(prefix="actuator-") as folder_name:
        folder = Path(folder_name)
        paths = record_arguments(records, folder, "record", columns)
        if not paths:
            raise ActuatorError("records: found none; allowed: one or more")
        arguments: List[Any] = ["fit", *paths, "--method", method, "--order", order, f"--delay={delay}"]
        for path in record_arguments(check, folder, "check", columns):
            arguments += ["--check", path]
        arguments += ["--name", name] if name else []
        arguments += ["--report", Path(report).resolve()] if report is not None else []
        arguments += ["--force"] if force else []
        said = run_json(arguments + format_arguments(unit, columns, time_unit, interpolation), words="fitting")
    wanted = ("name", "value", "unit", "std_error", "at_bound")
    return Fit(
        model=said["model"],
        order=said["order"],
        unit=said["unit"],
        estimates=[Estimate(**{key: row[key] for key in wanted if key in row}) for row in said["estimates"]],
        residual_rms=said["residual_rms"],
        converged=said["converged"],
        notes=said["notes"],
        warnings=said["warnings"],
        name=name,
        json=said,
    )
