"""What a diagnosis costs per candidate, as a ratio to scipy and numba measured in the same run.

    .venv/bin/python benches/diagnose_against_scipy.py        # needs `cargo build --release`; another binary: ACTUATOR_PROGRAM

The peer is what one would write in Python: a servo with an effect, compiled by numba and stepped by Runge-Kutta of order 4 in steps of
1 ms, and `scipy.optimize.least_squares` over base and effect from one start, white noise. It judges nothing. The product searches
every effect from a ladder of starts, whitens the noise, looks at the check record, and packages and steps two FMUs; all of that is in
its time. Both run on one core in turn; processor time counts, of the fastest round.
"""

import os
import resource
import sys
import tempfile
import time as clock
from pathlib import Path

import numba
import numpy as np
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "fmpy-tests"))

from hidden import cases, files, product  # noqa: E402

ROUNDS = 3
STEP_S = 1e-3
SLOW_RATE_DEG_S = 1e-3  # Coulomb friction is smoothed below this rate
# Effects that the peer knows: place in the kernel, and the strength from which its search starts.
CANDIDATES = {
    "none": 0.0, "delay": 0.005, "command_limit": 2.0, "command_rate_limit": 60.0, "command_dead_zone": 0.05, "asymmetric_gain": 1.02,
    "dead_zone": 0.05, "amplitude_gain": 1e-3, "hinge_load": 0.02, "coulomb_friction": 0.02, "acceleration_limit": 5e3,
    "rate_limit": 60.0, "position_limit": 2.0, "backlash": 0.1,
}  # fmt: skip
FREE_BASE = (0, 2, 3)  # k, omega, zeta; p stays


@numba.njit(cache=True, fastmath=True)
def shaped(kind, s, c):
    if kind == 2:
        return min(max(c, -s), s)
    if kind == 4:
        return 0.0 if abs(c) < s else c - np.sign(c) * s
    if kind == 5:
        return c * s if c < 0.0 else c
    return c


@numba.njit(cache=True, fastmath=True)
def acceleration(kind, s, omega, zeta, x, position, rate):
    error = x - position
    if kind == 6:
        error = 0.0 if abs(error) < s else error - np.sign(error) * s
    drive = omega * omega * error
    if kind == 7:
        drive -= omega * omega * s * position**3
    if kind == 8:
        drive += omega * omega * s
    if kind == 10:
        drive = min(max(drive, -s), s)
    if kind == 9:
        drive -= omega * omega * s * np.tanh(rate / SLOW_RATE_DEG_S)
    return drive - 2.0 * zeta * omega * rate


@numba.njit(cache=True, fastmath=True)
def simulate(kind, s, base, command, interval, out):
    k, omega, zeta = base[0], base[2], base[3]
    steps = int(round(interval / STEP_S))
    h = interval / steps
    late = int(s / interval) if kind == 1 else 0
    share = s / interval - late if kind == 1 else 0.0
    position = rate = shifted = play = 0.0
    for n in range(len(command)):
        out[n] = play if kind == 13 else position
        for step in range(steps):
            # The pole p is far above what moves here: x = k c.
            m = n - late - (1 if (step + 0.5) / steps < share else 0)
            c = shaped(kind, s, command[m] if m >= 0 else 0.0)
            if kind == 3:
                shifted += min(max(c - shifted, -s * h), s * h)
                c = shifted
            x = k * c
            a1 = acceleration(kind, s, omega, zeta, x, position, rate)
            a2 = acceleration(kind, s, omega, zeta, x, position + 0.5 * h * rate, rate + 0.5 * h * a1)
            a3 = acceleration(kind, s, omega, zeta, x, position + 0.5 * h * (rate + 0.5 * h * a1), rate + 0.5 * h * a2)
            a4 = acceleration(kind, s, omega, zeta, x, position + h * (rate + 0.5 * h * a2), rate + h * a3)
            position += h * rate + h * h / 6.0 * (a1 + a2 + a3)
            rate += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            if kind == 11:
                rate = min(max(rate, -s), s)
            if kind == 12:
                position = min(max(position, -s), s)
            if kind == 13:
                play = min(max(play, position - 0.5 * s), position + 0.5 * s)


def read(path):
    return np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)


def peer(base, records):
    """Root mean square left by each candidate."""
    left = {}
    for kind, (name, strength) in enumerate(CANDIDATES.items()):
        start = np.array([base[place] for place in FREE_BASE] + ([strength] if kind else []))

        def residual(scaled):
            values = scaled * start
            tried = np.array(base)
            tried[list(FREE_BASE)] = values[:3]
            parts = []
            for time, command, position in records:
                simulated = np.empty(len(command))
                simulate(kind, values[3] if kind else 0.0, tried, command, time[1] - time[0], simulated)
                parts.append(position - simulated)
            return np.concatenate(parts)

        found = least_squares(residual, np.ones(len(start)), x_scale=1.0, diff_step=1e-4, max_nfev=30)
        left[name] = float(np.sqrt(np.mean(found.fun**2)))
    return left


def processor_s():
    own, children = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def fastest(work):
    """Least processor time of some rounds, the least time by the clock, and the result."""
    processor, clocked = [], []
    for _ in range(ROUNDS):
        start = processor_s(), clock.perf_counter()
        result = work()
        processor.append(processor_s() - start[0])
        clocked.append(clock.perf_counter() - start[1])
    return min(processor), min(clocked), result


def main():
    path = product.program()
    if not product.can_diagnose(path):
        sys.exit(f"{path} does not know `diagnose`. Build it with `cargo build --release`")
    seed = int(os.environ.get("ACTUATOR_SEED", "57"))
    case = cases.draw(seed, "single")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        files.write(case, folder)
        truth = files.truth(case)
        records = [read(folder / name) for name in ("sweep.csv", "random.csv")]
        base = np.array([truth["model"][name] for name in ("k", "p", "omega", "zeta")])
        peer(base, [tuple(column[:100] for column in record) for record in records])  # compiles
        peer_s, _, left = fastest(lambda: peer(base, records))

        def diagnose(threads):
            for old in (folder / "diagnosis").glob("*"):
                old.unlink()
            if (folder / "diagnosis").is_dir():
                (folder / "diagnosis").rmdir()
            return product.diagnose(path, folder, threads=threads)[0]

        one_s, _, diagnosis = fastest(lambda: diagnose(1))
        _, two_s, _ = fastest(lambda: diagnose(2))
    tried = 20  # every effect of the chain, each at its place, and the base alone
    best = min(left, key=left.get)
    print(f"case: single {seed}, {truth['duration_s']:.0f} s at 200 samples/s, {truth['truth']}")
    print(f"scipy and numba: {peer_s:.2f} s for {len(CANDIDATES)} candidates on one core; least left by {best}")
    print(f"actuator diagnose: {one_s:.2f} s for {tried} candidates on one core, {two_s:.2f} s by the clock on two; named {[e['name'] for e in diagnosis['effects']]}")
    print(f"per candidate, product over scipy and numba: {one_s / tried / (peer_s / len(CANDIDATES)):.2f}")


if __name__ == "__main__":
    main()
