"""Cases on the six rigs: the same files for the same seed, the stated effects and no others, sensors and loggers that behave as named."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from . import bundle, given_model, independent_cases, independent_commands, independent_effects, independent_rigs, independent_sensors, linear_fit, one_effect
from .independent_equations import NEUTRAL, STEP_S
from .independent_sensors import Sensor

pytestmark = pytest.mark.slow

NAMES = list(independent_rigs.RIGS)
RATE_HZ = 200
PLAIN = Sensor(RATE_HZ, 0.0, "white", 0.0, 0.0, 1.0, 0.0, 0.0, 0, 0, 0.0, 0.0, 9)
NO_EFFECT = {
    "command_limit": {"min": -1e9, "max": 1e9}, "command_rate_limit": {"up": 1e9, "down": 1e9}, "command_dead_zone": {"half_width": 0.0},
    "command_backlash": {"gap": 0.0}, "asymmetric_gain": {"ratio": 1.0}, "delay": {"time": 0.0}, "gain_drift": {"rate": 0.0},
    "rate_limit": {"up": 1e9, "down": 1e9}, "acceleration_limit": {"value": 1e9}, "position_limit": {"min": -1e9, "max": 1e9},
    "dead_zone": {"half_width": 0.0}, "coulomb_friction": {"acceleration": 0.0}, "backlash": {"gap": 0.0}, "amplitude_gain": {"cubic": 0.0},
}  # fmt: skip


def drawn(name, number=1):
    return independent_rigs.draw(np.random.default_rng([number, 31]), name)


def run(rig, kind="chirp", seconds=3.0):
    time = np.arange(int(seconds * rig.sensor.rate_hz)) / rig.sensor.rate_hz
    command = rig.amplitude_deg * independent_commands.command(np.random.default_rng(2), kind, time, rig.bandwidth_hz)
    return one_effect.Run(f"{kind}.csv", command, (1, 2))


@functools.cache
def case(kind, seed):
    return independent_cases.draw(seed, kind)


@pytest.mark.parametrize("kind, seed", [("independent", 16), ("independent_effect", 10)])
def test_a_seed_is_a_case_to_the_byte(kind, seed, tmp_path):
    written = []
    for folder, drawn_case in ((tmp_path / "one", case(kind, seed)), (tmp_path / "again", independent_cases.draw(seed, kind))):
        bundle.write(drawn_case, folder)
        written.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert written[0] == written[1] and {*drawn_case.fit, *drawn_case.check, "model.toml", "truth.json"} == written[0].keys()
    assert bool(drawn_case.truth["truth"]) is (kind == "independent_effect") and drawn_case.truth["rig"] == NAMES[seed % 6]


def test_another_seed_is_another_case():
    one, other = case("independent", 16), case("independent", 10)
    assert one.truth["rig"] == other.truth["rig"] and one.truth["plant"] != other.truth["plant"] and one.model != other.model


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_of_no_strength_changes_no_bit(name):
    rig = drawn(name)
    effects = {*independent_effects.IN_ANY_RIG, *rig.effects}
    healthy = independent_cases.measured(rig, run(rig))
    for effect in effects:
        columns = independent_cases.measured(rig, run(rig), effect, NO_EFFECT[effect])
        assert all(np.array_equal(columns[key], healthy[key]) for key in healthy), effect


@pytest.mark.parametrize("name", NAMES)
def test_every_effect_of_a_rig_shows_more_the_stronger_it_is(name, rng):
    rig = drawn(name)
    rig = replace(rig, sensor=replace(PLAIN, rate_hz=rig.sensor.rate_hz))
    healthy = independent_cases.measured(rig, run(rig))["position"]
    for effect in (*independent_effects.IN_ANY_RIG, *rig.effects):
        family = independent_effects.draw(rng, effect, rig, False)
        weak, strong = (np.std(independent_cases.measured(rig, run(rig), effect, family.parameters(severity))["position"] - healthy)
                        for severity in (family.least, family.most))  # fmt: skip
        assert strong > 0.003 * rig.amplitude_deg and strong > 2.0 * weak, effect


def test_records_differ_from_the_model_as_much_as_is_stated():
    for kind, seed, most in (("independent", 16, given_model.MOST_MISSED), ("independent_effect", 10, given_model.MOST_OF_MOTION)):
        drawn_case = case(kind, seed)
        truth = drawn_case.truth
        model = given_model.Model(truth["model"], truth["order"], truth["model_delay_s"])
        shares = [given_model.left(model, columns) / given_model.motion(columns) for columns in drawn_case.files.values()]
        assert 0.0 < max(shares) < most and truth["enr"] == 0.0 if kind == "independent" else truth["enr"] > 2.0
        assert len(drawn_case.fit) in (2, 3) and len(drawn_case.check) in (1, 2) and not {*drawn_case.fit} & {*drawn_case.check}


def test_strengths_are_those_that_the_sensor_shows():
    rig = drawn("rc_servo")
    rig = replace(rig, sensor=replace(rig.sensor, gain=1.02, offset=0.3))
    limits = independent_effects.stated("position_limit", {"min": -2.0, "max": 3.0}, rig)
    assert limits == pytest.approx({"min": -1.74, "max": 3.36})
    assert independent_effects.stated("backlash", {"gap": 0.5}, rig) == pytest.approx({"gap": 0.51})
    plant = rig.plant
    level = independent_effects.stated("coulomb_friction", {"acceleration": 100.0}, rig)["level"]
    assert plant.kp / plant.motor_lag * level == pytest.approx(100.0)


def test_what_has_no_counterpart_has_no_score(rng):
    rig = drawn("servovalve")
    for coasts in (True, False):
        assert independent_effects.draw(rng, "backlash", replace(rig, coasts=coasts), False).scored is not coasts
    assert not independent_effects.draw(rng, "acceleration_limit", rig, False).scored
    for outside in ((), ("square_root_flow",)):
        assert independent_effects.draw(rng, "rate_limit", replace(rig, outside=outside), False).scored is (outside == ())
    for latency_s, model_is_late in ((0.0, False), (0.0, True), (0.001, False)):
        late = replace(rig, latency_s=latency_s, sensor=PLAIN)
        assert independent_effects.draw(rng, "delay", late, model_is_late).scored is (not latency_s and not model_is_late)


def test_a_model_finds_the_delay_of_its_record():
    """A servo of the structure of the model, behind 3.3 samples."""
    rig = replace(drawn("rc_servo"), bandwidth_hz=5.0, sensor=PLAIN)
    columns = {"time": np.arange(2000) / RATE_HZ, "command": run(replace(rig, amplitude_deg=1.0), "mixed", 10.0).command}
    servo = (1.0, 0.0, 31.0, 0.7)
    columns["position"] = linear_fit.respond(servo, 2, given_model.late(columns["command"], 3.3), 1.0 / RATE_HZ)
    for order, is_late in ((2, True), (3, False)):
        model = given_model.fitted(columns, order, is_late, rig.bandwidth_hz, RATE_HZ)
        assert model.order == order and bool(model.delay_s) is is_late
        if is_late:
            assert model.delay_s * RATE_HZ == pytest.approx(3.3, abs=0.1) and model.base[2:] == pytest.approx(servo[2:], rel=0.01)


@pytest.mark.parametrize("kind", independent_commands.COMMANDS)
def test_commands_begin_at_rest_and_keep_to_size_one(kind, rng):
    for rate, bandwidth in ((100, 2.5), (1000, 30.0)):
        wave = independent_commands.command(rng, kind, np.arange(10 * rate) / rate, bandwidth)
        assert wave[0] == 0.0 and 0.5 < np.abs(wave).max() <= 1.0 + 1e-9


def sensed(rng, seen, **changes):
    sensor = replace(PLAIN, **changes)
    command = np.arange(len(seen) * STEP_S * RATE_HZ)
    return independent_sensors.record(rng, sensor, command, seen)


def ramp(seconds=10.0):
    return STEP_S * np.arange(int(round(seconds / STEP_S)))


def test_a_filter_is_late_by_the_same_at_all_slow_motions(rng):
    """Bessel: its delay is 2.114 over its corner, from the table of group delays for order 4 and a corner at -3 dB."""
    for corner in (20.0, 50.0):
        columns = sensed(rng, ramp(), bessel_hz=corner)
        late = columns["time"] - columns["position"]
        assert late[-500:] == pytest.approx(2.114 / (2.0 * np.pi * corner), rel=5e-3)


def test_a_clock_jitters_as_written_and_begins_at_any_time(rng):
    columns = sensed(rng, ramp(), jitter=0.05, start_s=4000.25)
    off = RATE_HZ * (columns["time"] - 4000.25) - np.arange(2000)
    assert off.std() == pytest.approx(0.05, rel=0.1) and np.abs(off).max() <= 0.21
    assert columns["position"] == pytest.approx(columns["time"] - 4000.25, abs=1e-6)


def test_a_quantiser_rounds_and_gain_offset_and_drift_are_ahead_of_it(rng):
    step = 0.03
    columns = independent_sensors.record(rng, replace(PLAIN, step=step, gain=1.02, offset=-0.4), np.zeros(2000), ramp(), gain_drift=-0.01)
    counts = columns["position"] / step
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    expected = 1.02 * columns["time"] * (1.0 - 0.01 * columns["time"]) - 0.4
    assert np.abs(columns["position"] - expected).max() <= 0.5 * step + 1e-6


def test_noise_has_its_size_and_colour(rng):
    """For a low-pass (1 + 1/q)/(1 - a/q) the correlation at a lag of one sample is (1 + a)/2; a = tan(pi/8) for a quarter of the Nyquist frequency."""
    for colour, correlation in (("white", 0.0), ("coloured", 0.5 + 0.5 * np.tan(np.pi / 8.0))):
        noise = sensed(rng, np.zeros(len(ramp())), noise_rms=0.02, colour=colour)["position"]
        assert noise.std() == pytest.approx(0.02, rel=0.1) and np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(correlation, abs=0.1)


@pytest.mark.parametrize("late, first", [(0, [0.0, 1.0]), (1, [0.0, 0.0]), (-1, [1.0, 2.0])])
def test_a_command_is_logged_when_it_is_said_to(late, first, rng):
    assert list(sensed(rng, ramp(), logged_late=late)["command"][:2]) == first


def test_what_a_sensor_has_is_inherent():
    assert independent_sensors.inherent(PLAIN) == ()
    spoilt = replace(PLAIN, step=0.1, offset_spread=0.1, bessel_hz=50.0, late_samples=1)
    assert set(independent_sensors.inherent(spoilt)) == {"quantisation", "sensor_bias", "sensor_lag", "delay"}
    assert independent_sensors.inherent(replace(PLAIN, late_samples=1)) == ("delay",)
    assert independent_sensors.inherent(replace(PLAIN, late_samples=1, logged_late=1)) == ()
    assert NEUTRAL.gap == NEUTRAL.coulomb == NEUTRAL.half_width == 0.0
