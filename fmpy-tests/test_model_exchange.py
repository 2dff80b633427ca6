"""Model exchange: CVode's integration of the FMU against its exact co-simulation, and events against their analytic instants.

Positions agree within 1e-6 of the peak (1 to 8 deg), at a tolerance of CVode of 1e-10; measured: below 1e-7. Two kinds of input: steps, and
straight lines between samples. For the FMU a smooth command is linear between completed steps h, an error of h^2 c''/8 where the
command side remembers something (delay, backlash and rate limit of the command).
"""

import fmpy
import numpy as np
import pytest
from scipy.optimize import brentq

import bact
import effect_cases
from effect_cases import EFFECTS
from model_exchange import exchange

SAMPLES = 61  # 0.3 s
RELATIVE = 1e-6  # of the largest position
STIFF_TOLERANCE = 1e-10
RUN_S, HELD_S = 0.2, 0.01


@pytest.fixture(scope="module")
def solved(package):
    """One model-exchange instance for all tests of this module."""
    with exchange(package) as made:
        yield made


def cut(case):
    return {**case, "time": case["time"][:SAMPLES], "command": case["command"][:SAMPLES]}


def agree(case, found, expected):
    size = max(np.abs(expected["position"]).max(), np.abs(expected["deflection"]).max(), 1.0)
    keep = np.ones(len(case["time"]), bool)
    if "quantisation" in case["effects"]:  # a tie may be rounded to either side
        step = case["effects"]["quantisation"]["step"]
        keep = np.abs(found["position"] - expected["position"]) < 0.5 * step
        assert keep.mean() > 0.9
    assert np.abs(found["position"] - expected["position"])[keep].max() <= RELATIVE * size, case["effects"]
    assert np.abs(found["deflection"] - expected["deflection"]).max() <= RELATIVE * size, case["effects"]
    omega = case["base"][2]
    assert np.abs(found["rate"] - expected["rate"]).max() <= RELATIVE * size * omega, case["effects"]


def stepped_input(commands, h):
    """A structured array for fmpy: a repeated time stamp is a step."""
    corners = np.empty(2 * len(commands) + 1, dtype=[("time", float), ("command", float)])
    corners["time"] = h * np.repeat(np.arange(len(commands) + 1), 2)[1:]
    corners["command"] = np.append(np.repeat(commands, 2), commands[-1])
    return corners


# Against co-simulation and the independent truth


@pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
def test_every_set_through_fmpy(fmu_path, rng, s):
    """`simulate_fmu` with CVode, poles up to 2.97e8 1/s, random steps; expected from partial fractions. Both orders for three sets."""
    commands = rng.uniform(-5, 5, round(RUN_S / HELD_S))
    orders = bact.ORDERS if s.number in (1, 12, 15) else (bact.THIRD,)
    for order in orders:
        result = fmpy.simulate_fmu(
            str(fmu_path), fmi_type="ModelExchange", solver="CVode", relative_tolerance=STIFF_TOLERANCE, stop_time=RUN_S,
            output_interval=HELD_S, record_events=False, input=stepped_input(commands, HELD_S), output=["position", "rate"],
            start_values={"set_number": s.number, "order": bact.ORDERS.index(order) + 1},
        )  # fmt: skip
        expected = bact.respond(s, order, commands, HELD_S)
        assert len(result) == len(commands) + 1
        error = np.abs(result["position"][1:] - expected[:, 1]).max()
        print(f"{s.name} {order}: {error:.1e} deg")
        assert error <= RELATIVE * np.abs(expected[:, 1]).max()


@pytest.mark.parametrize("kind, hold, order", [("random", True, 3), ("swept", False, 3), ("random", False, 2)])
@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect(shared, solved, rng, effect, kind, hold, order):
    case = cut(effect_cases.draw(rng, [effect], kind, order, hold))
    expected = effect_cases.run(shared, case)
    solved.initialize(effect_cases.start_values(case))
    agree(case, solved.integrate(case["time"], {"command": case["command"]}, hold).outputs, expected)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6])
def test_effects_together_with_loads_and_failures(shared, solved, rng, count):
    """Two actuators each, held and linear inputs. Stops keep a passive surface under an outward spring from diverging."""
    for hold in (True, False):
        names = list(rng.choice([effect for effect in EFFECTS if effect != "position_limit"], count, replace=False))
        case = cut(effect_cases.draw(rng, [*names, "position_limit"], "random", int(rng.integers(2, 4)), hold))
        case["initial_position"] = 0.0
        case["load"] = 0.3 * effect_cases.command(rng, "random", case["time"])
        case["failure"] = np.repeat(rng.integers(0, 5, 4), 16)[:SAMPLES]
        expected = effect_cases.run(shared, case)
        solved.initialize(effect_cases.start_values(case))
        inputs = {"command": case["command"], "load": case["load"]}
        agree(case, solved.integrate(case["time"], inputs, hold, {"failure": case["failure"] + 1}).outputs, expected)


@pytest.mark.parametrize("effect", ["none", "delay", "command_dead_zone", "command_limit", "backlash"])
def test_a_smooth_command_errs_by_the_square_of_the_accepted_step_and_without_a_delay_not_at_all(shared, solved, effect):
    """4 deg at 4 Hz. The delay stores straight pieces: an error of h^2 c''/8, 3e-4 deg at 1 ms. Other effects use the exact command.

    Expected: co-simulation along straight lines of 20 us, themselves 1.3e-7 deg from the sine.
    """
    values = {"delay": {"delay.time": 0.012}, "command_dead_zone": {"command_dead_zone.half_width": 0.7}, "none": {},
              "command_limit": {"command_limit.min": -2.0, "command_limit.max": 2.0}, "backlash": {"backlash.gap": 0.4}}[effect]  # fmt: skip
    fine, accepted, steps, omega, size = 2e-5, 1e-3, 200, 2 * np.pi * 4.0, 4.0
    corners = size * np.sin(omega * fine * np.arange(round(steps * accepted / fine) + 1))
    shared.restart({"set_number": 1, **values})
    expected = shared.run(corners[:-1], fine, np.diff(corners) / fine)[round(accepted / fine) - 1 :: round(accepted / fine)]
    solved.initialize({"set_number": 1, **values})
    error = np.abs(solved.follow(lambda t: size * np.sin(omega * t), accepted, steps) - expected).max()
    print(f"{effect}: {error:.1e} deg")
    assert error <= (accepted**2 * size * omega**2 / 8.0 * 1.1 if effect == "delay" else 5e-7)


# Events

BASE = {"source": "custom", "custom.k": 1.0, "custom.omega": 150.0, "custom.zeta": 0.6, "order": "second"}
STEP_DEG, LIMIT_DEG, LIMIT_DEG_S = 5.0, 3.0, 200.0
SIGMA, OMEGA_D = 0.6 * 150.0, 150.0 * 0.8


def position(t):
    """Eq. (6) after a step from rest."""
    return STEP_DEG * (1.0 - np.exp(-SIGMA * t) * (np.cos(OMEGA_D * t) + SIGMA / OMEGA_D * np.sin(OMEGA_D * t)))


def rate(t):
    return STEP_DEG * 150.0**2 / OMEGA_D * np.exp(-SIGMA * t) * np.sin(OMEGA_D * t)


def first(function, level):
    """Before the rate's maximum, where both rise."""
    return brentq(lambda t: function(t) - level, 0.0, np.arctan2(OMEGA_D, SIGMA) / OMEGA_D * (1.0 if function is rate else 3.0))


ANALYTIC = {
    "position_limit": ({"position_limit.max": LIMIT_DEG}, lambda: first(position, LIMIT_DEG)),
    "rate_limit": ({"rate_limit.up": LIMIT_DEG_S}, lambda: first(rate, LIMIT_DEG_S)),
    # 0.3 deg of play: the surface waits until the drive has crossed half of it.
    "backlash": ({"backlash.gap": 0.3}, lambda: first(position, 0.15)),
    # A delay of 5 ms shifts the step; its corner is a time event.
    "delay": ({"delay.time": 0.005}, lambda: 0.005),
}


@pytest.mark.parametrize("effect", ANALYTIC)
def test_the_first_event_comes_at_its_analytic_instant(solved, effect):
    """1e-9 s: the error of a crossing at hundreds of deg/s with CVode's tolerance of 1e-10."""
    values, instant = ANALYTIC[effect]
    solved.initialize({**BASE, **values})
    found = solved.integrate([0.0, 0.03], {"command": [STEP_DEG, STEP_DEG]})
    times = found.time_events if effect == "delay" else [time for time, _ in found.state_events]
    assert abs(times[0] - instant()) <= 1e-9


@pytest.mark.parametrize("effect", ["position_limit", "rate_limit"])
def test_an_indicator_changes_its_sign_at_the_limit_and_not_before(solved, effect):
    """By hand, without a solver: states of the analytic motion just before and just after the instant."""
    values, instant = ANALYTIC[effect]
    signs = []
    for side in (-1e-9, 1e-9):
        time = instant() + side
        solved.initialize({**BASE, **values})
        solved.fmu.enterEventMode()
        solved["command"] = STEP_DEG
        solved.iterate()
        start = solved.margins()
        solved.fmu.setTime(time)
        solved.set_states([0.0, position(time), rate(time), 0.0, 0.0, 0.0, 0.0])
        signs.append(np.sign(solved.margins()) == np.sign(np.where(start == 0.0, 1.0, start)))
    assert signs[0].all() and (~signs[1]).sum() == 1


def test_at_a_limit_the_mode_slides_and_stays(solved):
    """On the stop nothing moves and no event follows; the indicator is then the force that would pull it away."""
    solved.initialize({**BASE, "position_limit.max": LIMIT_DEG})
    found = solved.integrate([0.0, 0.1], {"command": [STEP_DEG, STEP_DEG]}, outputs=("position", "rate", "saturated"))
    assert len(found.state_events) == 1
    assert (solved["position"], solved["rate"], solved["saturated"]) == (LIMIT_DEG, 0.0, True)
    assert (solved.derivatives() == 0.0).all()
    # The force into the stop is omega^2 (x - max): it changes sign when the command passes the position of the stop.
    forces = []
    for command in (LIMIT_DEG + 1e-6, LIMIT_DEG - 1e-6):
        solved["command"] = command
        forces.append(solved.margins().min())
    assert forces[0] > 0.0 > forces[1]


def test_a_finished_event_leaves_no_indicator_below_zero(shared, solved, rng):
    """After event iteration every indicator is above the event threshold by at least a rounding: no event triggers another."""
    for effect in ("coulomb_friction", "dead_zone", "backlash", "rate_limit"):
        case = cut(effect_cases.draw(rng, [effect], "random", 3, True))
        solved.initialize(effect_cases.start_values(case))
        found = solved.integrate(case["time"], {"command": case["command"]})
        steps = np.count_nonzero(np.diff(case["command"]))
        assert 0 < len(found.state_events) <= 12 * (steps + 1), effect
        assert solved.margins().min() > -1e-9, effect


def test_fmpy_stops_at_events(fmu_path):
    """fmpy records both sides of an event: two rows at the instant at which the stop is reached."""
    step = stepped_input([STEP_DEG], 0.05)
    values = {"source": 2, "custom.k": 1.0, "custom.omega": 150.0, "custom.zeta": 0.6, "order": 1, "position_limit.max": LIMIT_DEG}
    result = fmpy.simulate_fmu(
        str(fmu_path), fmi_type="ModelExchange", stop_time=0.05, output_interval=0.01, relative_tolerance=1e-9, input=step,
        output=["position"], start_values=values,
    )  # fmt: skip
    hits = result["time"][np.abs(result["time"] - first(position, LIMIT_DEG)) < 1e-7]
    assert len(hits) >= 1 and result["position"].max() <= LIMIT_DEG + 1e-9


# States


def test_a_saved_state_goes_on_as_before(solved, rng):
    """Set and read in mid-motion with every effect that has memory: the same numbers to the last bit."""
    effects = ["delay", "command_backlash", "command_rate_limit", "backlash", "structural_mode", "sensor_lag", "coulomb_friction"]
    case = cut(effect_cases.draw(rng, effects, "random", 3, False))
    solved.initialize(effect_cases.start_values(case))
    half = SAMPLES // 2
    solved.integrate(case["time"][: half + 1], {"command": case["command"][: half + 1]}, False)
    fmu = solved.fmu
    state = fmu.getFMUstate()
    written = fmu.serializeFMUstate(state)
    here, numbers, indicators = solved.time, solved.get_states(), solved.margins()
    rest = case["time"][half:], {"command": case["command"][half:]}
    later = solved.integrate(*rest, False).outputs["position"]
    read = fmu.deSerializeFMUstate(written, None)
    for again in (state, read):
        fmu.setFMUstate(again)
        solved.time = here
        assert (solved.get_states() == numbers).all() and (solved.margins() == indicators).all()
        assert (solved.integrate(*rest, False).outputs["position"] == later).all()
    fmu.freeFMUstate(state)
    fmu.freeFMUstate(read)


def test_the_derivatives_are_those_of_the_states(solved, rng):
    """`der(...)` as variables and from `fmi2GetDerivatives`; eq. (1) by hand."""
    s = bact.SETS[0]
    solved.initialize({"set_number": s.number})
    x, d, v = rng.uniform(-1, 1, 3) * (1.0, 1.0, 100.0)
    solved.set_states([x, d, v, 0.0, 0.0, 0.0, 0.0])
    solved["command"] = 2.0
    expected = [s.p * (2.0 * s.k - x), v, s.omega**2 * (x - d) - 2.0 * s.zeta * s.omega * v]
    np.testing.assert_allclose(solved.derivatives()[:3], expected, rtol=1e-13)
    names = ["der(drive.target)", "der(drive.position)", "der(drive.rate)"]
    assert [solved[name] for name in names] == list(solved.derivatives()[:3])
    assert [solved[name] for name in ("drive.target", "drive.position", "drive.rate")] == [x, d, v]
