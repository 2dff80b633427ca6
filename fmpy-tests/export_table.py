"""Deviation of models in other languages from ours: every target with all 17 sets and with each effect that it supports.

`python fmpy-tests/export_table.py` runs them all, which takes two minutes, and prints the tables of docs/other-simulators.md.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from own_program import PROGRAM

SETS = [f"{surface}-{stage}-{load}" for surface in ("te", "us", "ls") for stage in ("early", "middle", "late")
        for load in ("unloaded", "loaded") if (surface, stage, load) != ("ls", "late", "loaded")]  # fmt: skip

# Strengths at which an effect is visible in a sweep of 2 deg.
EFFECTS = {
    "delay": "time = { value = 0.004, unit = 's' }",
    "command_limit": "min = { value = -1.5, unit = 'deg' }\nmax = { value = 1.2, unit = 'deg' }",
    "command_rate_limit": "up = { value = 60.0, unit = 'deg/s' }\ndown = { value = 80.0, unit = 'deg/s' }",
    "command_dead_zone": "half_width = { value = 0.1, unit = 'deg' }",
    "command_backlash": "gap = { value = 0.2, unit = 'deg' }",
    "asymmetric_gain": "ratio = { value = 0.9, unit = '1' }",
    "gain_drift": "rate = { value = 0.001, unit = '1/s' }",
    "dead_zone": "half_width = { value = 0.1, unit = 'deg' }",
    "amplitude_gain": "cubic = { value = 0.01, unit = '1/deg2' }",
    "hinge_load": "stiffness = { value = 0.1, unit = '1' }\nbias = { value = 0.2, unit = 'deg' }",
    "coulomb_friction": "level = { value = 0.1, unit = 'deg' }",
    "acceleration_limit": "value = { value = 6000.0, unit = 'deg/s2' }",
    "rate_limit": "up = { value = 60.0, unit = 'deg/s' }\ndown = { value = 80.0, unit = 'deg/s' }",
    "position_limit": "min = { value = -1.5, unit = 'deg' }\nmax = { value = 1.2, unit = 'deg' }",
    "backlash": "gap = { value = 0.2, unit = 'deg' }",
    "structural_mode": "frequency = { value = 20.0, unit = 'Hz' }\ndamping = { value = 0.05, unit = '1' }\ngain = { value = 0.2, unit = '1' }",
    "sensor_lag": "time = { value = 0.004, unit = 's' }",
    "sensor_bias": "offset = { value = 0.1, unit = 'deg' }\ndrift = { value = 0.002, unit = 'deg/s' }",
    "chatter": "amplitude = { value = 0.05, unit = 'deg' }\nfrequency = { value = 18.0, unit = 'Hz' }\nphase = { value = 0.3, unit = 'rad' }",
    "quantisation": "step = { value = 0.05, unit = 'deg' }",
}

KNOWN = {
    "c": list(EFFECTS),
    "jsbsim": ["delay", "command_limit", "command_rate_limit", "command_dead_zone", "command_backlash", "backlash", "sensor_lag", "sensor_bias"],
    "mujoco": ["command_limit", "hinge_load", "coulomb_friction", "acceleration_limit", "position_limit"],
    "modelica": ["delay", "command_limit", "command_dead_zone", "asymmetric_gain", "gain_drift", "dead_zone", "amplitude_gain", "hinge_load",
                 "acceleration_limit", "structural_mode", "sensor_lag", "sensor_bias", "chatter"],
}  # fmt: skip
MEASURED = ("c", "jsbsim", "mujoco")

BASE = """[base]
order = 2
k = { value = 1.02, unit = "deg/deg" }
omega = { value = 120.0, unit = "rad/s" }
zeta = { value = 0.6, unit = "1" }
"""


def model_with(effect, folder):
    """A model file of second order with one effect, so that no pole is omitted."""
    path = Path(folder) / f"{effect}.toml"
    path.write_text(BASE + f"\n[effects.{effect}]\n{EFFECTS[effect]}\n".replace("'", '"'))
    return path


def export(model, target, folder, measured=True):
    """The output of `actuator export --json`, and the file."""
    path = Path(folder) / f"{Path(str(model)).stem}.{target}"
    command = [PROGRAM, "export", model, "--to", target, "-o", path, "--force", "--json", *(["--measure", sys.executable] if measured else [])]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), path.read_text()


def percent(said):
    share = 100 * said["deviation"]["share"]
    return f"{share:.2g} %" if share > 1e-9 else "1e-9 % or less"


def main():
    with tempfile.TemporaryDirectory() as folder:
        print("| set | " + " | ".join(MEASURED) + " |\n|" + " --- |" * (1 + len(MEASURED)))
        for name in SETS:
            print(f"| {name} | " + " | ".join(percent(export(name, target, folder)[0]) for target in MEASURED) + " |", flush=True)
        print("\n| effect | " + " | ".join(MEASURED) + " | modelica |\n|" + " --- |" * (2 + len(MEASURED)))
        for effect in EFFECTS:
            cells = [percent(export(model_with(effect, folder), target, folder)[0]) if effect in KNOWN[target] else "refused" for target in MEASURED]
            cells.append("written, not run" if effect in KNOWN["modelica"] else "refused")
            print(f"| `{effect}` | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
