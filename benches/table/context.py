"""What rows need: program, FMU, library, a folder for records, and how many rounds."""

import json
import os
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .measure import run

ROOT = Path(__file__).resolve().parent.parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
FMU = TARGET / "fmu" / "BactActuator.fmu"
os.environ.setdefault("ACTUATOR_FMU", str(FMU))  # of which the program makes other models' FMUs
ONE_THREAD = os.environ | {"RAYON_NUM_THREADS": "1"}


@dataclass
class Context:
    quick: bool = False

    def rounds(self, count):
        """Fewer where it is to be quick."""
        return min(count, 2) if self.quick else count

    @cached_property
    def folder(self):
        """Records and results of the bench; kept, since the longest take a minute to write."""
        folder = TARGET / "bench"
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    @property
    def fmu(self):
        return FMU

    @property
    def program(self):
        """The built program; another one: ACTUATOR_PROGRAM."""
        return Path(os.environ.get("ACTUATOR_PROGRAM", TARGET / "release" / "actuator"))

    @cached_property
    def library(self):
        """The program of benches/library.rs."""
        command = ["cargo", "bench", "--quiet", "--locked", "-p", "cli", "--bench", "library", "--no-run", "--message-format=json"]
        said = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        built = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
        return next(one["executable"] for one in built if one.get("executable") and one["target"]["name"] == "library")

    def actuator(self, *arguments, **options):
        return run([self.program, *arguments], **options)

    def command(self, kind, duration_s, amplitude=2.0):
        """A file with a command of the program's own."""
        path = self.folder / f"{kind}-{duration_s:g}-{amplitude:g}.csv"
        if not path.exists():
            self.actuator("excite", kind, "--duration", duration_s, "--amplitude", amplitude, "-o", path)
        return path

    def model(self, name, effects=""):
        """A model file of second order: k, omega, zeta of `BASE`."""
        path = self.folder / f"{name}.toml"
        values = zip(("k", "omega", "zeta"), BASE, ("deg/deg", "rad/s", "1"), strict=True)
        lines = [f'{key} = {{ value = {value}, unit = "{unit}" }}' for key, value, unit in values]
        path.write_text("\n".join(["[base]", "order = 2", *lines, effects, ""]))
        return path


# k, omega [rad/s] and zeta of the servo that both sides have where they are compared.
BASE = (1.0, 120.0, 0.7)
