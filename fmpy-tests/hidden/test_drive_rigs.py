"""The eight drives follow their equations: compared with transfer functions and an adaptive solver for the same physics; limits, plays, friction
and hysteresis are measured in the motion."""

import numpy as np
import pytest
from scipy import integrate, signal

from . import drive_rigs
from .drive_dynamics import CABLE, EHA, LINEAR, NEUTRAL, PIEZO, PWM, SPOOL, WORM, dahl, friction_level
from .drive_reference import STATES, controller, rates
from .drive_rigs import STEP_S, move

pytestmark = pytest.mark.slow

NAMES = list(drive_rigs.RIGS)
TWO_MASSES = ("harmonic", "cable", "pwm", "worm")
FAR = 300.0  # amplitudes
SMOOTH = {"coulomb": 0.0, "stribeck": 0.0, "locking": 0.0, "half_width": 0.0, "rate": 1e9}
LINEARISED = SMOOTH | {"overlap": 0.0, "underlap": 0.0, "supply": 1e9, "share": 0.0, "cogging": 0.0, "kinematic": 0.0, "pretension": 1e9, "ki": 0.0,
                       "feed_forward": 0.0, "kd": 0.0, "period": 1.0, "lowest": -1e9, "highest": 1e9}  # fmt: skip


def drawn(name, number=1):
    return drive_rigs.draw(np.random.default_rng([number, 37]), name)


def linearised(rig):
    plant = rig.plant._replace(**LINEARISED)
    return plant._replace(ki=rig.plant.ki) if plant.structure == PIEZO else plant


def transfer(plant, s):
    """From the reference to the sensor: the loop closed explicitly, mobilities of the masses, a delay of half a control period."""
    held = np.exp(-0.5 * s * STEP_S)
    if plant.structure in (EHA, SPOOL):
        power = 1.0 / (1.0 + plant.lag * s) if plant.structure == EHA else 1.0 / (1.0 + 2.0 * plant.valve_zeta * s / plant.valve + (s / plant.valve) ** 2)
        path = held * plant.kp * power * plant.oil**2 / ((s + plant.viscous) * (s + plant.leak) + plant.oil**2) / s
        return path / (1.0 + path)
    if plant.structure == PIEZO:
        path = held * plant.ki / s / (1.0 + plant.lag * s) / (1.0 + 2.0 * plant.zeta * s / plant.resonance + (s / plant.resonance) ** 2)
        return path / held / (1.0 + path / held)  # a sum leads by the half period by which the hold lags
    spring = plant.shaft**2 / s + 2.0 * plant.zeta * plant.shaft
    reflected, follows = 0.0, 1.0
    if plant.structure != LINEAR:
        follows = spring / (s + plant.drag + spring)
        reflected = plant.ratio * (s + plant.drag) * follows
    if plant.structure in (PWM, WORM):
        speed = held / plant.lag / (s + 1.0 / plant.lag + reflected)
        path = plant.kp * speed / s
        return path / (1.0 + path) * follows
    force = held * plant.kv / (1.0 + plant.lag * s) / (s + plant.viscous + reflected)
    # The speed from differences of the position lags by half a period.
    measured = np.exp(-0.5 * s * STEP_S) if plant.structure == CABLE else 1.0
    path = plant.kp * force / (1.0 + measured * force) / s
    return path / (1.0 + path) * follows


@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_small_motions_have_the_transfer_function_of_the_loop(name, number):
    rig = drawn(name, number)
    plant = linearised(rig)
    for share in (0.3, 1.2):
        cycles = 1.0 / round(1.0 / (share * rig.bandwidth_hz * STEP_S))  # per step
        count = round(1.0 / cycles)
        wave = np.exp(2j * np.pi * cycles * np.arange(12 * count))
        seen = move(plant, wave.imag, STEP_S)
        # Over the last two periods, at the ends of the steps.
        found = 2j * np.mean(seen[-2 * count :] * np.conj(wave[-2 * count :] * np.exp(2j * np.pi * cycles)))
        assert found == pytest.approx(transfer(plant, 2j * np.pi * cycles / STEP_S), abs=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_smooth_motions_are_those_of_an_adaptive_solver(name):
    """All effects that are smooth between the controller's instants: square roots, cogging, hysteresis, kinematic error."""
    rig = drawn(name, 3)
    plant = rig.plant._replace(**SMOOTH, overlap=0.0, underlap=0.0, pretension=1e9)
    time = STEP_S * np.arange(int(0.25 / STEP_S))
    reference = rig.amplitude_deg * signal.chirp(time, 0.5 * rig.bandwidth_hz, time[-1], 1.4 * rig.bandwidth_hz, phi=-90)
    state, at = np.zeros(STATES[int(plant.structure)]), 2 if name in TWO_MASSES else 0
    expected, period = [], int(plant.period)
    demand = controller(plant, reference[0], period * STEP_S)
    for start in range(0, len(time), period):
        ends = STEP_S * np.arange(1, min(period, len(time) - start) + 1)
        u = demand(reference[start], *state[:2])
        solved = integrate.solve_ivp(rates, (0.0, ends[-1]), state, args=(plant, u), t_eval=ends, rtol=1e-8, atol=1e-10 * rig.amplitude_deg)
        state = solved.y[:, -1]
        expected.extend(solved.y[at])
    moved = move(plant, reference, STEP_S)
    assert np.abs(moved - expected).max() < 2e-4 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_steps_of_half_the_length_change_little(name):
    """The complete healthy drive, including friction, to about a tenth of the lowest noise."""
    for number in range(3):
        rig = drawn(name, number)
        time = STEP_S * np.arange(int(3.0 / STEP_S))
        reference = rig.amplitude_deg * signal.chirp(time, 0.2 * rig.bandwidth_hz, 3.0, 1.4 * rig.bandwidth_hz, phi=-90)
        coarse, fine = move(rig.plant, reference, STEP_S), move(rig.plant, np.repeat(reference, 2), 0.5 * STEP_S)[1::2]
        assert np.std(coarse - fine) < 1e-3 * np.std(fine)


@pytest.mark.parametrize("name", NAMES)
def test_without_friction_a_drive_comes_to_rest_at_its_command(name):
    rig = drawn(name)
    plant = rig.plant._replace(**SMOOTH, overlap=0.0, cogging=0.0, kinematic=0.0)
    plant = plant._replace(ki=0.0) if plant.structure == EHA else plant  # its integrator overshoots and recovers slowly
    assert move(plant, np.full(int(8.0 / STEP_S), rig.amplitude_deg), STEP_S)[-1] == pytest.approx(rig.amplitude_deg, rel=1e-3)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "piezo"])
def test_friction_holds_up_to_its_level_and_what_sticks_does_not_creep(name):
    """Controllers without integrator or feed-forward; force at rest over error: kp kv, kp/lag, or the static pressure of a leaking cylinder.
    A sticking drive does not move at all, except for a load within steps."""
    rig = drawn(name)
    plant = rig.plant._replace(stribeck=0.0, half_width=0.0, overlap=0.0, underlap=0.0, ki=0.0, feed_forward=0.0, cogging=0.0, kinematic=0.0, rate=1e9,
                               supply=1e9, valve_zeta=1.0)  # fmt: skip
    if name in ("eha", "spool"):
        spring = plant.kp * plant.oil**2 / plant.leak
    else:
        spring = plant.kp / plant.lag if name in ("pwm", "worm") else plant.kp * plant.kv
    for size, moves in ((0.99, False), (1.02, True)):
        moved = move(plant._replace(coulomb=rig.amplitude_deg * spring), np.full(20_000, size * rig.amplitude_deg), STEP_S) / rig.amplitude_deg
        assert moved[-1] > 5e-3 if moves else np.abs(moved).max() < (1e-5 if name in TWO_MASSES else 1e-300)


def test_a_worm_cannot_be_driven_by_its_wheel():
    for number in range(5):
        plant = drawn("worm", number).plant
        for twist in (-0.3, 0.2):
            torque = plant.ratio * plant.shaft**2 * abs(twist)
            assert friction_level(plant, np.array([twist, 0.0, 0.0, 0.0])) > torque


@pytest.mark.parametrize("name", [name for name in NAMES if name != "piezo"])
def test_friction_near_rest_is_larger_by_the_share_of_stribeck(name):
    plant = NEUTRAL._replace(structure=float(EHA), coulomb=3.0, stribeck=0.4, stribeck_speed=2.0)
    assert friction_level(plant, np.zeros(4)) == pytest.approx(4.2) and friction_level(plant, np.array([0.0, 20.0, 0.0, 0.0])) == pytest.approx(3.0)


def test_hysteresis_is_bounded_and_its_branches_meet():
    """Dahl: saturated at its reach; the same for a monotonic change in one step or in many."""
    plant = NEUTRAL._replace(reach=0.5)
    assert dahl(plant, 0.0, 20.0) == pytest.approx(0.5) and dahl(plant, 0.5, -20.0) == pytest.approx(-0.5)
    once, many = dahl(plant, 0.1, 0.4), 0.1
    for _ in range(100):
        many = dahl(plant, many, 0.004)
    assert many == pytest.approx(once, rel=1e-9)


def ripple_cycles(plant, speed, at=None):
    """Per degree, of the strongest line in the deviation from a steady slow motion."""
    time = STEP_S * np.arange(int(10.0 / STEP_S))
    late = slice(len(time) // 5, None)
    deviation = signal.detrend(move(plant, speed * time, STEP_S, at)[late])
    lines = np.abs(np.fft.rfft(deviation * np.hanning(len(deviation)), 8 * len(deviation)))
    return np.argmax(lines) / (8 * len(deviation) * STEP_S) / speed


def test_the_kinematic_error_comes_twice_per_turn_of_the_input():
    plant = drawn("harmonic").plant._replace(coulomb=0.0)
    gear_ratio = plant.kinematic_per_deg / (2.0 * np.pi) * 360.0 / 2.0
    assert gear_ratio == pytest.approx(round(gear_ratio))
    assert ripple_cycles(plant, 3.0) == pytest.approx(2.0 * gear_ratio / 360.0, rel=0.02)


def test_cogging_comes_once_per_pitch():
    plant = drawn("linear").plant._replace(coulomb=0.0)
    assert ripple_cycles(plant, plant.pitch) == pytest.approx(1.0 / plant.pitch, rel=0.02)


@pytest.mark.parametrize("over", [True, False])
def test_a_lap_stops_small_openings_or_doubles_their_flow(over):
    """Speed of a piston whose spool is opened within its lap, the leakage aside."""
    plant = drawn("spool").plant._replace(**SMOOTH, overlap=0.0, underlap=0.0, leak=0.0, supply=1e9, kp=1.0)
    command = np.full(int(0.5 / STEP_S), 0.001)
    lapped = plant._replace(**{"overlap" if over else "underlap": 0.01})
    once, other = (np.gradient(move(each, command, STEP_S))[-1000:].mean() for each in (plant, lapped))
    assert other / once == pytest.approx(0.0 if over else 2.0, abs=0.01 if over else 1.3)


def test_a_bus_is_late_by_a_cycle_in_straight_lines_and_pulses_stay_for_a_frame():
    time = STEP_S * np.arange(5000)
    bus = drive_rigs.set_points(drawn("linear"), 10.0 * time, STEP_S, 0.3)
    late = (10.0 * time - bus)[1000:]
    assert late == pytest.approx(10.0 * drawn("linear").bus_s, rel=0.01)
    pulses = drive_rigs.set_points(drawn("pwm"), 10.0 * time, STEP_S, 0.3)
    edges = np.flatnonzero(np.diff(pulses))
    assert set(np.diff(edges)) == {round(drive_rigs.FRAME_S / STEP_S)}
    assert pulses / 0.09 == pytest.approx(np.round(pulses / 0.09), abs=1e-9) and np.abs(pulses - 10.0 * time).max() < 10.0 * drive_rigs.FRAME_S + 0.05
