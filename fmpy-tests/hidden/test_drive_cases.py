"""Cases on the eight drives: the same files for the same seed, the stated effects and no others, healthy records that the model describes."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from . import bundle, drive_cases, drive_commands, drive_effects, drive_rigs, given_model, one_effect
from .drive_dynamics import PIEZO, SPOOL
from .test_drive_sensors import PLAIN

pytestmark = pytest.mark.slow

NAMES = list(drive_rigs.RIGS)
NO_EFFECT = {
    "command_rate_limit": {"up": 1e9, "down": 1e9}, "command_dead_zone": {"half_width": 0.0}, "asymmetric_gain": {"ratio": 1.0}, "delay": {"time": 0.0},
    "gain_drift": {"rate": 0.0}, "sensor_bias": {"drift": 0.0}, "sensor_lag": {"time": 1e-9}, "quantisation": {"step": 0.0},
    "rate_limit": {"up": 1e9, "down": 1e9}, "acceleration_limit": {"value": 1e12}, "position_limit": {"min": -1e9, "max": 1e9},
    "coulomb_friction": {"acceleration": 0.0}, "backlash": {"gap": 0.0}, "amplitude_gain": {"cubic": 0.0},
    "structural_mode": {"frequency": 5.0, "damping": 0.05, "gain": 0.0},
}  # fmt: skip


def drawn(name, number=1):
    return drive_rigs.draw(np.random.default_rng([number, 41]), name)


def plainly_sensed(rig):
    return replace(rig, sensor=replace(PLAIN, rate_hz=rig.sensor.rate_hz))


def run(rig, kind="chirp", seconds=4.0):
    time = np.arange(int(seconds * rig.sensor.rate_hz)) / rig.sensor.rate_hz
    command = rig.amplitude_deg * drive_commands.command(np.random.default_rng(2), kind, time, rig.bandwidth_hz)
    return one_effect.Run(f"{kind}.csv", command, (1, 2))


@functools.cache
def case(kind, seed):
    return drive_cases.draw(seed, kind)


@pytest.mark.parametrize("kind, seed", [("drive", 14), ("drive_effect", 19)])
def test_a_seed_is_a_case_to_the_byte(kind, seed, tmp_path):
    written = []
    for folder, drawn_case in ((tmp_path / "one", case(kind, seed)), (tmp_path / "again", drive_cases.draw(seed, kind))):
        bundle.write(drawn_case, folder)
        written.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert written[0] == written[1] and {*drawn_case.fit, *drawn_case.check, "model.toml", "truth.json"} == written[0].keys()
    assert bool(drawn_case.truth["truth"]) is (kind == "drive_effect") and drawn_case.truth["rig"] == NAMES[seed % 8]


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_of_no_strength_changes_no_bit(name):
    """Except for a dead zone, which replaces that of the healthy drive, and the limits that a healthy drive has."""
    rig = plainly_sensed(drawn(name))
    rig = replace(rig, plant=rig.plant._replace(rate=1e9, lowest=-1e9, highest=1e9))
    healthy = drive_cases.measured(rig, run(rig))
    for effect in {*drive_effects.IN_ANY, *rig.effects} - {"dead_zone"}:
        columns = drive_cases.measured(rig, run(rig), effect, NO_EFFECT[effect])
        assert all(np.array_equal(columns[key], healthy[key]) for key in healthy), effect


@pytest.mark.parametrize("name", NAMES)
def test_every_effect_of_a_drive_shows_more_the_stronger_it_is(name, rng):
    rig = plainly_sensed(drawn(name))
    healthy = drive_cases.measured(rig, run(rig))["position"]
    for effect in (*drive_effects.IN_ANY, *rig.effects):
        family = drive_effects.draw(rng, effect, rig, False)
        weak, strong = (np.std(drive_cases.measured(rig, run(rig), effect, family.parameters(severity))["position"] - healthy)
                        for severity in (family.least, family.most))  # fmt: skip
        assert strong > 0.01 * rig.amplitude_deg and strong > 2.0 * weak, effect


@pytest.mark.parametrize("name", [name for name in NAMES if "rate_limit" in drive_rigs.RIGS[name][4]])
def test_a_limited_speed_is_reached_as_stated(name):
    """During a slew to a distant command: the loss to leakage and drag is stated to first order."""
    rig = plainly_sensed(drawn(name))
    plant = rig.plant._replace(coulomb=0.0, locking=0.0, cogging=0.0, ki=rig.plant.ki if name == "piezo" else 0.0, feed_forward=0.0, supply=1e9,
                               underlap=0.0, lowest=-1e9, highest=1e9, share=0.0)  # fmt: skip
    values = {"up": 2.0 * rig.amplitude_deg, "down": 2.0 * rig.amplitude_deg}
    seen = drive_rigs.move(drive_effects.in_plant("rate_limit", values, plant), np.full(20_000, 1e3 * rig.amplitude_deg), drive_rigs.STEP_S)
    assert np.diff(seen)[-5000:].mean() / drive_rigs.STEP_S == pytest.approx(drive_effects.stated("rate_limit", values, rig)["up"], rel=0.01)


@pytest.mark.parametrize("name", [name for name in NAMES if "position_limit" in drive_rigs.RIGS[name][4]])
def test_stops_are_reached_and_never_passed(name):
    rig = plainly_sensed(drawn(name))
    rig = replace(rig, plant=rig.plant._replace(share=0.0))
    values = {"min": -0.3 * rig.amplitude_deg, "max": 0.25 * rig.amplitude_deg}
    position = drive_cases.measured(rig, run(rig), "position_limit", values)["position"]
    overshoot = 0.04 * rig.amplitude_deg if rig.plant.structure == PIEZO else 1e-9  # a stage rings when its voltage saturates
    assert position.min() == pytest.approx(values["min"], abs=overshoot + 1e-9) and position.max() == pytest.approx(values["max"], abs=overshoot + 1e-9)


@pytest.mark.parametrize("name", ["cable", "pwm", "worm", "eha", "spool"])
def test_play_has_its_width(name):
    """Between motor and load, or piston and load, in slow motion up and down, with a damped load."""
    rig = plainly_sensed(drawn(name))
    h, gap = drive_rigs.STEP_S, 0.1 * rig.amplitude_deg
    time = h * np.arange(int(6.0 / h))
    command = rig.amplitude_deg * (1.0 - np.abs(1.0 - time / 3.0))
    drag = 20.0 * rig.bandwidth_hz

    def between(gap):
        plant = rig.plant._replace(drag=drag)
        held = drive_effects.in_plant("backlash", {"gap": gap}, plant) if gap else plant
        motor, load = drive_rigs.move(held, command, h, 0), drive_rigs.move(held, command, h)
        twist = motor - (drive_effects.at_output("backlash", {"gap": gap}, load, held, h) if gap else load)
        return twist[int(1.5 / h) : int(2.5 / h)].mean() - twist[int(5.0 / h) :].mean()

    assert between(gap) - between(0.0) == pytest.approx(gap, rel=0.03)


@pytest.mark.parametrize("name", ["linear", "harmonic", "cable"])
def test_a_limited_force_limits_the_acceleration_of_all_mass(name):
    rig = drawn(name)
    h = drive_rigs.STEP_S
    plant = rig.plant._replace(coulomb=0.0, cogging=0.0, drag=0.0, viscous=0.0, feed_forward=0.0)
    reference = np.repeat(run(rig).command, round(1.0 / (h * rig.sensor.rate_hz)))

    def most(limit):
        limited = drive_effects.in_plant("acceleration_limit", {"value": limit}, plant)
        motor, load = drive_rigs.move(limited, reference, h, 0), drive_rigs.move(limited, reference, h)
        return np.abs(np.diff((motor + plant.ratio * load) / (1.0 + plant.ratio), 2)).max() / h**2

    limit = 0.3 * most(1e12) * (1.0 + plant.ratio)
    stated = drive_effects.stated("acceleration_limit", {"value": limit}, plainly_sensed(rig))["value"]
    assert 0.9 * stated < most(limit) < 1.0001 * stated


def test_a_relief_valve_limits_the_pressure():
    rig = drawn("eha")
    h, limit = drive_rigs.STEP_S, 0.2 * rig.amplitude_deg * (2.0 * np.pi * rig.bandwidth_hz) ** 2
    plant = drive_effects.in_plant("acceleration_limit", {"value": limit}, rig.plant)
    reference = np.repeat(run(rig).command, round(1.0 / (h * rig.sensor.rate_hz)))
    free, relieved = (np.abs(plant.oil * drive_rigs.move(each, reference, h, 2)).max() for each in (rig.plant, plant))
    assert relieved == pytest.approx(limit) and limit < 0.5 * free


def test_a_stiffening_spring_shifts_the_load_at_rest_by_the_cube(rng):
    """Statically y + cubic y^3 = x: the coupling's spring balances the one at the load."""
    rig = drawn("cable")
    plant = rig.plant._replace(coulomb=0.0, pretension=1e9)
    cubic = 0.2 / rig.amplitude_deg**2
    plant = drive_effects.in_plant("amplitude_gain", {"cubic": cubic}, plant)
    command = np.full(40_000, rig.amplitude_deg)
    x, y = (drive_rigs.move(plant, command, drive_rigs.STEP_S, at)[-1] for at in (0, 2))
    assert y + cubic * y**3 == pytest.approx(x, rel=1e-3) and y < 0.95 * rig.amplitude_deg


def test_a_mode_of_the_sensor_rings_at_its_frequency():
    h, values = drive_rigs.STEP_S, {"frequency": 11.0, "damping": 0.02, "gain": 0.3}
    step = drive_effects.at_output("structural_mode", values, np.r_[np.zeros(10), np.ones(20_000)], drawn("piezo").plant, h)
    ringing = step - 1.0
    lines = np.abs(np.fft.rfft(ringing[10:] * np.hanning(20_000), 160_000))
    assert np.argmax(lines[20:]) + 20 == pytest.approx(11.0 * 160_000 * h, rel=0.01)
    assert step[20] == pytest.approx(1.0 - 0.3, abs=0.03) and step[-1] == pytest.approx(1.0, abs=0.01)


def test_a_dead_zone_is_the_overlap_of_a_spool():
    plant = drawn("spool").plant
    lapped = drive_effects.in_plant("dead_zone", {"half_width": 0.2}, plant)
    assert plant.structure == SPOOL and lapped.overlap == pytest.approx(0.2 * plant.kp) and lapped.underlap == 0.0


def test_what_has_no_counterpart_has_no_score(rng):
    def scored(name, rig, model_is_late=False):
        return drive_effects.draw(rng, name, rig, model_is_late).scored

    for coasts in (True, False):
        assert scored("backlash", replace(drawn("cable"), coasts=coasts)) is not coasts
    assert not scored("rate_limit", drawn("piezo")) and not scored("acceleration_limit", drawn("linear")) and scored("dead_zone", drawn("pwm"))
    assert scored("coulomb_friction", drawn("pwm")) and not scored("coulomb_friction", drawn("worm"))
    free = replace(drawn("cable"), inherent=())
    assert scored("delay", free) and not scored("delay", free, True) and not scored("delay", replace(free, inherent=("delay",)))


@pytest.mark.parametrize("kind, seed, most", [("drive", 14, given_model.MOST_MISSED), ("drive_effect", 19, given_model.MOST_OF_MOTION)])
def test_records_differ_from_the_model_as_much_as_is_stated(kind, seed, most):
    drawn_case = case(kind, seed)
    truth = drawn_case.truth
    model, sensor = given_model.Model(truth["model"], truth["order"], truth["model_delay_s"]), drive_cases.drive_sensors.Sensor(**truth["sensor"])
    shares = [given_model.left(model, drive_cases.evenly(columns, sensor)) / given_model.motion(columns) for columns in drawn_case.files.values()]
    assert 0.0 < max(shares) < most
    assert truth["enr"] > 2.0 if truth["truth"] else truth["enr"] == 0.0
    assert len(drawn_case.fit) in (2, 3) and len(drawn_case.check) in (1, 2) and not {*drawn_case.fit} & {*drawn_case.check}
