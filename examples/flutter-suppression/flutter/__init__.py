"""Flutter suppression on the BACT wing: the wing, its control law, the actuator FMU in the loop, and what reduces the margin.

Read in this order: `wing` (equations), `linear` (eigenvalues and exact delay margins), `loop` (the FMU in the loop),
`modes` (damping measured from a time response), `limit_cycles` (backlash), `recovery` (rate limit), `system` (two FMUs, SSP).
"""

import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
EXAMPLE = REPOSITORY / "examples" / "flutter-suppression"
OUTPUT = REPOSITORY / "target" / "flutter-suppression"

# The actuator's tables, its wrapper for fmpy and the describing functions are in the folder of the FMU's tests.
sys.path.insert(0, str(REPOSITORY / "fmpy-tests"))
