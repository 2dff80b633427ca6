"""A simulation of 15 000 samples: the library and the program against scipy, python-control and a servo in numba."""

import control
import numpy as np
import pandas as pd
from scipy import signal

from .measure import Line, agree, clocked, in_turn, run
from .numba_servo import KIND, simulate

DURATION_S, RATE_HZ = 75.0, 200.0
SET = "te-early-unloaded"
K, P, OMEGA, ZETA = 1.0198, 10_000.0, 165.26, 0.5624  # of that set
EFFECTS = {
    "rate_limit": (60.0, '[effects.rate_limit]\nup = { value = 60.0, unit = "deg/s" }\ndown = { value = 60.0, unit = "deg/s" }'),
    "backlash": (0.2, '[effects.backlash]\ngap = { value = 0.2, unit = "deg" }'),
}


class Library:
    """Simulations in the library, which measure their own time."""

    def __init__(self, context, model, command, repeats=5):
        self.out = context.folder / "simulated.csv"
        self.command = [context.library, "simulate", model, command, self.out, repeats]

    def seconds(self):
        return float(np.median([float(line) for line in run(self.command).split()])) / 1e9

    def position(self):
        run(self.command)
        return pd.read_csv(self.out)["position"].to_numpy()


def deviation(ours, theirs):
    """Maximum difference relative to the root mean square."""
    return np.abs(ours - theirs).max() / np.sqrt(np.mean(theirs**2))


def third_order():
    """eq. (1): continuous, and between samples with the command held."""
    numerator, denominator = [K * P * OMEGA**2], np.polymul([1.0, P], [1.0, 2.0 * ZETA * OMEGA, OMEGA**2])
    sampled = signal.cont2discrete((numerator, denominator), 1.0 / RATE_HZ, "zoh")
    return (numerator, denominator), (sampled[0].ravel(), sampled[1])


def linear(context):
    path = context.command("random", DURATION_S, 8.0)
    table = pd.read_csv(path)
    time, command = table["time"].to_numpy(), table["command"].to_numpy()
    continuous, (numerator, denominator) = third_order()
    state_space = control.sample_system(control.ss(control.tf(*continuous)), 1.0 / RATE_HZ, "zoh")
    library = Library(context, SET, path)
    peers = {
        "scipy.signal.lsim": lambda: signal.lsim(continuous, command, time, interp=False)[1],
        "scipy.signal.lfilter": lambda: signal.lfilter(numerator, denominator, command),
        "control.forced_response": lambda: control.forced_response(state_space, time, command).outputs,
    }
    position, lines = library.position(), []
    said = {name: agree(f"position of {name}", deviation(position, peer()), 1e-6) for name, peer in peers.items()}

    def by(work):
        return work() if work == library.seconds else clocked(work)

    own, *others = in_turn(context.rounds(15), library.seconds, *peers.values(), by=by)
    for (name, agreement), theirs in zip(said.items(), others, strict=True):
        lines.append(Line(f"linear.{name}", f"the library, {len(time)} samples", "ms", own.scaled(1e3), name, theirs.scaled(1e3), agreement))

    out, written = context.folder / "own.csv", context.folder / "theirs.csv"
    command_line = ["simulate", SET, path, "-o", out, "--force"]

    def by_hand():
        read = pd.read_csv(path)
        positions = signal.lfilter(numerator, denominator, read["command"].to_numpy())
        read.assign(position=positions).to_csv(written, index=False)

    own, theirs = in_turn(context.rounds(15), lambda: context.actuator(*command_line), by_hand)
    said = agree("position in files", deviation(pd.read_csv(out)["position"].to_numpy(), pd.read_csv(written)["position"].to_numpy()), 1e-6)
    what = "the program, from file to file, its start included"
    lines.append(Line("linear.files", what, "ms", own.scaled(1e3), "pandas and lfilter, without their start", theirs.scaled(1e3), said))
    return lines, []


def nonlinear(context):
    path = context.command("random", DURATION_S, 8.0)
    command, lines = pd.read_csv(path)["command"].to_numpy(), []
    base = np.array([1.0, 0.0, 120.0, 0.7])
    for name, (strength, words) in EFFECTS.items():
        library, positions = Library(context, context.model(name, words), path), np.empty(len(command))

        def peer(kind=KIND[name], strength=strength, positions=positions):
            simulate(kind, strength, base, command, 1.0 / RATE_HZ, positions)

        peer()  # compiles
        said = agree(f"position with {name}", deviation(library.position(), positions), 0.05)
        own, theirs = in_turn(context.rounds(15), library.seconds, lambda: clocked(peer), by=lambda work: work())
        what = f"{name.replace('_', ' ')}, the library, {len(command)} samples"
        lines.append(Line(f"nonlinear.{name}", what, "ms", own.scaled(1e3), "numba, 5 inner steps", theirs.scaled(1e3), said))
    return lines, []
