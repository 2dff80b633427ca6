"""All importers step the FMU alike: a quick part of `importer_table.py`, whose table is in docs/importers.md."""

import pytest

import bact
from importer_table import END, IMPORTERS, PAGE, START, TOLERANCE, measure
from other_importers import NotHere

STEPS = 200
CHOSEN = [bact.SETS[0], bact.BY_NAME["te-late-loaded"], bact.STIFFEST]


@pytest.mark.parametrize("importer", IMPORTERS, ids=lambda importer: importer.name)
def test_an_importer_measures_the_exact_response(fmu_path, tmp_path, importer):
    """Held random commands at 200 Hz. All of them set the input before a step: none has a delay of a step."""
    try:
        exact, inside = measure(importer, fmu_path, tmp_path, CHOSEN, STEPS)
    except NotHere as reason:
        pytest.skip(str(reason))
    assert exact <= TOLERANCE and inside <= TOLERANCE


def test_the_table_of_the_documentation_names_these_importers_and_all_of_them_within_the_tolerance():
    written = PAGE.read_text().split(START)[1].split(END)[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in written.strip().splitlines()[2:]]
    assert [row[0] for row in rows] == [importer.name for importer in IMPORTERS]
    for name, _, _, exact, inside in rows:
        assert exact.startswith("not run") or max(float(exact), float(inside)) <= TOLERANCE, name
