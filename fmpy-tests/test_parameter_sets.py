"""The sets for other tools: `.ssv` files and an `.ssp` system from `actuator`, and the reference data in the FMU (FMI-LS-REF).

An applied set is recognised by the response to a random command, which has to be that of the set and not that of the default.
"""

import os
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import find_components, read_ssd, read_ssv, validate_tree
from lxml import etree

import bact
from actuator_fmu import REPOSITORY
from other_importers import NotHere, positions_from

PROGRAM = os.environ.get("ACTUATOR_PROGRAM", "target/debug/actuator")
TOLERANCE = 1e-9  # relative to the largest position
STEPS = 100
CHOSEN = [bact.BY_NAME["ls-middle-loaded"], bact.STIFFEST]  # neither is the default
DEFAULT = bact.SETS[0]
REFERENCES = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST_NAMESPACE = "{http://fmi-standard.org/fmi-ls-manifest}"
PRINTED_DEG = 1e-12  # the references have all digits of a number, computed differently from the truth here


def actuator(*arguments):
    return subprocess.run([REPOSITORY / PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=REPOSITORY)


@pytest.fixture(scope="module")
def system(fmu_path, tmp_path_factory):
    """Name of a set -> the system in which it is applied."""
    folder = tmp_path_factory.mktemp("systems")

    def path(name):
        ssp = folder / f"{name}.ssp"
        if not ssp.exists():
            run = actuator("build", "--ssp", ssp, "--set", name, "--from", fmu_path)
            assert run.returncode == 0, run.stderr
        return ssp

    return path


def exact(s, commands):
    return bact.respond(s, bact.THIRD, commands, bact.CONTROL_PERIOD_S)[:, 1]


def assert_is_the_response_of(s, commands, positions):
    expected = exact(s, commands)
    assert np.abs(positions - expected).max() <= TOLERANCE * np.abs(expected).max(), s.name
    assert np.abs(positions - exact(DEFAULT, commands)).max() > 0.1, "the set is told from the default"


# The files


@pytest.mark.parametrize("prefix", [None, "actuator"])
def test_every_set_is_a_valid_file_that_names_its_number(tmp_path, prefix):
    run = actuator("sets", "--ssv", tmp_path, *(["--prefix", prefix] if prefix else []))
    assert run.returncode == 0, run.stderr
    assert {p.name for p in tmp_path.iterdir()} == {f"{s.name}.ssv" for s in bact.SETS}
    for s in bact.SETS:
        file = read_ssv(str(tmp_path / f"{s.name}.ssv"), validate=True)  # against the schema of SSP 1.0
        assert file.name == s.name
        assert [(p.name, p.type, p.value) for p in file.parameters] == [
            (f"{prefix}.set_number" if prefix else "set_number", "Integer", str(s.number))
        ]


def test_nothing_is_written_over(tmp_path):
    assert actuator("sets", "--ssv", tmp_path).returncode == 0
    (tmp_path / "te-early-unloaded.ssv").unlink()
    before = (tmp_path / "us-late-loaded.ssv").stat().st_mtime_ns
    refused = actuator("sets", "--ssv", tmp_path)
    assert refused.returncode == 2 and "--force" in refused.stderr
    assert not (tmp_path / "te-early-unloaded.ssv").exists(), "nothing is written in part"
    assert (tmp_path / "us-late-loaded.ssv").stat().st_mtime_ns == before
    assert actuator("sets", "--ssv", tmp_path, "--force").returncode == 0


def test_a_system_is_valid_and_the_same_every_time(fmu_path, system, tmp_path):
    ssp = system("us-late-loaded")
    description = read_ssd(str(ssp), validate=True)  # against the schema of SSP 1.0
    (component,) = find_components(description.system)
    assert component.name == "actuator"
    assert component.parameterBindings[0].source == "resources/us-late-loaded.ssv"
    assert not description.system.connectors
    with zipfile.ZipFile(ssp) as archive:
        assert archive.read(component.source) == Path(fmu_path).read_bytes()
    again = tmp_path / "again.ssp"
    assert actuator("build", "--ssp", again, "--set", "us-late-loaded", "--from", fmu_path).returncode == 0
    assert again.read_bytes() == ssp.read_bytes()
    refused = actuator("build", "--ssp", again, "--from", fmu_path)
    assert refused.returncode == 2 and "--force" in refused.stderr


# In importers


@pytest.mark.parametrize("script", ["import_with_libcosim.py", "import_with_ecos.py"])
@pytest.mark.parametrize("s", CHOSEN, ids=lambda s: s.name)
def test_a_system_loads_in_another_importer_with_its_set_applied(system, tmp_path, rng, script, s):
    commands = rng.uniform(-5, 5, STEPS)
    try:
        (positions,) = positions_from(script, system(s.name), tmp_path, [{"commands": list(commands), "set": s.name}])
    except NotHere as reason:
        pytest.skip(str(reason))
    assert_is_the_response_of(s, commands, positions)


@pytest.mark.parametrize("script, why", [("import_with_libcosim.py", "ssp_parser"), ("import_with_ecos.py", "ssv:Parameter")])
def test_a_parameter_that_is_an_enumeration_ends_these_importers(system, tmp_path, script, why):
    """The reason for `set_number`. If this fails, they now support it, and the files may use `surface`, `stage`, `load_case`."""
    ssp, number = tmp_path / "enumeration.ssp", f'<ssv:Integer value="{DEFAULT.number}"/>'
    with zipfile.ZipFile(system(DEFAULT.name)) as old, zipfile.ZipFile(ssp, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == f"resources/{DEFAULT.name}.ssv":
                text = text.replace(b'"set_number"', b'"surface"')
                text = text.replace(number.encode(), b'<ssv:Enumeration value="trailing_edge"/>')
                assert b"Enumeration" in text
            new.writestr(name, text)
    with pytest.raises((RuntimeError, NotHere)) as refusal:
        positions_from(script, ssp, tmp_path, [{"commands": [1.0], "set": DEFAULT.name}])
    if isinstance(refusal.value, NotHere):
        pytest.skip(str(refusal.value))
    assert why in str(refusal.value)


OUTSIDE = """
    <ssd:Connectors>
      <ssd:Connector name="command" kind="input"><ssc:Real/></ssd:Connector>
      <ssd:Connector name="load" kind="input"><ssc:Real/></ssd:Connector>
    </ssd:Connectors>
    <ssd:Elements>"""
CONNECTIONS = """</ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startConnector="command" endElement="actuator" endConnector="command"/>
      <ssd:Connection startConnector="load" endElement="actuator" endConnector="load"/>
    </ssd:Connections>"""


@pytest.fixture(scope="module")
def system_for_fmpy(system, tmp_path_factory):
    """`simulate_ssp` wants every input of every component connected."""
    path = tmp_path_factory.mktemp("connected") / "connected.ssp"
    with zipfile.ZipFile(system(DEFAULT.name)) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == "SystemStructure.ssd":
                text = text.decode().replace("<ssd:Elements>", OUTSIDE).replace("</ssd:Elements>", CONNECTIONS).encode()
            new.writestr(name, text)
    return str(path)


@pytest.mark.parametrize("s", CHOSEN, ids=lambda s: s.name)
def test_fmpy_applies_a_prefixed_set_to_a_system(system_for_fmpy, tmp_path, rng, s):
    """fmpy passes an input on after the step, so that the component receives it one step late."""
    actuator("sets", "--ssv", tmp_path, "--prefix", "actuator")
    commands, h = rng.uniform(-5, 5, STEPS), bact.CONTROL_PERIOD_S
    result = simulate_ssp(
        system_for_fmpy, stop_time=(STEPS - 0.5) * h, step_size=h, parameter_set=read_ssv(str(tmp_path / f"{s.name}.ssv")),
        input={"command": lambda time: commands[round(time / h)]},
    )  # fmt: skip
    assert_is_the_response_of(s, np.concatenate([[0.0], commands[:-1]]), result["actuator.position"])


# Reference data in the FMU: FMI-LS-REF


@pytest.fixture(scope="module")
def carried(fmu_path):
    """Names and bytes below the folder of the layered standard."""
    with zipfile.ZipFile(fmu_path) as archive:
        start = REFERENCES + "/"
        return {name.removeprefix(start): archive.read(name) for name in archive.namelist() if name.startswith(start)}


def test_the_manifest_says_what_it_is_and_names_every_file(carried):
    manifest = etree.fromstring(carried["fmi-ls-manifest.xml"])
    assert manifest.tag == "fmiReferences"
    assert manifest.attrib[MANIFEST_NAMESPACE + "fmi-ls-name"] == "org.fmi-standard.fmi-ls-ref"
    assert manifest.attrib[MANIFEST_NAMESPACE + "fmi-ls-version"] == "1.0.0-beta.1"
    assert {related.get("source") for related in manifest} == set(carried) - {"fmi-ls-manifest.xml"}
    roles = [related.get("role") for related in manifest]
    assert (roles.count("parameter"), roles.count("result"), roles.count("experiment/smoke-test")) == (17, 17, 1)


def test_the_parameter_sets_are_those_that_the_program_writes(carried, tmp_path):
    actuator("sets", "--ssv", tmp_path)
    for s in bact.SETS:
        assert carried[f"{s.name}.ssv"] == (tmp_path / f"{s.name}.ssv").read_bytes()
        validate_tree(etree.fromstring(carried[f"{s.name}.ssv"]), "SystemStructureParameterValues.xsd")


def experiments(carried):
    return etree.fromstring(carried["step-responses.exp"]).findall("Experiment")


def table(carried, element):
    return np.genfromtxt(BytesIO(carried[element.get("source")]), delimiter=",", names=True)


def test_every_reference_is_the_exact_response(carried):
    """The truth is from partial fractions, which share nothing with the program."""
    names = []
    for experiment in experiments(carried):
        s = bact.BY_NAME[experiment.get("name").removesuffix("-step")]
        step_s = float(experiment.find("TransientSimulation").get("stepSize"))
        stimulus, reference = table(carried, experiment.find("Stimuli")), table(carried, experiment.find("References"))
        held = [stimulus["command"][stimulus["time"] <= t][-1] for t in reference["time"]]
        states = bact.respond(s, bact.THIRD, held[:-1], step_s)
        assert np.abs(reference["position"][1:] - states[:, 1]).max() <= PRINTED_DEG
        assert reference["time"][-1] == float(experiment.find("TransientSimulation").get("stopTime"))
        names.append(s.name)
    assert names == [s.name for s in bact.SETS]


def test_every_experiment_can_be_done_with_what_the_fmu_carries(fmu_path, carried):
    """As a tool would do: parameter set, command and times of the experiment, in fmpy; the response equals the reference."""
    for experiment in experiments(carried):
        times = experiment.find("TransientSimulation").attrib
        values = read_ssv(BytesIO(carried[experiment.find("Parameters").get("source")]))
        result = fmpy.simulate_fmu(
            str(fmu_path), start_time=float(times["startTime"]), stop_time=float(times["stopTime"]),
            step_size=float(times["stepSize"]), output_interval=float(times["stepSize"]),
            start_values={p.name: int(p.value) for p in values.parameters},
            input=table(carried, experiment.find("Stimuli")), output=["position"],
        )  # fmt: skip
        reference = table(carried, experiment.find("References"))
        last = np.unique(result["time"].round(9), return_index=True)[1]  # fmpy outputs the instant of a step twice
        assert np.abs(result["time"][last] - reference["time"]).max() <= 1e-9
        assert np.abs(result["position"][last] - reference["position"]).max() <= 1e-9, experiment.get("name")
