"""The FMU as distributed: archive, description, binary; valid, complete, and runnable by fmpy without changes."""

import struct
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import bact
from effect_cases import dotted
from fmi2_names import CO_SIMULATION, COMMON, MODEL_EXCHANGE
from reference.plant import NEUTRAL

IDENTIFIER = "BactActuator"
CONTENTS = ("modelDescription.xml", f"binaries/linux64/{IDENTIFIER}.so", "model.png", "documentation/index.html")
ZIP_MODE = 0o100644  # a regular file, readable by all, writable by its owner
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
EFFECT_UNITS = {  # of every effect parameter, in the order of the chain
    "delay.time": "s", "command_limit.min": "deg", "command_limit.max": "deg", "command_rate_limit.up": "deg/s",
    "command_rate_limit.down": "deg/s", "command_dead_zone.half_width": "deg", "command_backlash.gap": "deg",
    "asymmetric_gain.ratio": "1", "gain_drift.rate": "1/s", "dead_zone.half_width": "deg", "amplitude_gain.cubic": "1/deg2",
    "hinge_load.stiffness": "1", "hinge_load.bias": "deg", "coulomb_friction.level": "deg", "acceleration_limit.value": "deg/s2",
    "rate_limit.up": "deg/s", "rate_limit.down": "deg/s", "position_limit.min": "deg", "position_limit.max": "deg",
    "backlash.gap": "deg", "structural_mode.frequency": "Hz", "structural_mode.damping": "1", "structural_mode.gain": "1",
    "sensor_lag.time": "s", "sensor_bias.offset": "deg", "sensor_bias.drift": "deg/s", "chatter.amplitude": "deg",
    "chatter.frequency": "Hz", "chatter.phase": "rad", "quantisation.step": "deg",
}  # fmt: skip
DEG = np.pi / 180.0
SI = {"deg": DEG, "deg/s": DEG, "deg/s2": DEG, "1/deg2": DEG**-2, **dict.fromkeys(("s", "1/s", "Hz", "rad", "rad/s", "1"), 1.0)}
UNITS = EFFECT_UNITS | {
    "load": "deg",
    "command": "deg", "position": "deg", "deflection": "deg", "rate": "deg/s", "initial_position": "deg",
    "custom.k": "deg/deg", "custom.p": "1/s", "custom.omega": "rad/s", "custom.zeta": "1",
    "active.k": "deg/deg", "active.p": "1/s", "active.omega": "rad/s", "active.zeta": "1",
}  # fmt: skip
ITEMS = {
    "surface": ["trailing_edge", "upper_spoiler", "lower_spoiler"],
    "stage": ["early", "middle", "late"],
    "load_case": ["unloaded", "loaded"],
    "order": ["second", "third"],
    "source": ["table", "custom"],
    "failure": ["none", "passive", "stuck", "hardover_positive", "hardover_negative"],
}
CAUSALITIES = {
    **{name: ("parameter", "fixed") for name in (*ITEMS, "set_number", "initial_position")},
    **{name: ("parameter", "tunable") for name in EFFECT_UNITS},
    **{f"custom.{name}": ("parameter", "tunable") for name in ("k", "p", "omega", "zeta")},
    **{name: ("input", "continuous") for name in ("command", "load")},
    "failure": ("input", "discrete"),
    "saturated": ("output", "discrete"),
    **{name: ("output", "continuous") for name in ("position", "deflection", "rate")},
}
STATES = {  # continuous states, in their order, and the units of their derivatives
    "drive.target": ("deg", "deg/s"), "drive.position": ("deg", "deg/s"), "drive.rate": ("deg/s", "deg/s2"),
    "backlash.surface": ("deg", "deg/s"), "structural_mode.position": ("deg", "deg/s"),
    "structural_mode.rate": ("deg/s", "deg/s2"), "sensor_lag.reading": ("deg", "deg/s"),
}  # fmt: skip
LOCALS = {name: units[0] for name, units in STATES.items()} | {f"der({name})": units[1] for name, units in STATES.items()}
CAUSALITIES |= {name: ("local", "continuous") for name in LOCALS}
UNITS |= LOCALS
CAPABILITIES = (
    "canHandleVariableCommunicationStepSize", "canInterpolateInputs", "canGetAndSetFMUstate", "canSerializeFMUstate",
    "providesDirectionalDerivative",
)  # fmt: skip


@pytest.fixture(scope="module")
def archive(fmu_path):
    with zipfile.ZipFile(fmu_path) as archive:
        yield archive


# The archive


def test_the_validator_finds_nothing(fmu_path):
    assert validate_fmu(str(fmu_path)) == []


def test_the_archive_is_complete(archive):
    names = set(archive.namelist())
    assert set(CONTENTS) <= names
    assert any("licen" in name.lower() for name in names), "no licence"
    assert archive.read("model.png").startswith(PNG_SIGNATURE)
    assert b"NASA/TM-1998-208452" in archive.read("documentation/index.html")


def test_the_archive_is_sound_and_plain(archive):
    """Deflated files only, forward slashes, mode 0644, no duplicates, no path outside the folder."""
    assert archive.testzip() is None
    names = archive.namelist()
    assert len(names) == len(set(names))
    for entry in archive.infolist():
        assert "\\" not in entry.orig_filename and ".." not in entry.filename and not entry.filename.startswith("/")
        assert not entry.is_dir(), entry.filename
        assert entry.compress_type == zipfile.ZIP_DEFLATED, entry.filename
        assert entry.external_attr >> 16 in (ZIP_MODE, ZIP_MODE & 0o777), f"{entry.filename}: {entry.external_attr >> 16:o}"


# The description


def test_the_description_says_what_this_is(package):
    description = package.description
    assert (description.fmiVersion, description.modelName, package.identifier) == ("2.0", IDENTIFIER, IDENTIFIER)
    assert description.variableNamingConvention == "structured"
    assert description.modelExchange.modelIdentifier == IDENTIFIER
    assert description.guid and description.description and description.generationTool


@pytest.mark.parametrize("capability", CAPABILITIES)
def test_the_description_declares(package, capability):
    assert getattr(package.description.coSimulation, capability) is True


@pytest.mark.parametrize("capability", ["canGetAndSetFMUstate", "canSerializeFMUstate", "canNotUseMemoryManagementFunctions"])
def test_the_description_declares_for_model_exchange(package, capability):
    assert getattr(package.description.modelExchange, capability) is True


def test_the_description_declares_for_model_exchange_what_is_so(package):
    """Directional derivatives are provided, and the delay needs notification of completed steps."""
    declared = package.description.modelExchange
    assert declared.providesDirectionalDerivative is True and declared.needsCompletedIntegratorStep is True


def test_outputs_declare_the_inputs_that_their_directional_derivatives_have(package):
    """∂position/∂command over a step is not zero, so that the dependency is declared."""
    declared = {unknown.variable.name: {known.name for known in unknown.dependencies} for unknown in package.description.outputs}
    for output in ("position", "deflection", "rate"):
        assert {"command", "load"} <= declared[output], output


def test_every_state_has_its_derivative(package):
    derivatives = [unknown.variable for unknown in package.description.derivatives]
    assert [variable.name for variable in derivatives] == [f"der({name})" for name in STATES]
    assert [variable.derivative.name for variable in derivatives] == list(STATES)
    assert package.description.numberOfContinuousStates == len(STATES)


def test_the_description_does_not_declare_what_crashes_importers(archive):
    """Two importers fail on `canHandleMultipleSetPerTimeInstant`, which FMI 2.0 defines for model exchange only."""
    assert b"canHandleMultipleSetPerTimeInstant" not in archive.read("modelDescription.xml")


def test_every_variable_is_described(package):
    assert not [name for name, variable in package.variables.items() if not variable.description]


@pytest.mark.parametrize("name, unit", UNITS.items())
def test_every_quantity_has_its_unit(package, name, unit):
    variable = package.variables[name]
    assert (variable.unit or variable.declaredType.unit) == unit
    assert unit in {u.name for u in package.description.unitDefinitions}


@pytest.mark.parametrize("name, items", ITEMS.items())
def test_enumerations_are_numbered_from_one(package, name, items):
    assert package.items(name) == {item: number for number, item in enumerate(items, start=1)}


@pytest.mark.parametrize("name, kind", CAUSALITIES.items())
def test_every_variable_is_what_it_is_meant_to_be(package, name, kind):
    variable = package.variables[name]
    assert (variable.causality, variable.variability) == kind


def test_active_parameters_are_calculated(package):
    for name in ("k", "p", "omega", "zeta"):
        assert package.variables[f"active.{name}"].causality == "calculatedParameter"


def test_ranges_are_stated_where_values_have_one(package):
    """0 to 17 for the row of a table; positive pole, frequency and damping."""
    variables = package.variables
    assert (float(variables["set_number"].min), float(variables["set_number"].max)) == (0, len(bact.SETS))
    for name in ("p", "omega", "zeta"):
        assert float(variables[f"custom.{name}"].min) >= 0, name


def test_units_convert_to_si_units(package):
    """The factor of each unit, to the last bit but one: an importer converts with it."""
    factors = {unit.name: unit.baseUnit.factor or 1.0 for unit in package.description.unitDefinitions if unit.baseUnit}
    for unit, factor in SI.items():
        assert abs(float(factors[unit]) / factor - 1.0) <= 4e-16, unit


def test_the_variables_are_those_of_the_tables_and_no_others(package):
    active = {f"active.{name}" for name in ("k", "p", "omega", "zeta")}
    assert set(package.variables) == set(CAUSALITIES) | active


def test_effects_come_in_the_order_of_the_chain_and_start_neutral(package):
    """Every effect is inactive until it is set: the start values are the neutral ones of the reference."""
    found = {name: float(v.start) for name, v in package.variables.items() if name in EFFECT_UNITS}
    assert list(found) == list(EFFECT_UNITS)
    assert found == dotted(NEUTRAL)


def test_every_effect_parameter_says_its_range(package):
    for name in EFFECT_UNITS:
        variable = package.variables[name]
        assert variable.min is not None and variable.max is not None and float(variable.nominal) > 0, name


def test_all_that_can_be_set_has_a_start_value(package):
    """Inputs and parameters of every type; `test_selection.py` compares them with the binary's."""
    for name, variable in package.variables.items():
        assert (variable.start is not None) == (variable.causality in ("input", "parameter")), name


def test_every_start_value_lies_in_its_range(package):
    for name, variable in package.variables.items():
        if variable.start is not None and variable.type in ("Real", "Integer", "Enumeration"):
            low, high = variable.min, variable.max
            assert low is None or float(low) <= float(variable.start), name
            assert high is None or float(variable.start) <= float(high), name


# The binary


def exported_symbols(library):
    """Names exported by an ELF shared library: its dynamic symbol table, without imported and local symbols."""
    data = library.read_bytes()
    assert data[:6] == b"\x7fELF\x02\x01", "64 bit, little-endian ELF"
    (section_table,) = struct.unpack_from("<Q", data, 0x28)
    entry_size, count = struct.unpack_from("<HH", data, 0x3A)
    headers = [struct.unpack_from("<IIQQQQIIQQ", data, section_table + i * entry_size) for i in range(count)]
    (symbols,) = (h for h in headers if h[1] == 11)  # SHT_DYNSYM: offset [4], size [5], its string table [6]
    strings = headers[symbols[6]][4]
    names = set()
    for offset in range(symbols[4], symbols[4] + symbols[5], 24):
        name, info, _, section = struct.unpack_from("<IBBH", data, offset)
        if section != 0 and info >> 4 in (1, 2):  # defined here, and global or weak
            names.add(data[strings + name : data.index(b"\0", strings + name)].decode())
    return names


def test_the_binary_exports_the_functions_of_the_standard_and_nothing_else(package):
    """Additional symbols could clash with another FMU in the same process; with missing ones an importer refuses to load."""
    assert exported_symbols(package.library) == COMMON | CO_SIMULATION | MODEL_EXCHANGE


def test_the_binary_depends_on_the_c_library_only(package):
    """Loadable on any Linux: no Rust, no C++, nothing to install."""
    data = package.library.read_bytes()
    assert b"libstdc++" not in data and b"libstd-" not in data


# As a whole


@pytest.mark.parametrize("order", bact.ORDERS)
def test_fmpy_simulates_a_held_command(fmu_path, package, rng, order):
    """`simulate_fmu` on the packed file, selectors by item, a command computed at every step: 1e-9 of the largest position."""
    s, h, steps = bact.STIFFEST, bact.CONTROL_PERIOD_S, 100
    commands = rng.uniform(-5, 5, steps)
    corners = np.empty(2 * steps + 1, dtype=[("time", float), ("command", float)])  # fmpy holds a value only if it is given twice
    corners["time"] = h * np.repeat(np.arange(steps + 1), 2)[1:]
    corners["command"] = np.append(np.repeat(commands, 2), commands[-1])
    selectors = {"surface": s.surface, "stage": s.stage, "load_case": s.load_case, "order": order}
    result = fmpy.simulate_fmu(
        str(fmu_path), stop_time=steps * h, output_interval=h, input=corners, output=["position", "active.p"],
        start_values={name: package.number(name, item) for name, item in selectors.items()},
    )  # fmt: skip
    exact = bact.respond(s, order, commands, h)[:, 1]
    regular = np.searchsorted(result["time"], h * np.arange(1, steps + 1) - h / 2)
    assert np.abs(result["position"][regular] - exact).max() <= 1e-9 * np.abs(exact).max()
    assert (result["active.p"] == s.p).all()


def test_fmpy_gets_the_initial_values(fmu_path):
    result = fmpy.simulate_fmu(
        str(fmu_path), stop_time=0.01, output_interval=0.005, start_values={"initial_position": 2.5}, output=["position", "rate"]
    )
    assert (result["position"][0], result["rate"][0]) == (2.5, 0.0)
