"""The nonlinear part of the reference against closed forms: each effect where a closed form is known."""

import numpy as np
import pytest
from scipy import special

from . import command_side
from .closed_forms import EXACT, UNDAMPED, W, base_responses, close, constant, grid
from .plant import NEUTRAL, quantise, simulate

pytestmark = pytest.mark.slow


# -- limits -------------------------------------------------------------------------------------------------------


def test_acceleration_limit_is_a_parabola_until_the_error_is_small():
    time, a = grid(0.04, 0.001), 2e5
    found = simulate(UNDAMPED, {"acceleration_limit": {"value": a}}, time, constant(20.0, time), order=2)
    leaves = np.sqrt(2.0 * (20.0 - a / W**2) / a)
    error, rate = a / W**2, a * leaves
    swing = 20.0 - error * np.cos(W * (time - leaves)) + rate / W * np.sin(W * (time - leaves))
    passes = leaves + 2.0 * np.arctan2(error, rate / W) / W  # the error is a / omega^2 on the other side
    now = time < passes
    assert close(found["position"][now], np.where(time < leaves, 0.5 * a * time**2, swing)[now])
    assert np.array_equal(found["saturated"][1:][now[1:]], (time < leaves)[1:][now[1:]])


def test_rate_limit_is_an_exact_ramp_and_asymmetric():
    time = grid(0.3, 0.001)
    command = np.where(time < 0.1499, 10.0, -10.0)
    base, limits = (1, 1.0, W, 0.0), {"rate_limit": {"up": 100.0, "down": 60.0}}
    found = simulate(base, limits, time, command, order=2)
    begins = np.arcsin(100.0 / (10.0 * W)) / W
    start = 10.0 * (1.0 - np.cos(W * begins))
    ramp = (time > begins) & (time < begins + (10.0 - start) / 100.0)
    assert close(found["position"][ramp], start + 100.0 * (time[ramp] - begins))
    assert np.all(found["rate"][ramp] == 100.0) and np.all(found["saturated"][ramp])
    assert found["rate"].min() == -60.0 and not found["saturated"][time < begins].any()
    # The ramp ends where the error vanishes; then the undamped loop swings about the command, until down takes over.
    ends = begins + (10.0 - start) / 100.0
    swing = (time > ends) & (time < min(0.1499, ends + np.arccos(-0.6) / W))
    assert close(found["position"][swing], 10.0 + 100.0 / W * np.sin(W * (time[swing] - ends)))


def test_stop_without_rebound_and_release_at_once():
    time = grid(0.2, 0.001)
    command = np.where(time < 0.0999, 3.0, 1.0)
    stop = {"position_limit": {"min": -1.0, "max": 4.0}}
    found = simulate(UNDAMPED, stop, time, command, order=2)
    reaches = np.arccos(1.0 - 4.0 / 3.0) / W
    free, swing = time < reaches, (time > reaches) & (time < 0.0999)
    assert close(found["position"][free], 3.0 * (1.0 - np.cos(W * time[free])))
    # The spring pulls away from the stop at once, since the command is below it: a swing of amplitude 1.
    assert close(found["position"][swing], 3.0 + np.cos(W * (time[swing] - reaches)))
    assert found["position"].max() <= 4.0


@pytest.mark.parametrize("level", [0.0, 0.4])
def test_stop_holds_until_the_force_overcomes_friction(level):
    time = grid(0.3, 0.001)
    command = np.interp(time, [0.0, 0.05, 0.3], [8.0, 8.0, 2.0])
    effects = {"position_limit": {"max": 4.0}, "coulomb_friction": {"level": level}}
    found = simulate((1, 1.0, W, 0.7), effects, time, command, order=2, hold=False)
    leaves = 0.05 + (8.0 - (4.0 - level)) / 24.0
    on_stop = (time > 0.05) & (time <= leaves)
    assert np.all(found["position"][on_stop] == 4.0) and np.all(found["rate"][on_stop] == 0.0)
    assert np.all(found["saturated"][on_stop]) and not found["saturated"][time > leaves].any()
    step, ramp = base_responses(1.0, W, 0.7, 2)
    assert close(found["position"][time > leaves], 4.0 - 24.0 * ramp(time[time > leaves] - leaves))


def test_a_stop_reached_exactly_at_a_sample_is_one_event():
    quarter = 0.5 * np.pi / W
    time = np.arange(9) * quarter
    found = simulate(UNDAMPED, {"position_limit": {"max": 3.0}}, time, constant(3.0, time), order=2)
    assert close(found["position"][1:], constant(3.0, time[1:]))


# -- friction -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", [0.15, 0.5, 0.93])
@pytest.mark.parametrize("zeta", [0.0, 0.1])
def test_stick_slip_stops_where_the_closed_form_says(level, zeta):
    """Free swing from d0: each half swing is about +-level with ratio r = exp(-zeta pi / sqrt(1 - zeta^2)):
    the next turning point is -(|d| - level) r + level on the other side; it sticks once |d| <= level."""
    time, d0 = grid(0.5, 0.001), 4.0
    r = np.exp(-zeta * np.pi / np.sqrt(1.0 - zeta**2))
    turn, side = d0, 1.0
    while turn > level:
        turn, side = (turn - level) * r - level, -side
    found = simulate((1, 1.0, W, zeta), {"coulomb_friction": {"level": level}}, time, constant(0.0, time),
                     order=2, initial_position=d0)
    assert abs(found["position"][-1] - side * turn) < EXACT * d0
    assert found["rate"][-1] == 0.0
    if zeta == 0.0:
        first = time < np.pi / W
        assert close(found["position"][first], level + (d0 - level) * np.cos(W * time[first]))


def test_friction_holds_until_the_command_is_a_level_away():
    time, slope, level = grid(0.5, 0.001), 5.0, 0.6
    found = simulate((1, 1.0, W, 0.8), {"coulomb_friction": {"level": level}}, time, slope * time, order=2, hold=False)
    _, ramp = base_responses(1.0, W, 0.8, 2)
    assert close(found["position"], slope * ramp(time - level / slope))
    assert np.all(found["rate"][time < level / slope - 1e-12] == 0.0)


@pytest.mark.parametrize("cubic, stiffness", [(0.0, 0.0), (0.05, 0.3)])
def test_energy_never_appears_with_friction_and_stays_without(cubic, stiffness):
    time = grid(0.3, 0.0005)
    effects = {"amplitude_gain": {"cubic": cubic}, "hinge_load": {"stiffness": stiffness}}
    for level in (0.0, 0.05):
        effects["coulomb_friction"] = {"level": level}
        found = simulate(UNDAMPED, effects, time, constant(0.0, time), order=2, initial_position=5.0)
        d, v = found["drive"], found["rate"]
        energy = 0.5 * v**2 + W**2 * (0.5 * (1.0 + stiffness) * d**2 + 0.25 * cubic * d**4)
        if level == 0.0:
            assert close(energy, constant(energy[0], time), 1e-10)
        else:
            work = np.diff(energy)
            assert work.max() <= 1e-10 * energy[0] and energy[-1] < 0.9 * energy[0]


# -- dead zone, cubic, play, asymmetry ----------------------------------------------------------------------------


def test_dead_zone_coasts_between_half_swings():
    """From d0 > w without damping: quarter swing about w, coasting over 2 w at omega (d0 - w), half swing about -w."""
    w, d0, time = 0.5, 3.0, grid(0.2, 0.0007)
    found = simulate(UNDAMPED, {"dead_zone": {"half_width": w}}, time, constant(0.0, time), order=2,
                     initial_position=d0)
    size, quarter, coast = d0 - w, 0.5 * np.pi / W, 2.0 * w / (W * (d0 - w))
    half = 2.0 * quarter + coast
    phase, sign = time % half, 1.0 - 2.0 * (time // half % 2)
    expected = np.where(phase < quarter, w + size * np.cos(W * phase),
                        np.where(phase < quarter + coast, w - W * size * (phase - quarter),
                                 -w - size * np.sin(W * (phase - quarter - coast))))
    assert close(found["position"], sign * expected)


def test_cubic_is_a_jacobi_cosine():
    """d'' = -omega^2 (d + cubic d^3): d = A cn(Omega t | m), Omega^2 = omega^2 (1 + cubic A^2),
    m = cubic A^2 omega^2 / (2 Omega^2).    Duffing; Abramowitz & Stegun 16.16"""
    time, size, cubic = grid(0.4, 0.005), 3.0, 0.08
    fast = W * np.sqrt(1.0 + cubic * size**2)
    expected = size * special.ellipj(fast * time, cubic * size**2 * W**2 / (2.0 * fast**2))[1]
    found = simulate(UNDAMPED, {"amplitude_gain": {"cubic": cubic}}, time, constant(0.0, time), order=2,
                     initial_position=size)
    assert close(found["position"], expected, 1e-10)


def test_output_play_on_a_swing():
    """d = c (1 - cos omega t) from rest: y leaves at d = gap/2, stops at 2 c - gap/2, returns at gap/2."""
    time, c, half = grid(0.3, 0.001), 4.0, 0.35
    found = simulate(UNDAMPED, {"backlash": {"gap": 2.0 * half}}, time, constant(c, time), order=2)
    d = c * (1.0 - np.cos(W * time))
    rising = np.sin(W * time) >= 0.0
    lowest = np.where(time < np.pi / W, 0.0, half)
    y = np.where(rising, np.maximum(d - half, lowest), np.minimum(d + half, 2.0 * c - half))
    assert close(found["drive"], d) and close(found["deflection"], y)


def test_output_play_does_not_move_while_friction_holds_inside_it():
    time = grid(0.6, 0.005)
    effects = {"backlash": {"gap": 0.5}, "coulomb_friction": {"level": 0.3}, "structural_mode": {"gain": 0.5}}
    found = simulate((1, 7e3, W, 0.7), effects, time, 0.29 * np.sin(20.0 * time))
    assert np.all(found["position"] == 0.0) and np.all(found["rate"] == 0.0)


def naive(operator, command, time, count=20_000):
    """A command-side operator by tiny steps, on the held or linear command of the signal."""
    fine = np.linspace(0.0, time[-1], count * (len(time) - 1) + 1)
    state, out = command(fine[0]), []
    for c in command(fine):
        state = operator(state, c, fine[1])
        out.append(state)
    return fine[::count], np.array(out)[::count]


@pytest.mark.parametrize("name", ["play", "rate_limit"])
def test_command_operators_with_memory_by_tiny_steps(name):
    time = np.arange(12) * 0.1
    samples = np.r_[0.0, np.random.default_rng(9).uniform(-2.0, 2.0, 11)]
    source = command_side.sampled(time, samples, False, 0.0, time[-1] + 0.1)
    exact, step = {
        "play": (command_side.play(source, 0.7), lambda r, c, dt: min(max(r, c - 0.35), c + 0.35)),
        "rate_limit": (command_side.rate_limit(source, 12.0, 7.0),
                       lambda r, c, dt: r + min(max(c - r, -7.0 * dt), 12.0 * dt)),
    }[name]
    at, expected = naive(step, lambda t: np.interp(t, time, samples), time, 2000)
    i = np.searchsorted(exact.start, at, side="right") - 1
    assert close(exact.value[i] + exact.slope[i] * (at - exact.start[i]), expected, 1e-3)


def test_command_rate_limit_turns_a_jump_into_a_ramp():
    time = grid(0.3)
    found = simulate((1, 4e4, W, 0.6), {"command_rate_limit": {"up": 40.0, "down": 1e9}}, time,
                     np.where(time < 0.1999, 5.0, -1.0))
    step, ramp = base_responses(4e4, W, 0.6)
    assert close(found["position"], 40.0 * (ramp(time) - ramp(time - 0.125)) - 6.0 * step(time - 0.2))


def test_static_command_operators_on_a_triangle():
    time = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    samples = np.array([0.0, 4.0, -4.0, 0.0, 0.0])
    source = command_side.sampled(time, samples, False, 0.0, 0.5)
    at = np.linspace(0.0, 0.4, 1001)
    c = np.interp(at, time, samples)
    for operator, expected in [
        (lambda s: command_side.clamp(s, -1.0, 3.0), np.clip(c, -1.0, 3.0)),
        (lambda s: command_side.dead_zone(s, 0.6), np.sign(c) * np.maximum(np.abs(c) - 0.6, 0.0)),
        (lambda s: command_side.asymmetric_gain(s, 0.7), np.where(c < 0.0, 0.7 * c, c)),
    ]:
        out = operator(source)
        i = np.searchsorted(out.start, at, side="right") - 1
        assert close(out.value[i] + out.slope[i] * (at - out.start[i]), expected, 1e-13)


# -- failures and sensor ------------------------------------------------------------------------------------------


def test_failures():
    time = grid(0.4, 0.001)
    command = constant(2.0, time)
    base = (1, 1.0, W, 0.2)
    step, _ = base_responses(*base[1:], 2)
    quiet, failed = time < 0.0099, time >= 0.0099
    begins = np.flatnonzero(failed)[0]
    t = time[failed] - time[begins]
    before = simulate(base, {}, time[:begins + 1], command[:begins + 1], order=2)
    d, v = before["drive"][-1], before["rate"][-1]

    stuck = simulate(base, {}, time, command, order=2, failure=np.where(quiet, 0, 2))
    assert close(stuck["position"][quiet], 2.0 * step(time[quiet]))
    assert close(stuck["position"][failed], constant(d, t)) and np.all(stuck["rate"][begins + 1:] == 0.0)
    assert np.isclose(stuck["rate"][begins], v, rtol=1e-12) and stuck["rate_after"][begins] == 0.0

    passive = simulate(base, {}, time, command, order=2, failure=["none" if q else "passive" for q in quiet])
    damping = 2.0 * 0.2 * W
    assert close(passive["position"][failed], d + v / damping * (1.0 - np.exp(-damping * t)))

    limits = {"position_limit": {"min": -6.0, "max": 5.0}}
    for number, stop in ((3, 5.0), (4, -6.0)):
        hard = simulate(base, limits, time, command, order=2, failure=np.where(quiet, 0, number))
        assert abs(hard["position"][-1] - stop) < 0.5 and not np.isclose(hard["position"][-1], 2.0)
    back = simulate((1, 300.0, W, 0.7), limits, time, command, failure=np.where((time > 0.05) & (time < 0.1), 3, 0))
    assert abs(back["position"][-1] - 2.0) < 1e-9


def test_stuck_then_released_swings_from_rest():
    time = grid(0.2, 0.001)
    failure = np.where(time < 0.0499, 2, 0)
    found = simulate((1, 1.0, W, 0.4), {}, time, constant(3.0, time), order=2, failure=failure)
    step, _ = base_responses(1.0, W, 0.4, 2)
    assert close(found["position"], 3.0 * step(time - 0.05))


def test_sensor_effects_without_memory():
    time = grid(0.2) + 7.0
    effects = {"sensor_bias": {"offset": 0.3, "drift": -0.2},
               "chatter": {"amplitude": 0.05, "frequency": 11.0, "phase": 0.4}, "quantisation": {"step": 0.1}}
    found = simulate((1, 1e4, W, 0.5), effects, time, 2.0 * np.sin(9.0 * time))
    clean = simulate((1, 1e4, W, 0.5), {}, time, 2.0 * np.sin(9.0 * time))["position"]
    t = time - 7.0
    analogue = clean + 0.3 - 0.2 * t + 0.05 * np.sin(2.0 * np.pi * 11.0 * t + 0.4)
    assert close(found["unquantised"], analogue) and close(found["deflection"], clean)
    assert np.abs(found["position"] - found["unquantised"]).max() <= 0.05 + 1e-12
    assert close(found["position"] / 0.1, np.round(found["position"] / 0.1), 1e-12)


def test_quantisation_ties_go_away_from_zero():
    assert quantise(np.array([0.5, -0.5, 1.5, 2.5, -2.5, 0.25]), 1.0).tolist() == [1.0, -1.0, 2.0, 3.0, -3.0, 0.0]


# -- laws ---------------------------------------------------------------------------------------------------------


def test_neutral_effects_are_the_identity():
    time = grid()
    command = np.random.default_rng(10).standard_normal(len(time))
    plain, neutral = (simulate((1, 1e4, W, 0.5), effects, time, command) for effects in ({}, NEUTRAL))
    assert all(np.array_equal(plain[name], neutral[name]) for name in plain)


def test_unknown_names_and_invalid_values_are_refused():
    time = grid()
    for effects in ({"slack": {}}, {"backlash": {"width": 1.0}}, {"backlash": {"gap": -1.0}},
                    {"rate_limit": {"up": 0.0}}, {"position_limit": {"min": 2.0, "max": 1.0}}):
        with pytest.raises(ValueError):
            simulate(UNDAMPED, effects, time, 0.0 * time)
