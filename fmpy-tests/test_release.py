"""Requirements of a release: recipes that parse, accepted licences of all crates, one version throughout."""

import json
import re
import shutil
import subprocess
import tomllib

import pytest

from actuator_fmu import REPOSITORY

needs_cargo = pytest.mark.skipif(shutil.which("cargo") is None, reason="no cargo here")


@needs_cargo
def test_every_crate_has_a_licence_that_is_accepted():
    """As in `cargo deny check licenses`: one operand of OR, all operands of AND."""
    allowed = set(tomllib.loads((REPOSITORY / "deny.toml").read_text())["licenses"]["allow"])
    exceptions = tomllib.loads((REPOSITORY / "deny.toml").read_text())["licenses"].get("exceptions", [])
    of_crate = {one["crate"]: set(one["allow"]) for one in exceptions}
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    packages = json.loads(subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout)["packages"]
    refused = []
    for package in packages:
        mine = allowed | of_crate.get(package["name"], set())
        terms = re.split(r"\s+AND\s+", package["license"].replace("/", " OR "))
        if not all(any(one.strip("() ") in mine for one in re.split(r"\s+OR\s+", term)) for term in terms):
            refused.append(f"{package['name']}: {package['license']}")
        assert package["source"] is None or "github.com/rust-lang/crates.io-index" in package["source"], package["source"]
    assert len(packages) > 100 and not refused, refused


def features(*arguments):
    """Package, version -> its features in a build."""
    command = ["cargo", "tree", "--locked", "--prefix", "none", "--format", "{p}\t{f}", *arguments]
    lines = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout.splitlines()
    return {tuple(line.removesuffix(" (*)").split("\t")) for line in lines if line}


@needs_cargo
def test_the_program_alone_is_compiled_as_with_its_tests():
    """A feature required only by a test dependency would cause two builds of all users of that package: `[workspace.dependencies]`."""
    alone, whole = features("-p", "cli", "--edges", "normal,build"), features("--workspace", "--edges", "normal,build,dev")
    assert len(alone) > 100 and not alone - whole, alone - whole


def test_workflows_are_yaml_with_jobs_that_use_what_is_there():
    yaml = pytest.importorskip("yaml")
    for path in sorted((REPOSITORY / ".github" / "workflows").glob("*.yml")):
        workflow = yaml.safe_load(path.read_text())
        assert workflow["jobs"] and workflow["permissions"] == {"contents": "read"}, path.name
        text = path.read_text()
        for script in re.findall(r"run: (\./\w+)", text):
            assert (REPOSITORY / script).is_file(), script
        for tool in re.findall(r"grep -e (\S+)", text):
            assert tool in (REPOSITORY / "fmpy-tests" / "requirements.txt").read_text()


def test_security_page_names_files_that_are_there():
    text = (REPOSITORY / "SECURITY.md").read_text()
    for name in re.findall(r"`([\w./*-]+\.(?:py|rs|toml))`", text):
        assert list(REPOSITORY.glob(name)), name
