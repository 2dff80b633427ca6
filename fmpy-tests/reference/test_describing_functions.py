"""Each describing function equals the numerical Fourier integral of its operator."""

import numpy as np
import pytest

from . import command_side
from . import describing_functions as df

pytestmark = pytest.mark.slow

SAMPLES = 1 << 16
THETA = (np.arange(SAMPLES) + 0.5) * 2.0 * np.pi / SAMPLES
# Operators with memory are run over several periods, with fewer samples.
COARSE = 1 << 13
AMPLITUDES = [0.3, 0.55, 1.0, 1.7, 4.0, 25.0]
# Midpoint rule: a kink costs (step)^2 = 1e-8, a jump one step = 1e-4, relative to the height.
KINK, JUMP, COARSE_KINK = 1e-7, 2e-4, 2e-6


def harmonic(output, amplitude, n):
    theta = THETA if len(output) == SAMPLES else (np.arange(COARSE) + 0.5) * 2.0 * np.pi / COARSE
    value = 2j * np.mean(output * np.exp(-1j * n * theta)) / amplitude
    return value / 2j if n == 0 else value


def operator_on_sine(operator, amplitude, frequency=1.0, periods=3):
    """Last period of a command-side operator on a finely sampled sine."""
    turns = np.arange(-1, periods * COARSE) + 0.5
    time = np.arange(len(turns)) / COARSE / frequency
    samples = amplitude * np.sin(2.0 * np.pi * turns / COARSE)
    out = operator(command_side.sampled(time, samples, False, 0.0, time[-1] + 1e-9))
    at = np.searchsorted(out.start, time, side="right") - 1
    return (out.value[at] + out.slope[at] * (time - out.start[at]))[-COARSE:]


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("n", [1, 3])
def test_static_characteristics(amplitude, n):
    x = amplitude * np.sin(THETA)
    cases = [
        (np.clip(x, -0.5, 0.5), df.saturation(amplitude, 0.5, n), KINK),
        (x - np.clip(x, -0.5, 0.5), df.dead_zone(amplitude, 0.5, n), KINK),
        (0.7 * np.sign(x), df.relay(amplitude, 0.7, 0.0, n), JUMP * 0.7 / amplitude),
        (0.7 * np.sign(x) * (np.abs(x) > 0.4), df.relay(amplitude, 0.7, 0.4, n), JUMP * 0.7 / amplitude),
        (0.7 * np.sign(np.cos(THETA)), df.coulomb_friction(amplitude, 0.7, n), JUMP * 0.7 / amplitude),
        (0.4 * np.round(x / 0.4), df.quantiser(amplitude, 0.4, n), JUMP),
        (0.02 * x**3, df.cubic(amplitude, 0.02, n), 1e-12 * amplitude**2),
        (np.where(x < 0.0, 0.6 * x, x), df.asymmetric_gain(amplitude, 0.6, n), KINK),
    ]
    for output, expected, tolerance in cases:
        assert abs(harmonic(output, amplitude, n) - expected) < tolerance


@pytest.mark.parametrize("n", [0, 2, 4])
def test_asymmetric_gain_makes_a_mean_and_even_harmonics(n):
    x = 3.0 * np.sin(THETA)
    assert abs(harmonic(np.where(x < 0.0, 0.6 * x, x), 3.0, n) - df.asymmetric_gain(3.0, 0.6, n)) < KINK


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("n", [1, 3])
def test_play(amplitude, n):
    output = operator_on_sine(lambda signal: command_side.play(signal, 0.8), amplitude)
    assert abs(harmonic(output, amplitude, n) - df.play(amplitude, 0.8, n)) < COARSE_KINK


@pytest.mark.parametrize("multiple", [0.9, 1.05, 1.3, 1.8, 1.9, 3.0, 4.0])
@pytest.mark.parametrize("n", [1, 3])
def test_rate_limiter_below_the_onset_partly_and_fully_limited(multiple, n):
    amplitude, rate = 2.0, 30.0
    frequency = multiple * df.rate_limit_onset_frequency(amplitude, rate)
    output = operator_on_sine(lambda s: command_side.rate_limit(s, rate, rate), amplitude, frequency, periods=24)
    # The limiter forgets its start geometrically, by at least a half per period.
    expected = df.rate_limiter(amplitude, frequency, rate, n)
    assert abs(harmonic(output, amplitude, n) - expected) < COARSE_KINK


def test_rate_limiter_is_continuous_between_its_regimes():
    onset = df.rate_limit_onset_frequency(1.0, 1.0)
    for frequency in (onset, onset * df.FULLY_LIMITED):
        for n in (1, 3):
            below = df.rate_limiter(1.0, frequency * (1.0 - 1e-9), 1.0, n)
            above = df.rate_limiter(1.0, frequency * (1.0 + 1e-9), 1.0, n)
            assert abs(below - above) < 1e-7


def test_friction_takes_the_energy_of_its_equivalent_damping():
    amplitude, frequency, level, omega = 2.0, 3.0, 0.4, 170.0
    w = 2.0 * np.pi * frequency
    zeta = df.equivalent_damping_ratio(amplitude, frequency, level, omega)
    per_period = np.pi * amplitude**2 * w * 2.0 * zeta * omega
    assert np.isclose(per_period, 4.0 * amplitude * omega**2 * level, rtol=1e-12)
