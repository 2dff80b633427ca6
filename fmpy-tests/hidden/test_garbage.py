"""Garbage is as named: each file, read back, has the fault of its name and no other."""

import csv
import json

import numpy as np
import pytest

from . import garbage, linear_fit, scoring_garbage

SEED = 7


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.fixture
def records(tmp_path):
    """Records of one kind, as read back from the files."""

    def get(kind):
        bundle = garbage.write(kind, SEED, tmp_path)
        assert json.loads((tmp_path / "truth.json").read_text())["garbage"] == kind and (tmp_path / "model.toml").is_file()
        return [read(tmp_path / name) for name in (*bundle.fit, *bundle.check)]

    return get


def followed(record):
    """The share of the position's variance that the servo underneath explains of the command."""
    expected = linear_fit.respond(garbage.BASE, 2, record["command"], 1.0 / garbage.RATE_HZ)
    return 1.0 - np.var(record["position"] - expected) / np.var(record["position"])


@pytest.mark.parametrize("kind, holds", [
    ("dead_surface", lambda r: np.ptp(r["position"]) == 0.0 and np.ptp(r["command"]) > 1.0),
    ("dead_with_noise", lambda r: 0.0 < r["position"].std() < 0.1 * r["command"].std() and abs(np.corrcoef(r["position"], r["command"])[0, 1]) < 0.1),
    ("reversed_column", lambda r: followed(r) < 0.8 and followed(r | {"position": r["position"][::-1]}) > 0.99),
    ("white_against_white", lambda r: max(abs(np.corrcoef(r[c][1:], r[c][:-1])[0, 1]) for c in ("command", "position")) < 0.1),
    ("random_walk", lambda r: np.corrcoef(r["position"][1:], r["position"][:-1])[0, 1] > 0.99 and followed(r) < 0.5),
    ("crossed", lambda r: followed(r) < 0.5),
    ("two_seconds_late", lambda r: followed({"command": r["command"][:-400], "position": r["position"][400:]}) > 0.99 and not r["position"][:400].any()),
    ("milliseconds", lambda r: np.diff(r["time"]).mean() == pytest.approx(5.0) and followed(r) > 0.99),
    ("huge", lambda r: np.abs(r["position"]).max() > 1e199 and followed({c: r[c] / garbage.FACTOR for c in ("command", "position")}) > 0.99),
    ("swapped", lambda r: followed({"command": r["position"], "position": r["command"]}) > 0.99),
    ("degrees_against_radians", lambda r: followed(r | {"position": np.rad2deg(r["position"])}) > 0.99),
    ("opposite_sign", lambda r: followed(r | {"position": -r["position"]}) > 0.99),
    ("unrelated", lambda r: followed(r) < 0.5 and np.ptp(r["position"]) > 1.0),
])  # fmt: skip
def test_each_kind_has_the_fault_of_its_name(kind, holds, records):
    for record in records(kind):
        assert holds(record)


def test_there_are_twelve_kinds_and_unrelated_records():
    assert len(garbage.TWELVE) == 12 and {garbage.draw(seed).truth["garbage"] for seed in range(13)} == set(garbage.KINDS)


def test_a_seed_is_a_case():
    one, again, other = (garbage.of_kind("random_walk", seed) for seed in (3, 3, 4))
    for name in one.files:
        assert np.array_equal(one.files[name]["position"], again.files[name]["position"])
        assert not np.array_equal(one.files[name]["position"], other.files[name]["position"])


@pytest.mark.parametrize("code, message, seconds, expected", [
    (2, "sweep.csv: the position does not follow the command", 0.1, "refused"), (2, "bad input", 0.1, "refused_unclear"),
    (101, "panicked", 0.1, "crashed"), (2, "the position does not follow the command", 11.0, "late"),
])  # fmt: skip
def test_a_refusal_counts_where_it_names_the_cause_in_time(code, message, seconds, expected):
    assert scoring_garbage.refusal({"words": ["not follow"]}, code, message, seconds)["outcome"] == expected


@pytest.mark.parametrize("verdict, expected", [("unexplained", "silent"), ("nothing_missing", "silent"), ("leading", "named")])
def test_without_a_refusal_no_name_may_be_said(verdict, expected):
    diagnosis = {"verdict": verdict, "effects": [{"name": "delay"}]}
    assert scoring_garbage.score({"words": []}, diagnosis, 1.0)["outcome"] == expected
