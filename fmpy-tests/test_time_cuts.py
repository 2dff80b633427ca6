"""The master's division of time does not matter: the same command signal gives the same positions at the same times.

Held and linear commands are followed exactly, so a cut only adds rounding: 1e-9 of the largest deflection is guaranteed,
1e-14 per piece is expected.
"""

import numpy as np
import pytest

import bact
from actuator_fmu import selection

TOLERANCE = 1e-9  # relative to the largest deflection (or rate) of the run
STEPS, PIECES = 100, 5
AMPLITUDE_DEG = 5.0
OUTPUTS = ("position", "rate")

every_set = pytest.mark.parametrize("s", bact.SETS, ids=lambda s: s.name)
every_order = pytest.mark.parametrize("order", bact.ORDERS)


def random_pieces(rng):
    """Every 5 ms cut in five at random; the last piece ends on the control computer's grid to the last bit but one."""
    cuts = np.sort(rng.uniform(0, bact.CONTROL_PERIOD_S, (STEPS, PIECES - 1)), axis=1)
    edges = np.column_stack([np.zeros(STEPS), cuts, np.full(STEPS, bact.CONTROL_PERIOD_S)])
    return np.diff(edges, axis=1)


def assert_same(cut, whole):
    assert (np.abs(cut - whole).max(axis=0) <= TOLERANCE * np.abs(whole).max(axis=0)).all()


@every_order
@every_set
def test_cutting_a_held_step_changes_nothing(shared, rng, s, order):
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS)
    shared.restart(selection(s, order))
    whole = shared.run(commands, bact.CONTROL_PERIOD_S, outputs=OUTPUTS)
    shared.restart(selection(s, order))
    cut = shared.run(np.repeat(commands, PIECES), random_pieces(rng).ravel(), outputs=OUTPUTS)
    assert_same(cut[PIECES - 1 :: PIECES], whole)


@every_order
@every_set
def test_cutting_a_linear_step_changes_nothing_if_every_piece_is_told_value_and_derivative(shared, rng, s, order):
    corners = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS + 1)
    slopes = np.diff(corners) / bact.CONTROL_PERIOD_S
    shared.restart(selection(s, order))
    whole = shared.run(corners[:-1], bact.CONTROL_PERIOD_S, slopes, outputs=OUTPUTS)
    pieces = random_pieces(rng)
    starts = np.cumsum(pieces, axis=1) - pieces
    commands = corners[:-1, None] + slopes[:, None] * starts
    shared.restart(selection(s, order))
    cut = shared.run(commands.ravel(), pieces.ravel(), np.repeat(slopes, PIECES), outputs=OUTPUTS)
    assert_same(cut[PIECES - 1 :: PIECES], whole)


@every_order
@every_set
def test_cutting_a_linear_step_changes_nothing_if_only_the_first_piece_is_told(shared, rng, s, order):
    """Value and derivative set once: the command continues linearly until either is set again."""
    corners = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS + 1)
    slopes = np.diff(corners) / bact.CONTROL_PERIOD_S
    shared.restart(selection(s, order))
    whole = shared.run(corners[:-1], bact.CONTROL_PERIOD_S, slopes, outputs=OUTPUTS)
    shared.restart(selection(s, order))
    cut = np.empty_like(whole)
    for i, pieces in enumerate(random_pieces(rng)):
        shared["command"] = corners[i]
        shared.set_slope(slopes[i])
        for piece in pieces:
            shared.step(piece)
        cut[i] = shared["position"], shared["rate"]
    assert_same(cut, whole)


def test_setting_only_the_value_holds_it(shared, rng):
    """A new value ends a linear segment: the command is held from then on."""
    s, order, h = bact.SETS[0], bact.THIRD, bact.CONTROL_PERIOD_S
    shared.restart(selection(s, order))
    shared.run([0.0], h, [AMPLITUDE_DEG / h])
    held = shared.run(np.full(STEPS, 1.0), h)
    start = bact.respond(s, order, [0.0], h, AMPLITUDE_DEG / h)[-1]
    exact = bact.respond(s, order, np.full(STEPS, 1.0), h, state=start)[:, 1]
    assert np.abs(held - exact).max() <= TOLERANCE * AMPLITUDE_DEG


def test_a_command_that_is_not_set_again_stays(shared):
    """One setting, then steps only: the same as setting it every time."""
    shared.restart()
    told = shared.run(np.full(STEPS, 2.0), bact.CONTROL_PERIOD_S)
    shared.restart()
    shared["command"] = 2.0
    once = np.empty(STEPS)
    for i in range(STEPS):
        shared.step(bact.CONTROL_PERIOD_S)
        once[i] = shared["position"]
    assert (told == once).all()


def test_the_start_time_does_not_matter(shared, rng):
    """Without drifts the model has no clock: the same run an hour later gives the same positions."""
    commands = rng.uniform(-AMPLITUDE_DEG, AMPLITUDE_DEG, STEPS)
    shared.restart(start_time=0.0)
    early = shared.run(commands, bact.CONTROL_PERIOD_S, outputs=OUTPUTS)
    shared.restart(start_time=3600.0)
    assert_same(shared.run(commands, bact.CONTROL_PERIOD_S, outputs=OUTPUTS), early)
