"""`examples/first-steps.ipynb` runs from its first cell to its last, with correct results. It is stored without outputs."""

import json
import os

import nbformat
import pytest
from nbclient import NotebookClient

from actuator_fmu import REPOSITORY
from hidden import product

NOTEBOOK = REPOSITORY / "examples" / "first-steps.ipynb"
TIME_LIMIT_S = 120  # time limit of a cell; the diagnosis takes some seconds
ROUNDING_DEG = 1e-12  # scipy's step response and the FMU's, both of some 1 deg
NOISE_RMS_DEG = 0.02  # noise added by the notebook
# A pole of 10 000 1/s is a lag of 0.1 ms; at the largest rate of the step, about k ω / 2, that is 0.01 deg.
LAG_DEG = 0.01
ASK = """print(json.dumps({"second": step_error["second"], "third": step_error["third"], "rms": rms, "verdict": diagnosis["verdict"],
                  "effects": {effect["name"]: effect["parameters"] for effect in diagnosis["effects"]}, "count": len(effects)}))"""

pytestmark = product.needs_program()


@pytest.fixture(scope="module")
def run(fmu_path, tmp_path_factory):
    """The notebook after a run, and its results, queried by an additional cell."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(ASK))
    # Temporary files of the notebook go to the folder of the test; the kernel's state is separate from the user's.
    folder = tmp_path_factory.mktemp("notebook")
    environment = {"ACTUATOR_PROGRAM": str(product.program()), "ACTUATOR_FMU": str(fmu_path), "TMPDIR": str(folder),
                   "IPYTHONDIR": str(folder / "ipython"), "MPLBACKEND": "module://matplotlib_inline.backend_inline"}  # fmt: skip
    client = NotebookClient(notebook, timeout=TIME_LIMIT_S, kernel_name="python3", resources={"metadata": {"path": NOTEBOOK.parent}})
    client.execute(env=os.environ | environment)
    return notebook, json.loads(notebook.cells[-1].outputs[0].text)


def test_every_code_cell_ran_and_the_pictures_are_there(run):
    notebook, _ = run
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in code)
    assert sum("image/png" in output.get("data", {}) for cell in code for output in cell.outputs) == 3


def test_the_step_is_that_of_the_equation(run):
    _, found = run
    assert found["second"] < ROUNDING_DEG < found["third"] < 1.5 * LAG_DEG
    assert found["count"] == 20


def test_the_play_is_named_and_the_corrected_fmu_leaves_the_noise(run):
    _, found = run
    assert found["verdict"] == "named" and found["effects"].keys() == {"backlash"}
    gap = found["effects"]["backlash"]["gap"]
    assert abs(gap["value"] - 0.15) < 4 * gap["std_error"]
    assert found["rms"]["as given"] > 2 * NOISE_RMS_DEG
    assert found["rms"]["corrected"] == pytest.approx(NOISE_RMS_DEG, rel=0.05)  # 2400 samples determine the rms to 1.4 %


def test_the_notebook_is_stored_without_outputs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    assert all(cell.execution_count is None and not cell.outputs for cell in notebook.cells if cell.cell_type == "code")
