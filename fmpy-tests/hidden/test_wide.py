"""Wider draws and nuisances are as specified, and the same for the same seed."""

import numpy as np
import pytest

from . import kinds, linear_base, linear_fit, motions, nuisances, plant, wide
from .cases import FAMILY_OF

pytestmark = pytest.mark.slow

FIRST = 2005
TRIPLE = 2000  # one that is found at once


# Pairs and triples are drawn by the same function, and a triple takes seconds.
@pytest.mark.parametrize("kind", [*(kind for kind in wide.KINDS if kind != "triple"), "nuisance"])
def test_a_seed_is_a_case(kind):
    one, again = (kinds.draw(FIRST, kind) for _ in range(2))
    assert one.truth == again.truth and one.model == again.model
    for name, columns in one.files.items():
        assert all(np.array_equal(values, again.files[name][column]) for column, values in columns.items())


@pytest.mark.parametrize("hold", [True, False])
@pytest.mark.parametrize("rate_hz", [50.0, 2000.0])
def test_plant_and_base_agree_at_any_rate_and_hold(rate_hz, hold, rng):
    base, command = (1.1, 400.0, 40.0, 0.6), rng.uniform(-3.0, 3.0, int(2.0 * rate_hz))
    found = plant.simulate(base, {}, np.arange(len(command)) / rate_hz, command, None, 3, hold)
    expected = linear_base.respond(base, 3, command, None, 1.0 / rate_hz, hold)
    assert np.abs(found - expected).max() < 2e-5 * np.abs(expected).max()


@pytest.mark.parametrize("order, base", [(2, (1.2, 0.0, 60.0, 0.5)), (3, (0.9, 300.0, 90.0, 0.7))])
def test_the_linear_fit_finds_the_base_behind_noise(order, base, rng):
    time = np.arange(3000) / 200.0
    command = motions.command(rng, "sweep", time, 12.0)
    position = linear_fit.respond(base, order, command, 0.005) + 1e-4 * rng.standard_normal(3000)
    found, left = linear_fit.fit(time, command, position, order, 10.0)
    assert np.array(found)[[0, 2, 3]] == pytest.approx(np.array(base)[[0, 2, 3]], rel=0.02)
    assert left.std() == pytest.approx(1e-4, rel=0.05)


@pytest.mark.parametrize("kind", motions.MOTIONS)
def test_motions_begin_at_rest_and_have_size_one(kind, rng):
    for rate in (50.0, 2000.0):
        wave = motions.command(rng, kind, np.arange(int(10.0 * rate)) / rate, 6.0)
        assert wave[0] == 0.0 and np.abs(wave).max() == pytest.approx(1.0)


def test_another_seed_is_another_case():
    one, other = (kinds.draw(FIRST + seed, "wide_clean") for seed in (0, 1))
    assert one.truth != other.truth and one.model != other.model


@pytest.mark.parametrize("first", wide.NAMES)
def test_families_of_pairs_and_triples(first, rng):
    pair, triple = wide.of_one_family(rng, first), wide.of_three_families(rng, first)
    assert len(set(pair)) == 2 and len({FAMILY_OF[name] for name in pair}) == 1
    assert len(triple) == 3 == len({FAMILY_OF[name] for name in triple})


def test_three_effects_are_each_visible():
    truth = kinds.draw(TRIPLE, "triple").truth
    assert len(truth["enr_of"]) == 3 and min(truth["enr_of"].values()) >= wide.LEAST_ENR_OF_EACH


@pytest.mark.parametrize("seed", range(FIRST, FIRST + len(wide.UNREACHED)))
def test_a_limit_of_the_check_record_leaves_the_fitted_records_alone(seed):
    case, rng, _ = wide.without_effects(seed, "check_only", wide.RATES_HZ)
    wide.add_to_check(case, rng)
    wide.finish(case)
    free = [linear_base.respond(case.base, case.order, r.command, None, case.sample_time_s, case.hold) for r in case.records]
    met = [linear_base.rms(r.clean - y) / case.noise_rms for r, y in zip(case.records, free)]
    assert max(met[:2]) < 0.05 and met[2] > 1.0


def test_a_sensor_without_sign_has_none():
    seed = next(seed for seed in range(FIRST, FIRST + 9) if seed % 5 == 4)
    bundle = kinds.draw(seed, "wide_outside")
    assert bundle.truth["truth"] == ["unsigned_sensor"] and bundle.truth["enr"] > 1.0
    assert all((columns["position"] >= 0.0).all() for columns in bundle.files.values())


@pytest.fixture(scope="module")
def clean():
    """A case without effects, simulated, and the generator of its nuisance."""
    case, rng, _ = wide.without_effects(FIRST, "nuisance", (500.0,))
    wide.finish(case)
    return case, rng


@pytest.mark.parametrize("name, holds", [
    ("dropped_rows", lambda c, r, got: 0.08 < 1.0 - len(got["time"]) / len(r.time) < 0.12),
    ("gaps", lambda c, r, got: 3 <= np.sum(np.diff(got["time"]) > 0.09) <= 5),
    ("written_jitter", lambda c, r, got: 0.1 < np.std(np.diff(got["time"])) / c.sample_time_s < 0.4 and np.all(np.diff(got["time"]) > 0.0)),
    ("unwritten_jitter", lambda c, r, got: np.array_equal(got["time"], r.time) and 0.0 < np.abs(got["position"] - r.position).max()),
    ("spikes", lambda c, r, got: np.sum(np.abs(got["position"] - r.position) > 29.0 * c.noise_rms) == round(0.001 * len(r.time))),
    ("level_step", lambda c, r, got: len(np.unique(np.round(got["position"] - r.position, 9))) == 2),
    ("hum", lambda c, r, got: 0.4 < linear_base.rms(got["position"] - r.position) / c.noise_rms < 3.1),
    ("start_in_motion", lambda c, r, got: got["time"][0] == 0.0 and len(got["time"]) < 0.91 * len(r.time)),
])  # fmt: skip
def test_each_nuisance_does_what_its_name_says(name, holds, clean):
    case, rng = clean
    for record in case.records:
        assert holds(case, record, nuisances.NUISANCES[name][0](rng, case, record))


def test_every_nuisance_comes_with_and_without_an_effect():
    drawn = [(seed % len(nuisances.NUISANCES), (seed // len(nuisances.NUISANCES)) % 2) for seed in range(40)]
    assert len(set(drawn)) == 2 * len(nuisances.NUISANCES)
    slow, fast = (kinds.draw(seed, "nuisance").truth for seed in (18, 19))
    assert (slow["nuisance"], slow["rate_hz"], fast["nuisance"], fast["rate_hz"]) == ("slow_rate", 50.0, "fast_rate", 2000.0)
