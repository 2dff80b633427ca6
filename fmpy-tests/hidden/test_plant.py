"""The plant against scipy where it is linear, and against the reference plant where it is not."""

import numpy as np
import pytest
from scipy import signal

import bact
from reference import random_cases
from reference.plant import simulate as reference

from . import excitation, linear_base, plant

pytestmark = pytest.mark.slow

NAMES = [name for name in random_cases.RANGES if name != "quantisation"]  # rounding comes after the noise: records
# Of the largest position. The corners of dead zones, acceleration limits and plays fall inside steps of 0.1 ms, the rest is exact to
# 1e-7. With noise of 0.5 % of the rms, 5000 samples resolve 5e-5 at best.
ALLOWED = 2e-5
SHORT_S = 0.6


def base_of(s):
    return (s.k, s.p, s.omega, s.zeta)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
def test_without_effects_the_plant_is_the_exact_linear_one(s, order, rng):
    time = excitation.time(3.0)
    command, load = rng.uniform(-5.0, 5.0, len(time)), rng.uniform(-1.0, 1.0, len(time))
    found = plant.simulate(base_of(s), {}, time, command, load, order)
    expected = linear_base.respond(base_of(s), order, command, load)
    assert np.abs(found - expected).max() < ALLOWED * np.abs(expected).max()


@pytest.mark.parametrize("order", [2, 3])
def test_the_linear_base_is_that_of_scipy(order, rng):
    k, p, omega, zeta = base = (1.02, 6898.0, 150.0, 0.6)
    time = excitation.time(3.0)
    command = rng.uniform(-5.0, 5.0, len(time))
    numerator, denominator = [k * omega**2], [1.0, 2.0 * zeta * omega, omega**2]
    if order == 3:
        numerator, denominator = [p * numerator[0]], np.polymul([1.0, p], denominator)
    system = signal.cont2discrete(signal.tf2ss(numerator, denominator), excitation.SAMPLE_TIME_S)  # zero-order hold
    expected = signal.dlsim(system, command)[1][:, 0]
    assert np.abs(linear_base.respond(base, order, command) - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_every_effect_is_that_of_the_reference(name, rng):
    s = bact.SETS[rng.integers(len(bact.SETS))]
    time = excitation.time(SHORT_S)
    parameters = {key: float(rng.uniform(*limits[:2])) for key, limits in random_cases.RANGES[name].items()}
    command = 6.0 * np.sin(2.0 * np.pi * (1.0 + 9.0 * time) * time)
    load = np.repeat(rng.uniform(-1.0, 1.0, len(time) // 20 + 1), 20)[: len(time)]
    expected = reference(base_of(s), {name: parameters}, time, command, load)["unquantised"]
    found = plant.simulate(base_of(s), {name: parameters}, time, command, load)
    assert np.abs(found - expected).max() < ALLOWED * np.abs(expected).max(), (s.name, parameters)


def test_all_effects_together_are_those_of_the_reference(rng):
    """Strengths at which no effect hides the others."""
    effects = {
        "delay": {"time": 0.0123}, "command_limit": {"min": -5.5, "max": 5.0}, "command_rate_limit": {"up": 300.0, "down": 250.0},
        "command_dead_zone": {"half_width": 0.1}, "command_backlash": {"gap": 0.1}, "asymmetric_gain": {"ratio": 0.9},
        "gain_drift": {"rate": 0.02}, "dead_zone": {"half_width": 0.05}, "amplitude_gain": {"cubic": 0.001},
        "hinge_load": {"stiffness": 0.1, "bias": 0.2}, "coulomb_friction": {"level": 0.1}, "acceleration_limit": {"value": 4e4},
        "rate_limit": {"up": 180.0, "down": 200.0}, "position_limit": {"min": -4.5, "max": 4.0}, "backlash": {"gap": 0.2},
        "structural_mode": {"frequency": 12.0, "damping": 0.03, "gain": 0.2}, "sensor_lag": {"time": 0.004},
        "sensor_bias": {"offset": 0.1, "drift": 0.05}, "chatter": {"amplitude": 0.1, "frequency": 15.0, "phase": 0.3},
    }  # fmt: skip
    assert effects.keys() == set(NAMES)
    time = excitation.time(SHORT_S)
    command = 6.0 * np.sin(2.0 * np.pi * (1.0 + 9.0 * time) * time)
    base = base_of(bact.BY_NAME["te-early-unloaded"])
    expected = reference(base, effects, time, command)["unquantised"]
    assert np.abs(plant.simulate(base, effects, time, command) - expected).max() < ALLOWED * np.abs(expected).max()


def test_effects_outside_the_library_are_nothing_at_their_neutral_values():
    time = excitation.time(2.0)
    command = 3.0 * np.sin(12.0 * time)
    base = base_of(bact.BY_NAME["us-middle-loaded"])
    assert np.array_equal(plant.simulate(base, plant.OUTSIDE, time, command), plant.simulate(base, {}, time, command))


def test_a_distributed_play_is_the_sum_of_its_plays():
    """Two plays, of gaps 0.4 and 1.2, each with weight 0.3, plus 0.4 of the drive itself."""
    time = excitation.time(2.0)
    command = 3.0 * np.sin(12.0 * time)
    base = base_of(bact.BY_NAME["us-middle-loaded"])

    def play(gap):
        return plant.simulate(base, {"backlash": {"gap": gap}}, time, command)

    together = plant.simulate(base, {"distributed_play": {"share": 0.6, "first": 0.4, "last": 1.2, "count": 2}}, time, command)
    assert np.allclose(together, 0.4 * play(0.0) + 0.3 * play(0.4) + 0.3 * play(1.2), rtol=0.0, atol=1e-12)


def test_bouc_wen_with_a_short_reach_is_coulomb_friction(rng):
    """z approaches sign(v) within a few times the reach: its force over a full swing is the level of a dry friction."""
    time = excitation.time(2.0)
    command = 3.0 * np.sin(12.0 * time)
    base = base_of(bact.BY_NAME["us-middle-loaded"])
    dry = plant.simulate(base, {"coulomb_friction": {"level": 0.3}}, time, command)
    hysteretic = plant.simulate(base, {"bouc_wen": {"hysteresis": 0.3, "reach": 0.005}}, time, command)
    linear = plant.simulate(base, {}, time, command)
    assert linear_base.rms(hysteretic - dry) < 0.1 * linear_base.rms(linear - dry)


def test_a_drifting_omega_passes_through_the_constant_ones():
    """Under slow drift the plant is at each instant nearly that with the present omega."""
    time = excitation.time(20.0)
    command = 3.0 * np.sin(30.0 * time)
    k, p, omega, zeta = base_of(bact.BY_NAME["us-middle-loaded"])
    drifting = plant.simulate((k, p, omega, zeta), {"drifting_omega": {"drift": 0.02}}, time, command)
    late = time > 19.8
    at_the_end = linear_base.respond((k, p, 1.4 * omega, zeta), 3, command)
    at_the_start = linear_base.respond((k, p, omega, zeta), 3, command)
    assert linear_base.rms((drifting - at_the_end)[late]) < 0.05 * linear_base.rms((at_the_start - at_the_end)[late])
