"""A rig of another structure than any model of the product: what `actuator diagnose` says of healthy repeats, and of one with a limit.

    python fmpy-tests/demo_rigs.py PROGRAM FOLDER
"""

import subprocess
import sys
from pathlib import Path

from hidden import product

# A motor under a PI loop, by the seeds of the suite of hidden effects.
STORIES = {
    "rig_healthy": (120057, "Healthy: records and model are of the same motor, on other days"),
    "rig_effect": (120246, "The same kind of motor, its command limited"),
}


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    for kind, (seed, story) in STORIES.items():
        case = folder / kind
        truth, arguments = product.write_case(kind, seed, case)
        hidden = ", ".join(f"{effect}: {values}" for effect, values in truth["effects"].items()) or "nothing"
        print(f"{story}. Hidden: {hidden}", flush=True)
        subprocess.run([program, "diagnose", *arguments, "-o", case / "diagnosis", "--force"], cwd=case, check=True)


if __name__ == "__main__":
    main()
