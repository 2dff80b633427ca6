"""Rigs follow their equations: loops reach their reference, limits hold, plays are visible, friction sticks."""

import numpy as np
import pytest

from . import linear_fit, motions, recorder, rig_cases, rig_effects, rig_equations, rigs
from .rig_equations import MOTOR, NEUTRAL, RADIANS

pytestmark = pytest.mark.slow

RATE_HZ = 500.0
H = rigs.fine_step(RATE_HZ)
WITHOUT_STEADY_ERROR = ("pi_motor", "cascade", "flexible", "encoder", "logger")
# Proportional loops with friction stop short of their reference: relative to the amplitude. `pi_motor` and `cascade` integrate the error away.
REACHED = 0.03


def drawn(name, number=3):
    return rigs.draw(np.random.default_rng([number, 17]), name)


def moved(rig, reference, **changes):
    return rigs.move(rig, rig.plant._replace(**changes), reference, H)


def sweep(rig, seconds=6.0):
    time = H * np.arange(int(seconds / H))
    return rig.amplitude_deg * motions.command(np.random.default_rng(1), "sweep", time, rig.highest_hz)


@pytest.mark.parametrize("name", WITHOUT_STEADY_ERROR)
@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_position_loop_reaches_its_reference(name, number):
    rig = drawn(name, number)
    reference = np.full(int(8.0 / H), rig.amplitude_deg)
    reference[: int(0.1 / H)] = 0.0
    position, _ = moved(rig, reference)
    assert position[-1] == pytest.approx(rig.amplitude_deg, abs=REACHED * rig.amplitude_deg)


def test_a_pi_loop_has_no_steady_error_under_a_constant_load_and_a_proportional_one_has():
    """MOTOR with gravity on a long arm (nearly constant): the error of the proportional loop is gravity lag / kp."""
    plant = NEUTRAL._replace(structure=MOTOR, kp=20.0, lag=0.02, gravity=500.0, zero=90.0)
    reference = np.zeros(int(10.0 / H))
    for ki, error in ((0.0, 500.0 * 0.02 / 20.0), (60.0, 0.0)):
        position, _, _ = rig_equations.march(plant._replace(ki=ki), H, reference, 0.0)
        assert -position[-1] == pytest.approx(error * np.sin(RADIANS * (90.0 + position[-1])), abs=1e-3)


def test_a_linear_motor_is_the_second_order_servo_of_its_numbers():
    """Proportional loop, first-order motor: lag x'' + x' + kp x = kp r, against scipy."""
    plant = NEUTRAL._replace(structure=MOTOR, kp=30.0, lag=0.015)
    reference = sweep(drawn("pi_motor"))
    _, position, _ = rig_equations.march(plant, H, reference, 0.0)
    omega = np.sqrt(30.0 / 0.015)
    expected = linear_fit.respond((1.0, 0.0, omega, 0.5 / (0.015 * omega)), 2, reference, H)
    assert np.abs(position[:-1] - expected[1:]).max() < 0.01 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["pi_motor", "geared"])
def test_a_saturated_motor_never_exceeds_its_no_load_speed(name):
    rig = drawn(name)
    limit = 0.4 * 2.0 * np.pi * rig.highest_hz * rig.amplitude_deg
    reference = sweep(rig)
    _, speed = moved(rig, reference, rate=limit, gravity=0.0, coulomb=0.0)
    assert 0.95 * limit < np.abs(speed).max() <= limit * (1.0 + 1e-9)
    _, free = moved(rig, reference)
    assert np.abs(free).max() > 1.5 * limit


@pytest.mark.parametrize("name, overshoot", [("cascade", 1.35), ("encoder", 1.35), ("flexible", 1.35), ("hydraulic", 1.6)])
def test_a_limited_speed_loop_stays_near_its_limit(name, overshoot):
    """The limit is that of the reference of an inner loop, which overshoots a little; a valve at full opening passes up to sqrt(2) times its
    flow without load while the load drives, and the oil is a spring."""
    rig = drawn(name)
    limit = 0.4 * 2.0 * np.pi * rig.highest_hz * rig.amplitude_deg
    _, speed = moved(rig, sweep(rig), rate=limit)
    assert 0.6 * limit < np.percentile(np.abs(speed), 99) < overshoot * limit


@pytest.mark.parametrize("name", rigs.RIGS)
def test_stops_are_never_passed(name):
    rig = drawn(name)
    lowest, highest = -0.5 * rig.amplitude_deg, 0.4 * rig.amplitude_deg
    reference = sweep(rig)
    plant = rig_effects.in_rig("position_limit", {"min": lowest, "max": highest}, rig.plant)
    position, _, _ = rig_equations.march(plant, H, reference, 0.0)
    assert position.min() == pytest.approx(lowest) and position.max() == pytest.approx(highest)


@pytest.mark.parametrize("name", rigs.RIGS)
def test_healthy_rigs_keep_clear_of_their_saturations(name):
    rig = drawn(name)
    reference = sweep(rig)
    position, speed = moved(rig, reference)
    unlimited = {"rate": 1e9, "acceleration": 1e12} if name != "hydraulic" else {"rate": 1e9}
    assert np.abs(moved(rig, reference, **unlimited)[0] - position).max() < 1e-3 * rig.amplitude_deg
    assert np.abs(speed).max() < rig.plant.rate


def test_backlash_shows_its_gap_in_a_slow_triangle():
    """The up and down branches of the output over the encoder are separated by the gap."""
    rig = drawn("cascade")
    time = H * np.arange(int(20.0 / H))
    reference = rig.amplitude_deg * np.interp(time % 10.0, [0.0, 2.5, 7.5, 10.0], [0.0, 1.0, -1.0, 0.0])
    inside, _ = moved(rig, reference)
    output = rig_effects.at_output("backlash", {"gap": 1.5}, inside)
    late = (time > 10.0) & (np.abs(inside) < 0.5 * rig.amplitude_deg)
    rising = np.gradient(inside) > 0.0
    lost = (inside - output)[late]
    assert np.median(lost[rising[late]]) - np.median(lost[~rising[late]]) == pytest.approx(1.5, rel=1e-3)


def test_friction_holds_a_small_error_and_lets_a_large_one_go():
    """MOTOR sticks while kp |e| / lag stays below the friction."""
    plant = NEUTRAL._replace(structure=MOTOR, kp=20.0, lag=0.02, coulomb=500.0)
    for step, moves in ((0.49, False), (0.51, True)):  # 500 * 0.02 / 20 = 0.5 deg
        position, _, _ = rig_equations.march(plant, H, np.full(2000, step), 0.0)
        assert bool(np.abs(position).max() > 0.0) is moves


@pytest.mark.parametrize("name, values", [
    ("command_limit", {"min": -2.0, "max": 3.0}), ("command_rate_limit", {"up": 40.0, "down": 40.0}),
    ("command_dead_zone", {"half_width": 0.7}), ("command_backlash", {"gap": 0.8}), ("delay", {"time": 0.05}),
])  # fmt: skip
def test_effects_of_the_command_side_are_what_they_are_called(name, values):
    time = H * np.arange(int(4.0 / H))
    wave = 5.0 * np.sin(2.0 * np.pi * 2.0 * time)
    shaped = rig_effects.in_reference(name, values, wave, H)
    expected = {
        "command_limit": lambda: shaped.min() == -2.0 and shaped.max() == 3.0,
        "command_rate_limit": lambda: np.abs(np.diff(shaped)).max() <= 40.0 * H * (1 + 1e-9) and np.abs(np.diff(wave)).max() > 40.0 * H,
        "command_dead_zone": lambda: np.allclose(np.abs(wave - shaped).max(), 0.7) and not shaped[np.abs(wave) < 0.7].any(),
        "command_backlash": lambda: np.abs(wave - shaped).max() == pytest.approx(0.4),
        "delay": lambda: np.array_equal(shaped[int(round(0.05 / H)) :], wave[: -int(round(0.05 / H))]),
    }
    assert expected[name]()


def test_the_encoder_rig_records_steps_of_twelve_bits():
    rig = drawn("encoder")
    assert rig.plant.encoder_step == pytest.approx(360.0 / 4096.0)
    bundle = rig_cases.draw(3 * list(rigs.RIGS).index("encoder"), "rig_healthy")
    for columns in bundle.files.values():
        counts = columns["position"] / rig.plant.encoder_step
        assert np.abs(counts - np.round(counts)).max() < 1e-6


def test_an_asynchronous_logger_samples_late_jitters_and_drops_rows(rng):
    time = np.arange(4000) / RATE_HZ
    fine = H * np.arange(1, int(4000 / RATE_HZ / H) + 10)
    repeat = rig_cases.Repeat("ramp", time, np.zeros(4000), None, np.zeros(4000))
    log = recorder.Log("asynchronous", late=0.5, jitter=0.1, dropped=0.05, jitter_is_written=False)
    columns = recorder.record(rng, log, repeat, (H, fine), 0.0, RATE_HZ)
    behind = RATE_HZ * (columns["position"] - columns["time"])  # the ramp equals time
    assert 0.03 < 1.0 - len(columns["time"]) / 4000 < 0.07
    assert np.median(behind) == pytest.approx(0.5, abs=0.02) and np.std(behind) == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize("kind", ["rig_healthy", "rig_effect"])
def test_a_seed_is_a_rig_and_three_seeds_divide_the_same_repeats(kind):
    one, again, other = rig_cases.draw(72, kind), rig_cases.draw(72, kind), rig_cases.draw(73, kind)
    assert one.truth == again.truth and one.truth["plant"] == other.truth["plant"] and one.model == other.model
    shared = one.files.keys() & other.files.keys()
    assert shared and (one.fit, one.check) != (other.fit, other.check)
    for name in one.files:
        assert all(np.array_equal(values, again.files[name][column]) for column, values in one.files[name].items())
    for name in shared:
        assert all(np.array_equal(values, other.files[name][column]) for column, values in one.files[name].items())


def test_the_effect_of_a_rig_dominates_what_a_linear_model_misses():
    """Separate fits to the measured records: with the effect the residual is far above that of structure and noise."""
    bundle = rig_cases.draw(0, "rig_effect")
    truth = bundle.truth
    assert truth["truth"] == ["rate_limit"] and truth["dominance"] > 1.0
    for name in bundle.fit:
        _, left = linear_fit.fit(*(bundle.files[name][c] for c in ("time", "command", "position")), truth["order"], truth["bandwidth_hz"])
        assert rig_cases.rms(left) > 1.5 * truth["noise_rms"]


def test_a_sensor_adds_a_sine_or_a_straight_line():
    time = 1e-3 * np.arange(2000)
    still = np.full(2000, 3.0)
    hum = rig_effects.at_sensor("chatter", {"amplitude": 0.2, "frequency": 4.0}, still, time, 0.5 * np.pi)
    assert hum[0] == pytest.approx(3.2) and hum[125] == pytest.approx(2.8) and np.std(hum) == pytest.approx(0.2 / np.sqrt(2.0), rel=1e-6)
    drifted = rig_effects.at_sensor("sensor_bias", {"offset": 0.1, "drift": 0.5}, still, time, 0.0)
    assert drifted[[0, 1000]] == pytest.approx([3.1, 3.6])


def test_a_coarse_sensor_writes_multiples_of_its_step_noise_and_all():
    bundle = rig_cases.draw(21, "rig_sensor")
    assert bundle.truth["truth"] == ["quantisation"], "the seed no longer draws this: choose another"
    step = bundle.truth["effects"]["quantisation"]["step"]
    for rows in bundle.files.values():
        assert np.abs(rows["position"] / step - np.round(rows["position"] / step)).max() < 1e-6
    assert bundle.truth["dominance"] >= rig_cases.LEAST_DOMINANCE
