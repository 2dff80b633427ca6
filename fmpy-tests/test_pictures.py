"""Plots, demo and first script run as given in the README, and report their results."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bact
import pictures
from actuator_fmu import selection
from frequency_sweep import measure

HERE = Path(__file__).parent
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
SMALLEST_PICTURE = 20_000  # bytes; an empty plot is smaller


def assert_picture(path):
    data = path.read_bytes()
    assert data.startswith(PNG_SIGNATURE) and len(data) > SMALLEST_PICTURE


def run(script, *arguments, **options):
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    return subprocess.run(
        [sys.executable, "-B", str(HERE / script), *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment,
        **options,
    )


@pytest.mark.parametrize("surface", pictures.TITLES)
def test_a_picture_per_surface_is_drawn(shared, rng, output_folder, surface):
    measured = {s.name: measure(shared, s, bact.THIRD, rng) for s in bact.SETS if s.surface == surface}
    path = output_folder / f"frequency-response-{bact.INITIALS[surface]}.png"
    assert_picture(pictures.frequency_response_picture(surface, measured, path))


def test_the_step_responses_are_drawn(shared, output_folder):
    times = np.arange(0, pictures.STEP_TIME_S, bact.CONTROL_PERIOD_S)
    measured = {}
    for s in bact.SETS:
        shared.restart(selection(s, bact.THIRD))
        measured[s.name] = np.append(0.0, shared.run(np.ones(len(times) - 1), bact.CONTROL_PERIOD_S))
    assert_picture(pictures.step_response_picture(times, measured, output_folder / "step-response.png"))


def test_the_demo_finds_all_sets_good_and_says_where_the_pictures_are(fmu_path, tmp_path):
    demo = run("demo.py", "--fmu", fmu_path, "-o", tmp_path)
    assert demo.returncode == 0, demo.stdout + demo.stderr
    assert all(s.name in demo.stdout for s in bact.SETS)
    for name in ("frequency-response-te", "frequency-response-us", "frequency-response-ls", "step-response"):
        assert_picture(tmp_path / f"{name}.png")
        assert str(tmp_path / f"{name}.png") in demo.stdout


def test_the_demo_without_an_fmu_says_how_to_build_one(tmp_path):
    demo = run("demo.py", "--fmu", tmp_path / "none.fmu", "-o", tmp_path)
    assert demo.returncode == 2 and "cargo" in demo.stderr


def test_the_first_script_runs_as_it_stands(fmu_path, tmp_path):
    """From the repository's folder, as in the README; here from a folder with the same layout."""
    (tmp_path / "target" / "fmu").mkdir(parents=True)
    (tmp_path / "target" / "fmu" / "BactActuator.fmu").symlink_to(fmu_path)
    script = run("first_script.py", cwd=tmp_path)
    assert script.returncode == 0, script.stderr
    assert_picture(tmp_path / "us-late-loaded.png")
