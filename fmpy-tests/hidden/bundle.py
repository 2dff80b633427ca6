"""A case as given to the product: records by file name, their roles, a model, options of the command line; and the truth."""

import json
from dataclasses import dataclass, field

import numpy as np

UNITS = {"k": "deg/deg", "p": "1/s", "omega": "rad/s", "zeta": "1"}


@dataclass
class Bundle:
    files: dict  # name -> {column: values}
    fit: list
    check: list
    model: str
    truth: dict
    options: list = field(default_factory=list)
    digits: int = 9  # digits of the numbers in the files

    @property
    def arguments(self):
        """Arguments of `actuator diagnose`, without the output folder."""
        check = ["--check", *self.check] if self.check else []
        return ["--model", "model.toml", "--fit", *self.fit, *check, *self.options]


def model_text(base, order, delay_s=0.0):
    """A model file of a base (k, p, omega, zeta), alone or behind a delay."""
    lines = [f'{name} = {{ value = {value!r}, unit = "{unit}" }}' for (name, unit), value in zip(UNITS.items(), map(float, base))]
    delay = ["", "[effects.delay]", f'time = {{ value = {float(delay_s)!r}, unit = "s" }}'] if delay_s else []
    return "\n".join(["[base]", f"order = {order}", *lines, *delay, ""])


def write(bundle, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, columns in bundle.files.items():
        np.savetxt(folder / name, np.column_stack(list(columns.values())), f"%.{bundle.digits}g", ",", header=",".join(columns), comments="")
    (folder / "model.toml").write_text(bundle.model)
    (folder / "truth.json").write_text(json.dumps(bundle.truth | {"arguments": bundle.arguments}, indent=2) + "\n")
