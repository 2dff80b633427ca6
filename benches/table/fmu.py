"""The packaged FMU against a unit in C (benches/against_c), both driven by one loop in C."""

import ctypes
import math

from against_c import run as against_c

from .context import BASE
from .measure import Line, Spread, agree

STEP_S, STEPS = 0.005, 2000
UNIT = {"step": "ns", "state": "ns", "life": "ns", "effects": "ns", "delay": "ns", "threads": "x", "processes": "x"}


class Unit:
    """A minimal instance through ctypes, for a comparison of outputs."""

    def __init__(self, library, guid):
        self.library = ctypes.CDLL(str(library))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        self.handle = ctypes.c_void_p(self.library.fmi2Instantiate(b"compared", 1, guid.encode(), None, None, 0, 0))
        if not self.handle:
            raise RuntimeError(f"{library} was not instantiated")

    def call(self, function, *arguments):
        status = getattr(self.library, f"fmi2{function}")(self.handle, *arguments)
        if status != 0:
            raise RuntimeError(f"fmi2{function} returned {status}")

    def set(self, kind, values):
        """Numbers by value reference."""
        number = {"Real": ctypes.c_double, "Integer": ctypes.c_int}[kind]
        for reference, value in values.items():
            self.call(f"Set{kind}", ctypes.byref(ctypes.c_uint(int(reference))), ctypes.c_size_t(1), ctypes.byref(number(value)))

    def start(self):
        self.call("SetupExperiment", 0, ctypes.c_double(0.0), ctypes.c_double(0.0), 0, ctypes.c_double(0.0))
        self.call("EnterInitializationMode")
        self.call("ExitInitializationMode")

    def run(self, commands):
        """Positions after each step."""
        position, reference, found = ctypes.c_double(), ctypes.c_uint(3), []
        for step, command in enumerate(commands):
            self.set("Real", {0: command})
            self.call("DoStep", ctypes.c_double(step * STEP_S), ctypes.c_double(STEP_S), 1)
            self.call("GetReal", ctypes.byref(reference), ctypes.c_size_t(1), ctypes.byref(position))
            found.append(position.value)
        return found


# Items of the FMU's enumerations.
SECOND_ORDER, CUSTOM = 1, 2


def deviation(bench):
    """Maximum difference of the two units over a command, with the same parameters, relative to the maximum position."""
    commands = [8.0 * math.sin(0.01 * step + 1e-5 * step * step) for step in range(STEPS)]
    ours, theirs = Unit(bench.library, bench.guid), Unit(bench.peer, "")
    names = bench.references
    ours.set("Integer", {names["order"]: SECOND_ORDER, names["source"]: CUSTOM})
    ours.set("Real", {names[f"custom.{name}"]: value for name, value in zip(("k", "omega", "zeta"), BASE)})
    ours.start()
    theirs.start()
    own, other = ours.run(commands), theirs.run(commands)
    return max(abs(a - b) for a, b in zip(own, other)) / max(map(abs, other))


def measure(context):
    with against_c.prepared(context.fmu) as bench:
        agreement = agree("position", deviation(bench), 1e-9)
        timings = bench.timings()
    lines = []
    for name, (own, other) in timings.items():
        peer = "C"
        if not other[1]:
            # The unit in C has neither effects nor a delay.
            other, peer = timings["step"][1], "C, linear step"
        what = against_c.WORDS[name].rsplit(",", 1)[0]
        said = agreement if name == "step" else ""
        lines.append(Line(f"fmu.{name}", what, UNIT[name], Spread(*own, 41), peer, Spread(*other, 41), said, more=UNIT[name] == "x"))
    return lines, []
