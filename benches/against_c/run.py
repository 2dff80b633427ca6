#!/usr/bin/env python3
"""Times the packaged FMU against a second-order unit in C compiled here, both driven by the same C loop in the same run.
Processor time; wall-clock time for two threads.

    python3 benches/against_c/run.py [FMU]                  medians, quartiles and ratios
    python3 benches/against_c/run.py [FMU] --instructions   callgrind's instruction counts (valgrind): of the linear step, of get and set of a
                                                            state, of a step with rate limit and backlash; likewise for the unit in C

The counts name functions if FMU_LIBRARY is an unstripped library: cargo rustc --lib --crate-type cdylib --profile fmu-binary --config
profile.fmu-binary.strip=false.

Without FMU it uses target/fmu/BactActuator.fmu, written by `fmu-build`. Needs a C compiler: cc, or zig (`pip install ziglang`).
"""

import contextlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from xml.etree import ElementTree

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
EFFECTS = ["rate_limit.up", "rate_limit.down", "backlash.gap", "delay.time"]
STEPS = 10_000


def default_fmu():
    return pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "fmu" / "BactActuator.fmu"


def compiler():
    if shutil.which("cc"):
        return ["cc"]
    return [sys.executable, "-m", "ziglang", "cc"]


def shared(source, library, *libraries):
    """Compiles a C file to a shared library."""
    subprocess.run([*compiler(), "-O2", "-D_GNU_SOURCE", "-shared", "-fPIC", "-o", library, source, *libraries], check=True)
    return library


@dataclass
class Bench:
    """The loop, the FMU's library and the unit in C, ready to run."""

    folder: pathlib.Path
    program: pathlib.Path
    library: pathlib.Path
    peer: pathlib.Path
    guid: str
    references: dict  # value reference of each variable of the FMU

    def run(self, *arguments):
        """Words of each line printed by the loop."""
        command = [self.program, self.library, self.guid, *map(str, arguments)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return [line.split("\t") for line in done.stdout.splitlines()]

    def timings(self):
        """{name: ((first quartile, median, third quartile) of the FMU, the same of the unit in C)}, [ns]."""
        lines = self.run(self.peer, *(self.references[name] for name in EFFECTS))
        return {name: (tuple(map(float, rest[:3])), tuple(map(float, rest[3:]))) for name, *rest in lines}

    def instructions(self, loop, library=None):
        """{function: exclusive count} per round of a loop: the difference of two runs, so that loading and the first rounds cancel."""
        parameters = [self.references[name] for name in EFFECTS[:3]] if loop == "effects" else []
        shim = shared(HERE / "no_membarrier.c", self.folder / "no_membarrier.so", "-ldl")
        counts = []
        for steps in (STEPS, 2 * STEPS):
            out = self.folder / f"callgrind.{steps}"
            unit = [self.program, library or self.library, self.guid, loop, str(steps), *parameters]
            subprocess.run(
                ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", *unit],
                check=True, capture_output=True, env={**os.environ, "LD_PRELOAD": str(shim)},
            )  # fmt: skip
            counts.append(functions(out))
        return {name: (count - counts[0].get(name, 0)) / STEPS for name, count in counts[1].items()}


def functions(out):
    """{function: exclusive count} of a callgrind file."""
    # Without lines of source files, which hide the functions.
    command = ["callgrind_annotate", "--threshold=100", "--auto=no", out]
    found = {}
    for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines():
        row = re.match(r"\s*([\d,]+) \(\s*[\d.]+%\)\s+(.*)", line)
        if row and row[2] != "PROGRAM TOTALS":
            name = re.sub(r" \[.*", "", row[2])
            name = re.sub(r"^[^:]*:(?!:)", "", name)
            found[name] = found.get(name, 0) + int(row[1].replace(",", ""))
    return found


@contextlib.contextmanager
def prepared(fmu=None):
    """Unpacks the FMU and compiles the loop and the unit in C, in a temporary folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with zipfile.ZipFile(fmu or default_fmu()) as archive:
            archive.extractall(folder)
        description = ElementTree.parse(folder / "modelDescription.xml").getroot()
        library = os.environ.get("FMU_LIBRARY", folder / "binaries" / "linux64" / "BactActuator.so")
        program = folder / "loop"
        subprocess.run([*compiler(), "-O2", "-o", program, HERE / "loop.c", "-ldl", "-lpthread"], check=True)
        peer = shared(HERE / "second_order.c", folder / "second_order.so", "-lm")
        references = {variable.get("name"): variable.get("valueReference") for variable in description.iter("ScalarVariable")}
        yield Bench(folder, program, pathlib.Path(library), peer, description.get("guid"), references)


WORDS = {
    "step": "set + step + get, ns",
    "state": "state: get + set, ns",
    "life": "an instance: instantiate to free, ns",
    "effects": "rate limit + backlash, random commands, ns",
    "delay": "delay of 10 s, steps of 1 ms, ns",
    "threads": "two instances on two threads, steps of one",
    "processes": "two instances in two processes, steps of one",
}


def print_timings(timings):
    print(f"{'median (first to third quartile)':<46} {'FMU':>28} {'C':>24} {'ratio':>7}")
    for name, (own, other) in timings.items():
        # The unit in C has neither effects nor a delay: these are compared with its linear step.
        against = other if other[1] else timings["step"][1]
        texts = [f"{median:.1f} ({low:.1f} to {high:.1f})" for low, median, high in (own, other)]
        print(f"{WORDS[name]:<46} {texts[0]:>28} {texts[1] if other[1] else '':>24} {own[1] / against[1]:7.2f}")


def main():
    arguments = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    with prepared(*arguments[:1]) as bench:
        if "--instructions" not in sys.argv:
            return print_timings(bench.timings())
        loops = [(bench.library, "steps"), (bench.library, "states"), (bench.library, "effects"), (bench.peer, "steps"), (bench.peer, "states")]
        for library, loop in loops:
            rows = bench.instructions(loop, library)
            print(f"{loop} of {library}: {sum(rows.values()):.1f}")
            for name, count in sorted(rows.items(), key=lambda row: -row[1]):
                if count >= 0.5:
                    print(f"{count:8.1f}  {name}")


if __name__ == "__main__":
    main()
