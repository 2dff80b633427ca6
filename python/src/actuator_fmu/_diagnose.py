"""What a model lacks: the diagnosis of records against it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, Dict, List, Mapping, Optional, Type, TypeVar, Union

from ._inputs import Model, format_arguments, model_argument, record_arguments
from ._program import ActuatorError, run_json

T = TypeVar("T")


@dataclass(frozen=True)
class Parameter:
    """The strength of an effect, with its uncertainty."""

    value: float
    unit: str
    std_error: Optional[float] = None
    at_bound: bool = False
    of_records: Optional[List[float]] = None


@dataclass(frozen=True)
class Effect:
    """An effect added to the model."""

    name: str
    family: str
    parameters: Dict[str, Parameter]
    delta_bic: float
    alternatives: List[str]


@dataclass(frozen=True)
class Place:
    """Where model and records differ."""

    axis: str
    range: List[float]
    unit: str
    share_of_gap: float
    share_of_record: float
    sentence: str


@dataclass(frozen=True)
class Gap:
    """The difference between model and records, measured on the packaged FMU."""

    fit_rms: float
    check_rms: float
    magnitude_max: Optional[float] = None
    phase_max_deg: Optional[float] = None


@dataclass(frozen=True)
class Gaps:
    """That difference before and after."""

    before: Gap
    after: Gap
    noise_rms: float
    closed: float
    parts: Optional[Dict[str, float]] = None


@dataclass(frozen=True)
class Candidate:
    """A candidate explanation."""

    name: str
    family: str
    delta_bic: float
    fit_rms: float
    check_rms: float
    converged: Optional[bool] = None


@dataclass(frozen=True)
class Diagnosis:
    """The fields of `diagnosis.json`; `json` holds them all in raw form."""

    verdict: str
    """`nothing_missing`, `named`, `leading`, `ambiguous` or `unexplained`."""
    sentence: str
    effects: List[Effect]
    where: List[Place]
    gap: Gaps
    candidates: List[Candidate]
    records: List[Dict[str, Any]]
    warnings: List[str]
    folder: Path
    """Contains diagnosis.json, report.html, model.toml and model.fmu."""
    noise: Optional[Dict[str, Any]] = None
    leads: List[Dict[str, Any]] = field(default_factory=list)
    detectable: List[Dict[str, Any]] = field(default_factory=list)
    next_test: Optional[Dict[str, Any]] = None
    reproduce: Optional[Dict[str, Any]] = None
    json: Dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def report(self) -> Path:
        """The page with the evidence."""
        return self.folder / "report.html"

    @property
    def model(self) -> str:
        """The text of the model file with the effects found."""
        return (self.folder / "model.toml").read_text(encoding="utf-8")

    @property
    def fmu(self) -> Path:
        """The FMU of that model."""
        return self.folder / "model.fmu"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(effect.name)}</td><td>{escape(name)}</td><td>{p.value:.4g}"
            f"{'' if p.std_error is None else f' ± {p.std_error:.2g}'} {escape(p.unit)}</td></tr>"
            for effect in self.effects
            for name, p in effect.parameters.items()
        )
        places = "".join(f"<li>{escape(place.sentence)}</li>" for place in self.where)
        warned = "".join(f"<li>{escape(warning)}</li>" for warning in self.warnings)
        return f"<p><b>{escape(self.sentence)}</b></p><table>{rows}</table><ul>{places}{warned}</ul>"


def _of(kind: Type[T], row: Mapping[str, Any]) -> T:
    """The fields known to this version; others remain in `json`."""
    known = {one.name for one in fields(kind)}  # type: ignore[arg-type]
    return kind(**{name: value for name, value in row.items() if name in known})


def diagnose(
    model: Model,
    fit: Any,
    check: Any = None,
    *,
    reference: Any = None,
    output: Union[str, Path, None] = None,
    force: bool = False,
    name: Optional[str] = None,
    unit: Optional[str] = None,
    columns: Optional[Mapping[str, str]] = None,
    time_unit: Optional[str] = None,
    interpolation: Optional[str] = None,
    time_limit: Optional[float] = None,
) -> Diagnosis:
    """Finds where a model and records disagree, identifies the missing effect, and adds it.

    Records are given as to `fit`. Page, model and FMU are written to the folder `output`, or to a temporary one that is not removed.
    """
    folder = Path(output) if output is not None else Path(mkdtemp(prefix="actuator-diagnosis-"))
    with TemporaryDirectory(prefix="actuator-") as inputs_name:
        inputs = Path(inputs_name)
        paths = record_arguments(fit, inputs, "fit", columns)
        if not paths:
            raise ActuatorError("fit: found no records; allowed: one or more")
        arguments: List[Any] = ["diagnose", "--model", model_argument(model, inputs), "--fit", *paths, "-o", folder]
        for option, records in (("check", check), ("reference", reference)):
            others = record_arguments(records, inputs, option, columns)
            arguments += [f"--{option}", *others] if others else []
        arguments += ["--time-limit", time_limit] if time_limit is not None else []
        arguments += ["--name", name] if name else []
        arguments += ["--force"] if force else []
        said = run_json(arguments + format_arguments(unit, columns, time_unit, interpolation), words="diagnosing")
    gap = said["gap"]
    effects = [
        Effect(**{**{key: row[key] for key in ("name", "family", "delta_bic", "alternatives")},
                  "parameters": {name: _of(Parameter, value) for name, value in row["parameters"].items()}})
        for row in said["effects"]
    ]  # fmt: skip
    return Diagnosis(
        verdict=said["verdict"],
        sentence=said["sentence"],
        effects=effects,
        where=[_of(Place, row) for row in said["where"]],
        gap=Gaps(_of(Gap, gap["before"]), _of(Gap, gap["after"]), gap["noise_rms"], gap["closed"], gap.get("parts")),
        candidates=[_of(Candidate, row) for row in said["candidates"]],
        records=said["records"],
        warnings=said["warnings"],
        folder=folder,
        noise=said.get("noise"),
        leads=said.get("leads", []),
        detectable=said.get("detectable", []),
        next_test=said.get("next_test"),
        reproduce=said.get("reproduce"),
        json=said,
    )
