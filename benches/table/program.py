"""Start-up time of the program, and sizes of program and FMU."""

import sys
import tempfile
from pathlib import Path

from against_c import run as against_c

from .measure import Line, Spread, in_turn, run


def mb(path):
    return Spread.of([Path(path).stat().st_size / 1e6])


def measure(context):
    with tempfile.TemporaryDirectory() as name:
        source, empty = Path(name) / "empty.c", Path(name) / "empty"
        source.write_text("int main(void) { return 0; }\n")
        run([*against_c.compiler(), "-O2", "-o", empty, source])
        python = [sys.executable, "-c", "import scipy.signal, scipy.optimize"]
        own, c, scipy = in_turn(
            context.rounds(25), lambda: run([context.program, "--version"]), lambda: run([empty]), lambda: run(python)
        )  # fmt: skip
    own, c, scipy = (side.scaled(1e3) for side in (own, c, scipy))
    lines = [
        Line("program.c", "start: `actuator --version`", "ms", own, "a program in C that ends at once", c),
        Line("program.scipy", "start: `actuator --version`", "ms", own, "Python that imports scipy.signal and optimize", scipy),
        Line("program.size", "size of the program", "MB", mb(context.program)),
        Line("program.fmu", "size of the FMU, as fmu-build makes it for this computer", "MB", mb(context.fmu)),
    ]
    with against_c.prepared(context.fmu) as bench:
        lines.append(Line("program.library", "size of its library", "MB", mb(bench.library), "the unit in C", mb(bench.peer)))
    return lines, []
