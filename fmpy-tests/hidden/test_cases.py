"""Cases are as specified: noise of the given size and colour, effects as visible as stated, repeatable seeds."""

import numpy as np
import pytest
from scipy import optimize, signal

from . import cases, excitation, files, linear_base
from .strengths import FAMILIES, OUTSIDE_FAMILIES

pytestmark = pytest.mark.slow

FIRST = 1000  # seeds of these tests; names cycle with the seed
LONG = 200_000  # samples for the measurement of colour
# The noise may resemble the gap by chance, and the fit has three parameters: a twentieth of the ENR, or 0.1 for small ones.
ENR_TOLERANCE, ENR_TOLERANCE_SMALL = 0.05, 0.1


def seeds(names, among):
    return [pytest.param(FIRST + (list(among).index(name) - FIRST) % len(among), id=name) for name in names]


def noisy_enr(case):
    """From the measured positions alone: the residual of a separate fit (Nelder and Mead), less the noise, over the noise."""
    fitted = case.records[:2]
    positions = np.concatenate([record.position for record in fitted])

    def misfit(logarithms):
        """Relative to the true base, within the factors that `refit` allows."""
        if np.abs(logarithms).max() > linear_base.REACH:
            return np.inf
        k, omega, zeta = np.exp(logarithms)
        base = (k * case.base[0], case.base[1], omega * case.base[2], zeta * case.base[3])
        return linear_base.rms(positions - np.concatenate([linear_base.respond(base, case.order, r.command, r.load) for r in fitted]))

    if case.gap_is_before_refit:
        positions = positions - np.concatenate([linear_base.respond(case.model, case.order, r.command, r.load) for r in fitted])
        left = linear_base.rms(positions)
    else:
        corners = 0.05 * np.vstack([np.zeros(3), np.eye(3)])
        options = {"xatol": 1e-4, "fatol": 1e-7, "initial_simplex": corners}
        left = optimize.minimize(misfit, np.zeros(3), method="Nelder-Mead", options=options).fun
    return np.sqrt(max(left**2 / case.noise_rms**2 - 1.0, 0.0))


@pytest.mark.parametrize("seed", seeds(FAMILIES, FAMILIES))
def test_every_effect_is_as_visible_as_its_enr_says(seed):
    case = cases.draw(seed, "single")
    assert cases.LEAST_ENR / 1.5 < case.enr < 1.5 * cases.MOST_ENR
    # noise resembles the motion more closely in few oscillations than in many
    assert abs(noisy_enr(case) - case.enr) < ENR_TOLERANCE * case.enr + ENR_TOLERANCE_SMALL / min(case.enr, 1.0), case.effects


@pytest.mark.parametrize("seed", seeds(OUTSIDE_FAMILIES, OUTSIDE_FAMILIES))
def test_what_is_outside_the_library_is_visible(seed):
    case = cases.draw(seed, "outside")
    assert noisy_enr(case) > 0.5


@pytest.mark.parametrize("seed", range(FIRST, FIRST + 3))
def test_both_effects_of_a_pair_are_visible_and_of_different_families(seed):
    case = cases.draw(seed, "pair")
    assert len({cases.FAMILY_OF[name] for name in case.truth}) == 2
    assert min(case.enr_of.values()) >= cases.LEAST_ENR_IN_PAIR
    assert noisy_enr(case) > 0.7


@pytest.mark.parametrize("seed", range(FIRST, FIRST + 8))
def test_residuals_of_clean_cases_are_the_noise_that_was_asked_for(seed):
    case = cases.draw(seed, "clean")
    for record in case.records:
        residual = record.position - linear_base.respond(case.base, case.order, record.command)
        expected = case.noise_rms * record.unit_noise
        assert np.abs(residual - expected).max() < 1e-4 * np.abs(record.clean).max()
    assert linear_base.rms(np.concatenate([r.unit_noise for r in case.records])) == pytest.approx(1.0, abs=0.1)
    share = case.noise_rms / linear_base.rms(case.records[0].clean)
    assert 0.99 * cases.NOISE_SHARE[0] < share < 1.01 * cases.NOISE_SHARE[1]


def test_white_noise_is_white(rng):
    white = excitation.noise(rng, {"kind": "white"}, LONG)
    assert linear_base.rms(white) == pytest.approx(1.0, rel=0.01)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.01


@pytest.mark.parametrize("memory", [0.6, 0.8, 0.95])
def test_autoregressive_noise_has_the_memory_asked_for(memory, rng):
    noise = excitation.noise(rng, {"kind": "ar1", "memory": memory}, LONG)
    assert linear_base.rms(noise) == pytest.approx(1.0, rel=0.04)  # few independent values if the correlation time is long
    for steps in (1, 2, 5):
        assert np.mean(noise[steps:] * noise[:-steps]) / np.mean(noise**2) == pytest.approx(memory**steps, abs=0.02)


@pytest.mark.parametrize("highest_hz", [10.0, 40.0])
def test_band_limited_noise_ends_where_asked_for(highest_hz, rng):
    noise = excitation.noise(rng, {"kind": "band", "highest_hz": highest_hz}, LONG)
    assert linear_base.rms(noise) == pytest.approx(1.0, rel=0.04)
    frequency, density = signal.welch(noise, 1.0 / excitation.SAMPLE_TIME_S, nperseg=1024)
    flat = density[(frequency > 0.1 * highest_hz) & (frequency < 0.4 * highest_hz)].mean()
    assert np.interp(highest_hz, frequency, density) == pytest.approx(0.5 * flat, rel=0.15)
    assert np.interp(2.0 * highest_hz, frequency, density) < 0.1 * flat


@pytest.mark.parametrize("kind", ["sweep", "random", *excitation.CHECKS])
@pytest.mark.parametrize("quiet", [False, True])
def test_commands_have_the_size_asked_for_and_quiet_ends_where_asked_for(kind, quiet, rng):
    time = excitation.time(25.0)
    command = excitation.command(rng, kind, time, 3.0, quiet)
    assert len(time) == 5000 and np.abs(command).max() == pytest.approx(3.0, abs=1e-6)
    assert (np.abs(command[:200]).max() == 0.0 and np.abs(command[-200:]).max() == 0.0) or not quiet


@pytest.mark.parametrize("kind", cases.KINDS)
def test_a_seed_is_a_case(kind, tmp_path):
    for name in ("one", "other"):
        files.write(cases.draw(FIRST + 3, kind), tmp_path / name)
    for file in sorted((tmp_path / "one").iterdir()):
        assert file.read_bytes() == (tmp_path / "other" / file.name).read_bytes()


def test_another_seed_is_another_case():
    one, other = (cases.draw(FIRST + i, "clean") for i in (3, 4))
    assert files.truth(one) != files.truth(other) and not np.array_equal(one.records[0].unit_noise[:100], other.records[0].unit_noise[:100])
