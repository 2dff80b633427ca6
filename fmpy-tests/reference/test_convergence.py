"""The reference against itself and against other methods: any effects together, where no closed form exists."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .brute_force import step_through
from .plant import simulate
from .random_cases import difference, draw

pytestmark = pytest.mark.slow

PAIRS = range(300, 325)
MANY = range(700, 710)
CASES = [(seed, 2) for seed in PAIRS] + [(seed, 6) for seed in MANY]


@pytest.mark.parametrize("seed, count", CASES)
def test_smaller_steps_change_nothing(seed, count):
    case = draw(seed, count)
    change = difference(simulate(**case), simulate(**case, refinement=2.3))
    assert change < 1e-10, f"seed {seed}: {case['effects']}"


def test_tiny_steps_without_any_events_agree():
    """Limits and friction occasionally switch on tiny differences, where the first-order error of the tiny steps is visible."""
    cases = [draw(seed, count) for seed, count in CASES]
    time = cases[0]["time"][:101]
    for case in cases:
        case.update({name: case[name][:101] for name in ("time", "command", "load", "failure")
                     if case[name] is not None})
    naive = step_through(cases, time, 2e-5)
    errors = []
    for i, case in enumerate(cases):
        exact = simulate(**case)
        peak = max(np.abs(exact["drive"]).max(), 1e-3)
        errors.append(max(np.abs(exact[name] - naive[name][i]).max() for name in ("drive", "deflection")) / peak)
        if "quantisation" not in case["effects"]:
            errors[-1] = max(errors[-1], np.abs(exact["position"] - naive["position"][i]).max() / peak)
        print(f"seed {CASES[i][0]}: {errors[-1]:.1e} {case['effects']}")
    assert np.median(errors) < 2e-4 and np.max(errors) < 2e-2


def test_tiny_steps_converge_to_the_reference():
    """The error is ten times smaller with ten times smaller steps, in a case with many events."""
    case = dict(base=(1.0, 2e4, 170.0, 0.5), order=3, initial_position=0.0, effects={
        "coulomb_friction": {"level": 0.3}, "rate_limit": {"up": 120.0, "down": 90.0}, "backlash": {"gap": 0.4},
        "acceleration_limit": {"value": 20000.0}, "position_limit": {"min": -2.0, "max": 2.5}})
    time = np.arange(41) * 0.005
    case["command"] = 4.0 * np.sin(2.0 * np.pi * 4.0 * time)
    exact = simulate(case["base"], case["effects"], time, case["command"])
    errors = [np.abs(exact["deflection"] - step_through([case], time, dt)["deflection"][0]).max()
              for dt in (2e-4, 2e-5)]
    assert errors[1] < errors[0] / 6.0 and errors[1] < 1e-2


def test_smooth_nonlinear_loop_by_solve_ivp():
    """Cubic, hinge load, drift and a slow pole, linear command: DOP853 from knot to knot."""
    k, p, omega, zeta = 1.1, 80.0, 150.0, 0.3
    cubic, stiffness, bias, drift = 0.02, 0.2, 0.3, 0.1
    random = np.random.default_rng(11)
    time = np.arange(41) * 0.01
    command, load = 3.0 * random.standard_normal(41), random.standard_normal(41)

    def slope(t, state):
        x, d, v = state
        c, external = np.interp(t, time, command), np.interp(t, time, load) + bias
        return [p * (k * (1.0 + drift * t) * c - x), v, omega**2 * (
            x - d - cubic * d**3 + external - stiffness * d) - 2.0 * zeta * omega * v]

    state, expected = [0.0, 0.0, 0.0], [[0.0, 0.0]]
    for begin, end in zip(time, time[1:]):
        state = solve_ivp(slope, (begin, end), state, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        expected.append(state[1:])
    found = simulate((k, p, omega, zeta), {
        "amplitude_gain": {"cubic": cubic}, "hinge_load": {"stiffness": stiffness, "bias": bias},
        "gain_drift": {"rate": drift}}, time, command, load=load, hold=False)
    expected = np.array(expected)
    assert np.abs(found["drive"] - expected[:, 0]).max() < 1e-10 * np.abs(expected[:, 0]).max()
    assert np.abs(found["rate"] - expected[:, 1]).max() < 1e-10 * np.abs(expected[:, 1]).max()


def test_friction_rate_limit_and_play_by_solve_ivp_with_events():
    """One long stroke of a linear command: stick, forward, at the rate limit, forward, stick; each by DOP853."""
    omega, zeta, level, up, gap = 120.0, 0.5, 0.4, 40.0, 0.3
    time = np.array([0.0, 0.1, 0.2, 0.3])
    command = np.array([0.0, 6.0, 6.0, 6.0])

    def force(t, d, v):
        return omega**2 * (np.interp(t, time, command) - d - level) - 2.0 * zeta * omega * v

    def follow(begin, end, d, v, event, limited):
        event.terminal = True
        result = solve_ivp(lambda t, s: [s[1], 0.0 if limited else force(t, *s)], (begin, end), [d, v], "DOP853",
                           rtol=1e-12, atol=1e-13, events=event, max_step=1e-3)
        return result, result.t[-1], *result.y[:, -1]

    leaves = level / 60.0
    forward, t, d, v = follow(leaves, 0.3, 0.0, 0.0, lambda t, s: s[1] - up, False)
    limited, t, d, v = follow(t, 0.3, d, up, lambda t, s: force(t, s[0], up), True)
    slowing, t, d, v = follow(t, 0.3, d, v, lambda t, s: s[1], False)
    assert forward.status == limited.status == slowing.status == 1
    found = simulate((1, 1.0, omega, zeta), {
        "coulomb_friction": {"level": level}, "rate_limit": {"up": up}, "backlash": {"gap": gap}},
        np.linspace(0.0, 0.3, 301), np.interp(np.linspace(0.0, 0.3, 301), time, command), hold=False, order=2)
    assert abs(found["drive"][-1] - d) < 1e-9 and found["rate"][-1] == 0.0
    assert abs(found["deflection"][-1] - (d - 0.5 * gap)) < 1e-9


@pytest.mark.parametrize("seed", range(40, 46))
def test_a_command_repeated_at_more_samples_gives_the_same(seed):
    """Held samples twice and five times as dense: no new information, and all events occur elsewhere relative to the samples."""
    case = draw(seed, 3)
    found = simulate(**case)
    for factor in (2, 5):
        fine = {name: None if case[name] is None else np.repeat(case[name], factor)
                for name in ("command", "load", "failure")}
        dense = simulate(**{**case, **fine, "time": np.arange(200 * factor) * (0.005 / factor)})
        assert difference(found, {name: values[::factor] for name, values in dense.items()}) < 1e-10


@pytest.mark.parametrize("seed", range(50, 58))
def test_the_mirrored_plant_answers_the_mirrored_command(seed):
    case = draw(seed, 4)
    case["failure"] = None
    mirrored = {**case, "command": -case["command"], "initial_position": -case["initial_position"],
                "load": None if case["load"] is None else -case["load"], "effects": {}}
    for name, values in case["effects"].items():
        if {"up", "down"} <= values.keys():
            values = {"up": values["down"], "down": values["up"]}
        if {"min", "max"} <= values.keys():
            values = {"min": -values["max"], "max": -values["min"]}
        signed = {"bias", "offset", "drift", "amplitude"}
        mirrored["effects"][name] = {key: -value if key in signed else value for key, value in values.items()}
    # Not a symmetric pair: its mirror would have to act on c > 0.
    case["effects"].pop("asymmetric_gain", None), mirrored["effects"].pop("asymmetric_gain", None)
    one, other = simulate(**case), simulate(**mirrored)
    back = {name: values if values.dtype == bool else -values for name, values in other.items()}
    assert difference(one, back) < 1e-10
    assert np.array_equal(one["saturated"], other["saturated"])
