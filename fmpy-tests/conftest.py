"""Fixtures: the packaged FMU, unpacked once; instances of it; a folder for pictures; printed seeds."""

import os
import sys
import zlib
from pathlib import Path
from types import SimpleNamespace

# Before numpy reads it. The matrices here are small: threads of OpenBLAS busy-wait for each other on processors that other tests need, and use
# six times the processor time of one thread. One thread also makes the bits of a sum independent of the number of processors.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib  # noqa: E402
import numpy as np  # noqa: E402
import pytest  # noqa: E402

sys.path.insert(0, str(Path(__file__).parent))
matplotlib.use("Agg")

from actuator_fmu import DEFAULT_FMU, REPOSITORY, Actuator, unpacked  # noqa: E402
import schemas  # noqa: E402
from hidden import cases, files, product, scoring  # noqa: E402

SEED = int(os.environ.get("ACTUATOR_SEED", "208452"))
OUTPUT = REPOSITORY / "target" / "fmpy-tests"


def pytest_report_header():
    return f"FMU {fmu_file()}, seed {SEED} (another one: ACTUATOR_SEED=n), pictures in {OUTPUT}"


def fmu_file():
    return Path(os.environ.get("ACTUATOR_FMU", DEFAULT_FMU)).resolve()


@pytest.fixture(scope="session")
def fmu_path():
    """The packaged FMU. If it is missing, tests fail instead of being skipped: a suite that tests nothing must not pass."""
    path = fmu_file()
    if not path.is_file():
        pytest.fail(
            f"No FMU at {path}. Build it with `cargo run -p fmu-build` in {REPOSITORY},"
            " or name another one: ACTUATOR_FMU=/path/to/BactActuator.fmu",
            pytrace=False,
        )
    return path


@pytest.fixture(scope="session")
def package(fmu_path):
    """The FMU unpacked, once per session."""
    with unpacked(fmu_path) as package:
        yield package


@pytest.fixture
def actuator(package):
    """A fresh instance, in the state after instantiation."""
    with Actuator(package) as actuator:
        yield actuator


@pytest.fixture(scope="module")
def shared(package):
    """One instance for all tests of a module: `shared.restart(...)` first. `fmi2Reset` is thus tested as well."""
    with Actuator(package) as actuator:
        yield actuator


@pytest.fixture
def rng(request):
    """Random numbers for this test: they depend on the seed and on the test's name. Both are printed."""
    print(f"seed {SEED}, {request.node.name}")
    return np.random.default_rng([SEED, zlib.crc32(request.node.name.encode())])


@pytest.fixture(scope="session")
def output_folder():
    OUTPUT.mkdir(parents=True, exist_ok=True)
    return OUTPUT


@pytest.fixture(scope="session")
def diagnosed(tmp_path_factory):
    """(kind, seed) -> a case with its truth, diagnosis, score and folder; each is diagnosed once."""
    known = {}

    def get(kind, seed):
        if (kind, seed) not in known:
            folder = tmp_path_factory.mktemp(f"{kind}-{seed}")
            case = cases.draw(seed, kind)
            files.write(case, folder)
            diagnosis, _ = product.diagnose(product.program(), folder)
            schemas.check("diagnose", diagnosis)
            truth = files.truth(case)
            score = scoring.score(truth, diagnosis)
            print(f"{kind} {seed}: {truth['enr_of']} {case.effects}; said {diagnosis['verdict']} {score['named']}")
            known[kind, seed] = SimpleNamespace(case=case, truth=truth, diagnosis=diagnosis, score=score, folder=folder)
        return known[kind, seed]

    return get
