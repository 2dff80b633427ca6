"""The FMU with binaries for all platforms: its contents, the required glibc, and the Windows binary run by wine.

The FMU for all platforms takes minutes to build, so it is not part of `./test`: docs/platforms.md has the commands. Its tests use the
result, and are skipped if there is none, or none of the present sources. The FMU of this run is checked as well.
"""

import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from platform import machine

import fmpy
import numpy as np
import pytest

import bact
from actuator_fmu import REPOSITORY, Actuator, Package

FMU = Path(os.environ.get("ACTUATOR_PLATFORM_FMU", REPOSITORY / "target" / "platforms" / "BactActuator.fmu"))
HERE = Path(__file__).parent
LIBRARIES = {"linux64": "so", "aarch64-linux": "so", "win64": "dll", "darwin64": "dylib"}
OLDEST_GLIBC = (2, 17)  # RHEL 7, manylinux2014
STEPS = 2000  # ten seconds of each set
TOLERANCE = 1e-12  # relative; other mathematical libraries round exp, sin and cos differently
WINE_PLACES = ("wine64", "/usr/lib/wine/wine64", "wine")
PATIENCE_S = 300

ELF_X86_64, ELF_AARCH64, PE_X86_64 = 62, 183, 0x8664  # processors in the headers of binaries
MACHO_X86_64, MACHO_ARM64 = 0x01000007, 0x0100000C


@pytest.fixture(scope="module")
def everywhere(package, tmp_path_factory):
    """The FMU for all platforms, unpacked."""
    if not FMU.is_file():
        pytest.skip(f"no {FMU}: `fmu-build --platform all -o {FMU} --force` (docs/platforms.md)")
    everywhere = Package(FMU, tmp_path_factory.mktemp("everywhere"))
    if everywhere.description.guid != package.description.guid:
        pytest.skip(f"{FMU} was made from other sources: build it again (docs/platforms.md)")
    return everywhere


def binary(everywhere, platform):
    return everywhere.directory / "binaries" / platform / f"BactActuator.{LIBRARIES[platform]}"


def test_every_binary_is_for_the_processor_of_its_folder(everywhere):
    with zipfile.ZipFile(FMU) as archive:
        folders = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert folders == {*LIBRARIES, "aarch64-darwin"}
    for platform, processor in (("linux64", ELF_X86_64), ("aarch64-linux", ELF_AARCH64)):
        head = binary(everywhere, platform).read_bytes()[:20]
        assert head[:4] == b"\x7fELF" and struct.unpack_from("<H", head, 18) == (processor,), platform
    windows = binary(everywhere, "win64").read_bytes()
    (start,) = struct.unpack_from("<I", windows, 0x3C)
    assert windows[start : start + 4] == b"PE\0\0" and struct.unpack_from("<H", windows, start + 4) == (PE_X86_64,)
    mac = binary(everywhere, "darwin64").read_bytes()
    magic, count = struct.unpack_from(">II", mac)
    assert (magic, count) == (0xCAFEBABE, 2), "a universal binary of two"
    for index, processor in enumerate((MACHO_X86_64, MACHO_ARM64)):
        found, _, offset, size, alignment = struct.unpack_from(">5I", mac, 8 + 20 * index)
        assert found == processor and offset % 2**alignment == 0 and offset + size <= len(mac)
        assert struct.unpack_from("<II", mac, offset) == (0xFEEDFACF, processor)
    # For readers on a Mac with an ARM processor that look only there: the second part alone.
    alone = (everywhere.directory / "binaries" / "aarch64-darwin" / "BactActuator.dylib").read_bytes()
    assert alone == mac[offset : offset + size]


@pytest.mark.parametrize("platform", ["linux64", "aarch64-linux"])
def test_a_linux_binary_needs_no_newer_glibc_and_nothing_else(everywhere, platform):
    assert_needs_an_old_glibc_alone(binary(everywhere, platform), platform)


@pytest.mark.skipif(sys.platform != "linux" or machine() != "x86_64" or shutil.which("cargo-zigbuild") is None,
                    reason="not linked by zig, as ./test does on x86-64 Linux")  # fmt: skip
def test_the_fmu_of_this_run_loads_on_old_computers(package):
    """The FMU that all other tests step."""
    assert_needs_an_old_glibc_alone(package.directory / "binaries" / "linux64" / "BactActuator.so", "linux64")


def assert_needs_an_old_glibc_alone(library, platform):
    if shutil.which("objdump") is None:
        pytest.skip("objdump is not here (Debian: apt install binutils)")
    if platform == "aarch64-linux" and "aarch64" not in subprocess.run(["objdump", "-i"], capture_output=True, text=True).stdout:
        # The version names are plain strings in the file, so that they can be read without objdump.
        symbols = library.read_bytes().decode("latin-1")
    else:
        listing = ["objdump", "-p", "-T", str(library)]
        symbols = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
        needed = set(re.findall(r"NEEDED\s+(\S+)", symbols))
        assert all(re.match(r"(lib(c|m|dl|pthread)|ld-linux.*)\.so", name) for name in needed), needed
    versions = {tuple(map(int, version.split(".")[:2])) for version in re.findall(r"GLIBC_(\d+\.\d+)", symbols)}
    assert versions and max(versions) <= OLDEST_GLIBC


def command(number, step):
    """As in step_all_sets.c: multiples of 1/200 deg between -5 and 5."""
    return ((step * 7919 + number * 104729) % 2001 - 1000) / 200.0


def commands(s, steps=STEPS):
    return np.array([command(s.number, step) for step in range(steps)])


def here(everywhere):
    """Positions of all sets in this computer's binary of the same FMU."""
    for s in bact.SETS:
        with Actuator(everywhere) as actuator:
            yield actuator.initialize({"set_number": s.number}).run(commands(s), bact.CONTROL_PERIOD_S)


@pytest.fixture(scope="module")
def positions_here(everywhere):
    if sys.platform != "linux" or fmpy.architecture != "x86_64":
        pytest.skip("this computer runs none of the binaries that are compared")
    return list(here(everywhere))


def test_the_binary_for_old_linuxes_answers_exactly(positions_here):
    for s, positions in zip(bact.SETS, positions_here):
        exact = bact.respond(s, bact.THIRD, commands(s), bact.CONTROL_PERIOD_S)[:, 1]
        assert np.abs(positions - exact).max() <= TOLERANCE * np.abs(exact).max(), s.name


def compile_for_windows(source, target):
    """With mingw or zig, whichever is available."""
    try:
        import ziglang  # noqa: F401
    except ImportError:
        zig = []
    else:
        zig = [[sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu"]]
    other_zig = shutil.which("python-zig")
    mingw = shutil.which("x86_64-w64-mingw32-gcc")
    compilers = ([[mingw]] if mingw else []) + zig + ([[other_zig, "cc", "-target", "x86_64-windows-gnu"]] if other_zig else [])
    if not compilers:
        pytest.skip("no compiler for Windows (Debian: apt install gcc-mingw-w64-x86-64-posix, or pip install ziglang)")
    subprocess.run([*compilers[0], "-O1", "-o", str(target), str(HERE / source)], check=True, timeout=PATIENCE_S)


def test_the_windows_binary_answers_as_that_of_linux(everywhere, positions_here, tmp_path):
    """Run by wine: all 17 sets, 2000 steps each, to the last digits."""
    wine = next(filter(None, map(shutil.which, WINE_PLACES)), None)
    if wine is None:
        pytest.skip("wine is not here (Debian: apt install wine64)")
    library = tmp_path / "BactActuator.dll"
    shutil.copy(binary(everywhere, "win64"), library)
    compile_for_windows("step_all_sets.c", tmp_path / "step_all_sets.exe")
    references = [str(everywhere.variables[name].valueReference) for name in ("command", "position", "set_number")]
    run = subprocess.run(
        [wine, "step_all_sets.exe", library.name, everywhere.description.guid, str(STEPS), *references],
        capture_output=True, text=True, cwd=tmp_path, timeout=PATIENCE_S,
        env={**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    bits = np.array([int(line, 16) for line in run.stdout.split()], dtype=np.uint64)
    windows = bits.view(np.float64).reshape(len(bact.SETS), STEPS)
    linux = np.array(positions_here)
    apart = np.abs(windows - linux).max(axis=1) / np.abs(linux).max(axis=1)
    print(f"{(windows == linux).sum()} of {windows.size} positions are the same to the bit, the others within {apart.max():.1e}")
    assert apart.max() <= TOLERANCE, bact.SETS[int(apart.argmax())].name
