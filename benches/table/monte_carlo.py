"""100 000 actuators with spread parameters under the same command: the library on all cores against numba on all cores."""

import time as clock

import numba
import numpy as np

from .measure import Line, agree, in_turn, run

STEPS, STEP_S, HALF_PERIOD, SIZE = 200, 0.005, 50, 2.0
LIMIT, GAP = 60.0, 0.2
INNER = 5


@numba.njit(cache=True)
def spread(index, irrational):
    product = index * irrational
    return 2.0 * (product - np.floor(product)) - 1.0


@numba.njit(cache=True)
def parameters(index):
    return (
        1.0 + 0.1 * spread(index, np.sqrt(2.0)),
        150.0 * (1.0 + 0.1 * spread(index, np.sqrt(3.0))),
        0.6 * (1.0 + 0.1 * spread(index, np.sqrt(5.0))),
    )


@numba.njit(cache=True, parallel=True, fastmath=True)
def linear(count, steps, last):
    for index in numba.prange(count):
        k, omega, zeta = parameters(index)
        damped, size = omega * np.sqrt(1.0 - zeta * zeta), np.exp(-zeta * omega * STEP_S)
        co, si = size * np.cos(damped * STEP_S), size * np.sin(damped * STEP_S) / damped
        a, b, c, d = co + zeta * omega * si, si, -omega * omega * si, co - zeta * omega * si
        position = rate = 0.0
        for step in range(steps):
            target = k * (SIZE if step // HALF_PERIOD % 2 == 0 else -SIZE)
            error = position - target
            position, rate = target + a * error + b * rate, c * error + d * rate
        last[index] = position


@numba.njit(cache=True, parallel=True, fastmath=True)
def nonlinear(count, steps, last):
    """Runge-Kutta of order 4 in 5 inner steps, with rate limit and play applied after each."""
    h = STEP_S / INNER
    for index in numba.prange(count):
        k, omega, zeta = parameters(index)
        position = rate = play = 0.0
        for step in range(steps):
            target = k * (SIZE if step // HALF_PERIOD % 2 == 0 else -SIZE)
            for _ in range(INNER):
                a1 = omega * omega * (target - position) - 2.0 * zeta * omega * rate
                r2 = rate + 0.5 * h * a1
                a2 = omega * omega * (target - position - 0.5 * h * rate) - 2.0 * zeta * omega * r2
                r3 = rate + 0.5 * h * a2
                a3 = omega * omega * (target - position - 0.5 * h * r2) - 2.0 * zeta * omega * r3
                r4 = rate + h * a3
                a4 = omega * omega * (target - position - h * r3) - 2.0 * zeta * omega * r4
                # A limited rate moves the position by the limit.
                mean = (rate + 2.0 * r2 + 2.0 * r3 + r4) / 6.0
                position += h * min(max(mean, -LIMIT), LIMIT)
                rate = min(max(rate + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4), -LIMIT), LIMIT)
                play = min(max(play, position - 0.5 * GAP), position + 0.5 * GAP)
        last[index] = play


PEERS = {"linear": (linear, 1e-9, 5), "nonlinear": (nonlinear, 0.02, 2)}


def measure(context):
    count, lines = 1000 if context.quick else 100_000, []
    for kind, (kernel, tolerance, rounds) in PEERS.items():
        last = np.empty(count)
        kernel(10, 10, last)  # compiles
        command = [context.library, "monte-carlo", count, STEPS, kind]
        _, *ours = map(float, run(command).split())

        def peer(kernel=kernel, last=last):
            start = clock.perf_counter()
            kernel(count, STEPS, last)
            return clock.perf_counter() - start

        def own(command=command):
            return float(run(command).split()[0])

        peer()
        apart = max(abs(a - b) for a, b in zip(ours, (last.mean(), last.std()), strict=True)) / SIZE
        said = agree(f"mean and deviation of the last position, {kind}", apart, tolerance)
        found = in_turn(context.rounds(rounds), own, peer, by=lambda work: work())
        words = {"linear": "linear", "nonlinear": "rate limit and backlash"}[kind]
        what = f"{count} actuators, {STEPS} steps of 5 ms, {words}, all cores"
        lines.append(Line(f"monte-carlo.{kind}", what, "s", found[0], "numba" if kind == "linear" else "numba, 5 inner steps", found[1], said))
    return lines, []
