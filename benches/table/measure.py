"""Alternating timings, and their statistics: quartiles, ratios."""

import resource
import subprocess
import sys
import time as clock
from dataclasses import asdict, dataclass, field
from statistics import quantiles

# A process inherits the peak memory of the one that starts it, so a small one must start it.
MEASURED_RUN = """
import resource, subprocess, sys
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_maxrss, used.ru_utime + used.ru_stime)
sys.exit(code)
"""


@dataclass
class Spread:
    """Quartiles of the measurements; for a single number all three are that number."""

    low: float
    median: float
    high: float
    rounds: int = 1

    @classmethod
    def of(cls, values):
        values = list(values)
        if len(values) == 1:
            return cls(*3 * values)
        return cls(*quantiles(values, n=4, method="inclusive"), len(values))

    def scaled(self, factor):
        return Spread(self.low * factor, self.median * factor, self.high * factor, self.rounds)


@dataclass
class Line:
    """One line of the table: the same work, ours and theirs."""

    key: str  # key of the reason if ours is behind
    what: str
    unit: str
    ours: Spread
    peer: str = ""  # name of the peer
    theirs: Spread = None
    agreement: str = ""  # deviation of the outputs
    more: bool = False  # if true, more is better

    @property
    def ratio(self):
        """Ours by theirs."""
        return self.ours.median / self.theirs.median if self.theirs else None

    @property
    def behind(self):
        """By more than the scatter of both."""
        if self.theirs is None:
            return False
        return self.ours.high < self.theirs.low if self.more else self.ours.low > self.theirs.high

    def to_json(self):
        return asdict(self)

    @classmethod
    def from_json(cls, found):
        sides = {side: Spread(**found[side]) if found[side] else None for side in ("ours", "theirs")}
        return cls(**(found | sides))


@dataclass
class Curve:
    """Growth of a cost: one point per size."""

    name: str
    size: list
    cost: list


@dataclass
class Picture:
    """Curves drawn together, on logarithmic axes."""

    file: str
    title: str
    x: str
    y: str
    curves: list = field(default_factory=list)

    def to_json(self):
        return asdict(self)

    @classmethod
    def from_json(cls, found):
        return cls(**(found | {"curves": [Curve(**curve) for curve in found["curves"]]}))


class Disagreement(RuntimeError):
    """The outputs of both sides differ by more than the tolerance: nothing is timed."""


def agree(name, deviation, tolerance):
    """Text about a relative deviation that is within its tolerance."""
    if not deviation <= tolerance:
        raise Disagreement(f"{name}: outputs differ by {deviation:.2g}, tolerance {tolerance:.2g}")
    return f"{deviation:.1g} (tolerance {tolerance:.1g})"


def clocked(run):
    """Wall-clock seconds."""
    start = clock.perf_counter()
    run()
    return clock.perf_counter() - start


def processor_s(run):
    """Seconds of processor time, in this process and its children."""
    before = _used()
    run()
    return _used() - before


def _used():
    return sum(used.ru_utime + used.ru_stime for used in (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)))


def in_turn(rounds, *runs, by=clocked):
    """Spread of the seconds of each run over alternating rounds; the first run rotates."""
    times = [[] for _ in runs]
    for number in range(rounds):
        order = range(len(runs)) if number % 2 == 0 else reversed(range(len(runs)))
        for place in order:
            times[place].append(by(runs[place]))
    return [Spread.of(each) for each in times]


def run(command, **options):
    """Runs a program and discards its output; its error output is the error."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()[-2000:]}")
    return done.stdout


def memory_and_processor(command):
    """Peak memory [MB] and processor time [s] of a program."""
    peak, seconds = run([sys.executable, "-c", MEASURED_RUN, *command]).split()
    return int(peak) / 1024.0, float(seconds)
