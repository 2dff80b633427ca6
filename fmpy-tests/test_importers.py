"""Other importers step the FMU like fmpy does: libcosim and Ecos, which see no enumerations and so use `set_number`."""

import numpy as np
import pytest

import bact
from other_importers import NotHere, positions_from

TOLERANCE = 1e-9  # relative to the largest position
STEPS = 200
CHOSEN = [bact.SETS[0], bact.BY_NAME["te-late-loaded"], bact.STIFFEST]


@pytest.mark.parametrize("script", ["import_with_libcosim.py", "import_with_ecos.py"])
def test_another_importer_measures_the_exact_response(fmu_path, tmp_path, rng, script):
    """Held random commands at 200 Hz. Ecos sets the input ahead of a step, libcosim as well: no step of delay in either."""
    commands = [rng.uniform(-5, 5, STEPS) for _ in CHOSEN]
    runs = [{"integers": {"set_number": s.number}, "commands": list(c)} for s, c in zip(CHOSEN, commands)]
    try:
        measured = positions_from(script, fmu_path, tmp_path, runs)
    except NotHere as reason:
        pytest.skip(str(reason))
    for s, command, positions in zip(CHOSEN, commands, measured):
        exact = bact.respond(s, bact.THIRD, command, bact.CONTROL_PERIOD_S)[:, 1]
        assert np.abs(positions - exact).max() <= TOLERANCE * np.abs(exact).max(), s.name
