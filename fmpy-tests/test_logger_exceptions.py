"""A logger written in C++ that throws: its exception reaches the host, and the instance remains usable."""

import pathlib
import shutil
import subprocess
import sys

import pytest

HOST = pathlib.Path(__file__).parent / "logging_host.cpp"


@pytest.mark.skipif(sys.platform != "linux" or shutil.which("c++") is None, reason="no C++ compiler of this system")
def test_an_exception_of_the_logger_reaches_the_host(package, tmp_path):
    program = tmp_path / "host"
    subprocess.run(["c++", "-O1", "-o", program, HOST, "-ldl"], check=True)
    library = package.directory / "binaries" / "linux64" / "BactActuator.so"
    ran = subprocess.run([program, library, package.description.guid], capture_output=True, text=True, timeout=60)
    assert (ran.returncode, ran.stdout) == (0, "caught 4, then status 0\n"), ran.stderr
