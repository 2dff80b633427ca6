"""The records of `examples/motor-rig` are draws of the suite, as stated in its README."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from . import product

EXAMPLE = Path(__file__).parents[2] / "examples" / "motor-rig"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), [("healthy", "rig_healthy"), ("limited", "rig_effect")])
def test_the_records_are_those_of_the_seed(name, kind, tmp_path):
    seed = int(re.search(rf"`{kind}` (\d+)", (EXAMPLE / "README.md").read_text()).group(1))
    _, arguments = product.write_case(kind, seed, tmp_path)
    records = [argument for argument in arguments if argument.endswith(".csv")]
    assert {path.name for path in (EXAMPLE / name).iterdir()} == {*records, "model.toml"}
    # Mathematical functions of another computer may round differently, which changes the last reported digits of a fitted model.
    stored, drawn = (numbers(tomllib.loads((folder / "model.toml").read_text())) for folder in (EXAMPLE / name, tmp_path))
    assert stored == pytest.approx(drawn, rel=1e-3)
    for record in records:
        stored, drawn = (np.loadtxt(folder / record, delimiter=",", skiprows=1) for folder in (EXAMPLE / name, tmp_path))
        assert stored == pytest.approx(drawn, rel=1e-6, abs=1e-6)


def numbers(model):
    """The order of a base and its numbers, by name."""
    assert set(model) == {"base"}
    return {name: value["value"] if isinstance(value, dict) else value for name, value in model["base"].items()}
