"""The same servo in JSBSim and MuJoCo, as written by `actuator export`, against the FMU in fmpy: all driven from Python, sample by sample.

The runs of the simulators are those of `actuator export --measure`; loading is not counted: two lengths are subtracted.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from .context import ROOT
from .importers import SERVO, Stepped
from .measure import Line, agree, clocked, in_turn, run
from .simulation import deviation

SHORT_S, LONG_S = 5.0, 75.0
STEP_S = 0.005
# Export target: script, its step [s], tolerance. JSBSim's filters use Tustin's rule and lag by half a frame.
TARGETS = {"jsbsim": ("run_jsbsim.py", "0.001", 0.1), "mujoco": ("run_mujoco.py", "0", 0.05)}


def simulated(script, exported, command, frame):
    """Positions of a run of the simulator, in a separate folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied = folder / "exported.xml"
        copied.write_text(exported.read_text())
        positions = folder / "positions.txt"
        run([sys.executable, ROOT / "cli" / "src" / "export" / script, copied, "servo", command, frame, positions])
        return np.loadtxt(positions)


def measure(context):
    model, lines = context.model("servo"), []
    short, long = (context.command("sweep", duration_s) for duration_s in (SHORT_S, LONG_S))
    commands = pd.read_csv(long)["command"].tolist()[:-1]
    samples = round((LONG_S - SHORT_S) / STEP_S)
    with tempfile.TemporaryDirectory() as folder:
        ours = Stepped(context.fmu, Path(folder) / "ours", SERVO)
        _, position = ours.steps(commands)
        for target, (script, frame, tolerance) in TARGETS.items():
            exported = context.folder / f"servo-{target}.xml"
            context.actuator("export", model, "--to", target, "-o", exported, "--force")
            theirs = simulated(script, exported, long, frame)
            said = agree(f"position in {target}", deviation(position, theirs[1:]), tolerance)

            def by_simulator(command, script=script, exported=exported, frame=frame):
                return clocked(lambda: simulated(script, exported, command, frame))

            rounds = context.rounds(3)
            times = in_turn(rounds, lambda: ours.steps(commands)[0], lambda: by_simulator(long) - by_simulator(short), by=lambda work: work())
            own, other = times[0].scaled(1e6 / len(commands)), times[1].scaled(1e6 / samples)
            lines.append(Line(f"simulators.{target}", "a sample of 5 ms, driven from Python", "us", own, target, other, said))
    return lines, []
