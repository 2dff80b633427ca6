"""The six rigs follow their equations, compared with textbook formulas and scipy: linear ones in time, limits, plays, friction, flow."""

import numpy as np
import pytest
from scipy import optimize, signal

from . import independent_rigs
from .independent_equations import BRUSHLESS, NEUTRAL, PNEUMATIC, RC_SERVO, SERVOVALVE, STEP_S, VOICE_COIL, march
from .independent_rigs import move

pytestmark = pytest.mark.slow

NAMES = list(independent_rigs.RIGS)
FAR_DEG = 1e4
NEARLY_LINEAR = {"servovalve": 0.15, "stepper": 0.02}  # of the motion


def drawn(name, number=1):
    return independent_rigs.draw(np.random.default_rng([number, 29]), name)


def sweep(rig, seconds=1.0):
    time = STEP_S * np.arange(int(seconds / STEP_S))
    return time, rig.amplitude_deg * signal.chirp(time, 0.2 * rig.bandwidth_hz, seconds, 1.4 * rig.bandwidth_hz, phi=-90)


def slow_triangle(size, seconds=8.0):
    time = STEP_S * np.arange(int(seconds / STEP_S))
    return time, size * signal.sawtooth(np.pi * time + 0.5 * np.pi, 0.5)


def rates(plant, state, c):
    """Derivatives of the rig as one continuous linear system."""
    x, v, y, u, *own = state
    if plant.structure == VOICE_COIL:
        (a, b), error = own, plant.gain * c - plant.feedback * x
        force = plant.coil * error - (plant.kd + 2.0 * plant.z * plant.w) * v - plant.w**2 * x
        return [v, force, 0.0, 0.0, b, plant.mode_w**2 * (x - a) - 2.0 * plant.mode_z * plant.mode_w * b]
    own_rates, error = [], c - x
    if plant.structure == RC_SERVO:
        drive = (plant.kp * error - plant.kd * v - v) / plant.motor_lag
    elif plant.structure == PNEUMATIC:
        integral, pressure = own
        drive = (pressure - v) / plant.motor_lag
        own_rates = [plant.ki * error, (plant.kp * error + integral - pressure) / plant.lag]
    elif plant.structure == SERVOVALVE:
        opening, rate, pressure = own
        drive = plant.w * pressure
        own_rates = [rate, plant.valve_w**2 * (plant.kp * error - opening) - 2.0 * plant.valve_z * plant.valve_w * rate,
                     plant.w * (opening - v) - 2.0 * plant.z * plant.w * pressure]  # fmt: skip
    elif plant.structure == BRUSHLESS:
        integral, drive = own
        missing = plant.kp * error - v
        own_rates = [plant.ki * missing, (plant.kv * missing + integral - drive) / plant.lag]
    else:
        profile, profile_2 = own
        drive = plant.w**2 * (profile - x) - 2.0 * plant.z * plant.w * v
        own_rates = [plant.filter_1 * (profile_2 - profile), plant.filter_2 * (c - profile_2)]
    r = plant.load_share
    torque = r * (1.0 - r) * (plant.coupling_w**2 * (x - y) + 2.0 * plant.coupling_z * plant.coupling_w * (v - u))
    return [v, (drive - torque) / (1.0 - r), u, torque / r - plant.load_damping * u, *own_rates]


def linear(plant):
    """The system of `rates` from the command to the sensor."""
    order = 4 + {RC_SERVO: 0, SERVOVALVE: 3}.get(int(plant.structure), 2)
    a = np.column_stack([rates(plant, row, 0.0) for row in np.eye(order)])
    b = np.array(rates(plant, np.zeros(order), 1.0))[:, None]
    c = np.zeros((1, order))
    if plant.structure == VOICE_COIL:
        c[0, [0, 4]] = 1.0 - plant.mode_gain, plant.mode_gain
        keep = [0, 1, 4, 5]
        return signal.StateSpace(a[np.ix_(keep, keep)], b[keep], c[:, keep], 0.0)
    c[0, 2] = 1.0
    return signal.StateSpace(a, b, c, 0.0)


@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_a_linear_rig_moves_as_its_state_space_does(name, number):
    """With a control period of one step, no root, no feed-forward and microsteps and a magnet that are small relative to the motion; in the limit
    of short steps, extrapolated from two step lengths."""
    rig = drawn(name, number)
    plant = rig.plant._replace(period=1.0, supply=0.0, feed_forward=0.0, poles=1e-3 / rig.amplitude_deg, microstep=1e-9 * rig.amplitude_deg, mode_gain=0.3)
    time, command = sweep(rig)
    halves = np.interp(0.5 * STEP_S * np.arange(2 * len(time)), time, command)
    moved = 2.0 * march(plant, 0.5 * STEP_S, halves)[1::2] - march(plant, STEP_S, command)
    expected = signal.lsim(linear(plant), command, time)[1]
    assert np.abs(moved[:-1] - expected[1:]).max() < 2e-5 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_at_rest_a_rig_is_where_it_was_told(name):
    rig = drawn(name)
    at_rest = move(rig.plant, np.full(int(12.0 / STEP_S), rig.amplitude_deg))[-1] / rig.amplitude_deg
    plant = rig.plant
    gain = plant.gain * plant.coil / (plant.coil * plant.feedback + plant.w**2) if name == "voice_coil" else 1.0
    assert at_rest == pytest.approx(gain, abs=2e-3)


@pytest.mark.parametrize("name", ["rc_servo", "voice_coil"])
def test_natural_frequency_and_damping_are_those_of_the_numbers(name):
    """Time and height of the peak of a step response of second order; the horn nearly rigid, the mode not measured."""
    w, z = 40.0, 0.4
    if name == "rc_servo":
        plant = NEUTRAL._replace(structure=float(RC_SERVO), kp=w * w / 20.0, kd=2.0 * z * w / 20.0 - 1.0, motor_lag=1.0 / 20.0, load_share=0.01,
                                 coupling_w=3000.0, coupling_z=0.1)  # fmt: skip
    else:
        plant = NEUTRAL._replace(structure=float(VOICE_COIL), w=0.6 * w, coil=0.64 * w * w, gain=1.0 / 0.64, feedback=1.0, kd=2.0 * z * w)
    moved = move(plant, np.ones(int(0.5 / STEP_S)))
    damped = w * np.sqrt(1.0 - z * z)
    assert STEP_S * np.argmax(moved) == pytest.approx(np.pi / damped, rel=0.01)
    assert moved.max() == pytest.approx(1.0 + np.exp(-np.pi * z * w / damped), abs=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_healthy_rigs_are_linear_but_for_what_is_stated(name):
    for number in range(6):
        rig = drawn(name, number)
        _, command = sweep(rig)
        whole, tenth = move(rig.plant, command), 10.0 * move(rig.plant, 0.1 * command)
        bent = np.abs(whole - tenth).max() / np.abs(whole).max()
        assert 1e-5 < bent < NEARLY_LINEAR[name] if rig.outside else bent < 1e-9


@pytest.mark.parametrize("name", [name for name in NAMES if name != "voice_coil"])
def test_a_limited_speed_is_reached_and_kept(name):
    """During a slew to a distant command, without damping of the load."""
    rig = drawn(name)
    limit = rig.amplitude_deg * 2.0 * np.pi * rig.bandwidth_hz
    moved = move(rig.plant._replace(rate=limit, load_damping=0.0, supply=0.0), np.full(int(3.0 / STEP_S), FAR_DEG))
    assert np.diff(moved)[-2000:].mean() / STEP_S == pytest.approx(limit, rel=2e-3)


@pytest.mark.parametrize("name", ["brushless", "rc_servo", "pneumatic"])
def test_a_limited_torque_limits_the_acceleration_of_all_mass(name):
    rig = drawn(name)
    _, command = sweep(rig)
    share = rig.plant.load_share

    def most(limit):
        plant = rig.plant._replace(acceleration=limit, load_damping=0.0)
        centre = (1.0 - share) * move(plant._replace(at_load=0.0), command) + share * move(plant, command)
        return np.abs(np.diff(centre, 2)).max() / STEP_S**2

    limit = 0.3 * most(1e9)
    assert 0.95 * limit < most(limit) < 1.0001 * limit


@pytest.mark.parametrize("name", NAMES)
def test_stops_are_reached_and_never_passed(name):
    rig = drawn(name)
    lowest, highest = -0.5 * rig.amplitude_deg, 0.4 * rig.amplitude_deg
    moved = move(rig.plant._replace(lowest=lowest, highest=highest, mode_gain=0.0), sweep(rig)[1])
    assert moved.min() == lowest and moved.max() == highest


@pytest.mark.parametrize("name", [name for name in NAMES if name != "voice_coil"])
def test_play_has_its_width(name):
    """Between drive and load in motion up and down, beyond the twist of the shaft; a damped load stays in contact."""
    rig = drawn(name)
    time, command = slow_triangle(rig.amplitude_deg)
    gap = 0.1 * rig.amplitude_deg

    def between(gap):
        plant = rig.plant._replace(gap=gap, load_damping=20.0 * rig.bandwidth_hz)
        twist = move(plant._replace(at_load=0.0), command) - move(plant, command)
        late, rising = (time % 1.0 > 0.7) & (time > 2.0), time % 2.0 > 1.0
        return np.median(twist[late & rising]) - np.median(twist[late & ~rising])

    assert abs(between(gap) - between(0.0)) == pytest.approx(gap, rel=0.01)


def test_friction_holds_a_force_up_to_its_level():
    plant = drawn("voice_coil").plant._replace(coulomb=500.0, mode_gain=0.0)
    held = 500.0 / (plant.coil * plant.gain)
    for size, moves in ((0.99, False), (1.01, True)):
        assert bool(move(plant, np.full(4000, size * held)).any()) is moves


def test_flow_falls_with_the_root_of_the_pressure():
    """A piston at a constant opening o against a damped load: v = o sqrt(1 - P/supply) - 2 z P and w P = r d v."""
    plant = drawn("servovalve").plant._replace(rate=10.0, load_damping=60.0, load_share=0.2, supply=1.0)
    moved = move(plant, np.full(int(3.0 / STEP_S), FAR_DEG))
    brake = plant.load_share * plant.load_damping / plant.w  # pressure over speed

    def missing(v):
        return 10.0 * np.sqrt(max(1.0 - brake * v, 0.0)) - 2.0 * plant.z * brake * v - v

    expected = optimize.brentq(missing, 0.0, 10.0)
    assert expected < 9.0
    assert np.diff(moved)[-2000:].mean() / STEP_S == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_an_error_within_the_dead_zone_moves_nothing(name):
    """Without terms in the command other than the error, and with a spool that does not overshoot."""
    rig = drawn(name)
    half_width = 0.1 * rig.amplitude_deg
    plant = rig.plant._replace(half_width=half_width, gain=1.0, feed_forward=0.0, ki=0.0, valve_z=1.0)
    for size, moves in ((0.99, False), (1.1, True)):
        assert bool(move(plant, np.full(4000, size * half_width)).any()) is moves
