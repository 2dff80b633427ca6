#!/usr/bin/env python3
"""Times the packaged FMU against a second-order unit in C that is compiled here, both driven by the same C loop in the same run.

    python3 benches/against_c/run.py [FMU]                  medians and ratios
    python3 benches/against_c/run.py [FMU] --instructions   callgrind's instruction counts (valgrind): of the linear step, of get and set of a
                                                            state, of a step with rate limit and backlash; of the unit in C likewise

The counts name functions where FMU_LIBRARY is an unstripped library: cargo rustc --lib --crate-type cdylib --profile fmu-binary
--config profile.fmu-binary.strip=false.

Without FMU it takes target/fmu/BactActuator.fmu, which `fmu-build` writes. Needs a C compiler: cc, or zig (`pip install ziglang`).
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
EFFECTS = ["rate_limit.up", "rate_limit.down", "backlash.gap", "delay.time"]
STEPS = 10_000


def compiler():
    if shutil.which("cc"):
        return ["cc"]
    return [sys.executable, "-m", "ziglang", "cc"]


def instructions(program, library, guid, folder, loop, *parameters):
    """Exclusive counts by function per round of a loop: the difference of two runs, so that loading and the first rounds cancel."""
    shim = folder / "no_membarrier.so"
    subprocess.run([*compiler(), "-O2", "-D_GNU_SOURCE", "-shared", "-fPIC", "-o", shim, HERE / "no_membarrier.c", "-ldl"], check=True)
    counts = []
    for steps in (STEPS, 2 * STEPS):
        out = folder / f"callgrind.{steps}"
        subprocess.run(
            ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, library, guid, loop, str(steps), *parameters],
            check=True, capture_output=True, env={**os.environ, "LD_PRELOAD": str(shim)},
        )  # fmt: skip
        # Without the lines of source files, which hide the functions.
        command = ["callgrind_annotate", "--threshold=100", "--auto=no", out]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        found = {}
        for line in text.splitlines():
            row = re.match(r"\s*([\d,]+) \(\s*[\d.]+%\)\s+(.*)", line)
            if row:
                name = re.sub(r" \[.*", "", row[2])
                name = re.sub(r"^[^:]*:(?!:)", "", name)
                found[name] = found.get(name, 0) + int(row[1].replace(",", ""))
        counts.append(found)
    rows = {name: (count - counts[0].get(name, 0)) / STEPS for name, count in counts[1].items()}
    print(f"{loop} of {library}")
    for name, count in sorted(rows.items(), key=lambda row: -row[1]):
        if count >= 0.5:
            print(f"{count:8.1f}  {name}")


def main():
    arguments = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    fmu = pathlib.Path(arguments[0]) if arguments else target / "fmu" / "BactActuator.fmu"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        description = ElementTree.parse(folder / "modelDescription.xml").getroot()
        references = {variable.get("name"): variable.get("valueReference") for variable in description.iter("ScalarVariable")}
        guid = description.get("guid")
        library = os.environ.get("FMU_LIBRARY", folder / "binaries" / "linux64" / "BactActuator.so")
        program, peer = folder / "loop", folder / "second_order.so"
        subprocess.run([*compiler(), "-O2", "-o", program, HERE / "loop.c", "-ldl", "-lpthread"], check=True)
        subprocess.run([*compiler(), "-O2", "-shared", "-fPIC", "-o", peer, HERE / "second_order.c", "-lm"], check=True)
        if "--instructions" in sys.argv:
            for unit in (library, peer):
                for loop in ("steps", "states"):
                    instructions(program, unit, guid, folder, loop)
            instructions(program, library, guid, folder, "effects", *(references[name] for name in EFFECTS[:3]))
        else:
            subprocess.run([program, library, guid, peer, *(references[name] for name in EFFECTS)], check=True)


if __name__ == "__main__":
    main()
