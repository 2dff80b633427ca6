"""Cost of each search of a diagnosis (one hypothesis from one start), against scipy and numba.

The peer is `scipy.optimize.least_squares` over base and effect from one start, white noise, on the servo in numba. It makes no judgement.
The product screens every effect on a ladder of starts, whitens the noise, judges on unseen records, and packages and steps two FMUs; all of
that is included in its time, which is divided by the number of searches. Both on one thread; processor time.
"""

import json
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from .context import BASE, ONE_THREAD, ROOT
from .measure import Line, Spread, in_turn, processor_s, run
from .numba_servo import CANDIDATES, simulate

sys.path.insert(0, str(ROOT / "fmpy-tests"))

FREE_BASE = (0, 2, 3)  # k, omega, zeta; p is held
LONG_S, NOISE = 200.0, 0.01  # 40 000 samples at 200 samples/s; noise by the rms of the position


@dataclass
class Case:
    folder: Path
    base: np.ndarray  # k, p, omega, zeta of the given model
    records: list  # fit records: files
    check: str
    truth: list  # names of the hidden effects

    def arguments(self):
        return ["diagnose", "--model", "model.toml", "--fit", *self.records, "--check", self.check, "-o", "diagnosis", "--force"]

    def diagnose(self, program):
        run([program, *self.arguments()], cwd=self.folder, env=ONE_THREAD)

    def found(self):
        return json.loads((self.folder / "diagnosis" / "diagnosis.json").read_text())

    def read(self):
        return [np.loadtxt(self.folder / name, delimiter=",", skiprows=1, usecols=(0, 1, 2), unpack=True) for name in self.records]


def drawn(context, kind, seed):
    """A case of the suite of hidden effects."""
    from hidden import cases, files

    folder = context.folder / f"{kind}-{seed}"
    if not (folder / "truth.json").exists():
        files.write(cases.draw(seed, kind), folder)
    truth = json.loads((folder / "truth.json").read_text())
    base = np.array([truth["model"][name] for name in ("k", "p", "omega", "zeta")])
    return Case(folder, base, ["sweep.csv", "random.csv"], "check.csv", truth["truth"])


def long_case(context):
    """Two records of 40 000 samples with play, and a check record."""
    folder = context.folder / "long"
    folder.mkdir(exist_ok=True)
    shutil.copy(context.model("given"), folder / "model.toml")
    worn = context.model("worn", '[effects.backlash]\ngap = { value = 0.1, unit = "deg" }')
    random = np.random.default_rng(5)
    for kind in ("sweep", "random", "multisine"):
        path, command = folder / f"{kind}.csv", context.command(kind, LONG_S)
        if path.exists():
            continue
        context.actuator("simulate", worn, command, "-o", folder / "clean.csv", "--force")
        time, given, position = np.loadtxt(folder / "clean.csv", delimiter=",", skiprows=1, usecols=(0, 1, 2), unpack=True)
        position += NOISE * np.sqrt(np.mean(position**2)) * random.standard_normal(len(position))
        np.savetxt(path, np.column_stack([time, given, position]), "%.7f", ",", header="time,command,position", comments="")
    return Case(folder, np.array([BASE[0], 1e4, *BASE[1:]]), ["sweep.csv", "random.csv"], "multisine.csv", ["backlash"])


def peer(base, records):
    """Residual rms of each candidate."""
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


def line(context, key, words, case, rounds):
    records = case.read()
    peer(case.base, [tuple(column[:100] for column in record) for record in records])  # compiles
    left = {}
    own, theirs = in_turn(context.rounds(rounds), lambda: case.diagnose(context.program), lambda: left.update(peer(case.base, records)), by=processor_s)
    found = case.found()
    searches, samples = found["searches"], sum(len(record[0]) for record in records)
    named = [effect["name"] for effect in found["effects"]]
    said = f"hidden {' + '.join(case.truth) or 'nothing'}; ours {found['verdict']} {' + '.join(named)}; least left by {min(left, key=left.get)}"
    what = f"{words}: {samples} samples, {searches} searches in {own.median:.1f} s; theirs {len(CANDIDATES)} in {theirs.median:.1f} s"
    return Line(f"diagnosis.{key}", what, "s each", own.scaled(1.0 / searches), "scipy and numba", theirs.scaled(1.0 / len(CANDIDATES)), said)


def measure(context):
    lines = [line(context, "plain", "one effect", drawn(context, "single", 57), 3)]
    if not context.quick:
        lines.append(line(context, "pair", "two effects", drawn(context, "pair", 11), 3))
        lines.append(line(context, "outside", "outside the library", drawn(context, "outside", 9), 2))
        lines.append(line(context, "outside-play", "outside, near a family", drawn(context, "outside", 12), 2))
        lines.append(line(context, "long", "two long records", long_case(context), 2))
    return lines, []


def cost(context, case):
    """Searches, and processor time [s] of the diagnosis."""
    seconds = Spread.of([processor_s(lambda: case.diagnose(context.program))]).median
    return case.found()["searches"], seconds
