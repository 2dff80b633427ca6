"""Kills at random moments, full disks, read-only folders: a few of them; `interruptions.py` runs many."""

import os
import random

import pytest

import interruptions
from conftest import SEED
from hidden import product

pytestmark = product.needs_program()


@pytest.fixture
def random_moments():
    print(f"seed {SEED}")
    return random.Random(SEED)


def test_a_killed_campaign_is_whole_and_goes_on_to_the_same_end(tmp_path, random_moments):
    assert interruptions.kill_campaigns(6, random_moments, tmp_path, records=3) > 0


def test_a_killed_build_leaves_the_old_fmu_or_the_new_one(fmu_path, tmp_path, random_moments):
    interruptions.kill_builds(6, random_moments, tmp_path)


def test_what_does_not_fit_on_the_disk_leaves_what_was_there(fmu_path, tmp_path):
    interruptions.fill_disk(tmp_path, 100_000)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_to_is_said(fmu_path, tmp_path):
    tmp_path.chmod(0o500)
    done = interruptions.run("build", "--from", fmu_path, "--model", "us-late-loaded", "-o", tmp_path / "model.fmu")
    assert done.returncode > 0 and "found" in done.stderr and "allowed" in done.stderr, done.stderr


def test_a_path_below_a_file_is_said(fmu_path, tmp_path):
    """As a read-only folder, for any user who runs this test."""
    (tmp_path / "file").write_text("earlier")
    done = interruptions.run("build", "--from", fmu_path, "--model", "us-late-loaded", "-o", tmp_path / "file" / "model.fmu")
    assert done.returncode > 0 and "found" in done.stderr and "allowed" in done.stderr, done.stderr
    assert (tmp_path / "file").read_text() == "earlier"
