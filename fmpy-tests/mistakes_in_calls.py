"""Mistakes in single calls: wrong variables, wrong values, wrong times, wrong order."""

from ctypes import c_char_p
from math import inf, nan, nextafter

from hostile_host import ERROR, INQUIRIES, OK, STEP_S, integers, reals
from mistakes import (
    ABSURD_COUNT,
    FINE,
    REFUSED,
    UNKNOWN,
    UNKNOWN_REFERENCE,
    WRONG,
    Reference,
    call,
    mistake,
    set_integer,
    set_real,
)

COMMAND = Reference("command")
KINDS = ("Real", "Integer", "Boolean", "String")
LAST_SUCCESSFUL_TIME = 2
FIXED = ("surface", "stage", "load_case", "set_number", "order", "source")
OUT_OF_RANGE = {
    "surface": (0, 4, -1, 2**31 - 1),
    "stage": (0, 4),
    "load_case": (0, 3),
    "order": (0, 3),
    "source": (0, 3),
    "set_number": (-1, 18, -(2**31)),
    "failure": (0, 6, -1, 2**31 - 1),
}
UNSTABLE = (("custom.p", -1.0), ("custom.omega", 0.0), ("custom.omega", -5.0), ("custom.zeta", -0.1))

# Variables and values

for function in (f"fmi2{verb}{kind}" for verb in ("Get", "Set") for kind in KINDS):
    unknown = Reference(UNKNOWN_REFERENCE)
    call("step", f"{function} of an unknown value reference", WRONG, UNKNOWN, function, unknown, 1, reals(0.0))
    call("step", f"{function} without value references", WRONG, function, function, None, 1, reals(0.0))
    call("step", f"{function} without values", WRONG, function, function, COMMAND, 1, None)
    call("step", f"{function} of nothing", {OK}, [], function, None, 0, None)
    call("step", f"{function} of an absurd number of variables", WRONG, function, function, COMMAND, ABSURD_COUNT, reals(0.0))
    if "Real" not in function:
        named = "reference" if "String" in function else "command"
        call("step", f"{function} of the Real `command`", WRONG, named, function, COMMAND, 1, reals(0.0))
READ_AS_ANOTHER_TYPE = (
    ("fmi2GetReal", "saturated"), ("fmi2GetInteger", "saturated"), ("fmi2GetReal", "failure"), ("fmi2GetBoolean", "failure"),
)  # fmt: skip
for function, variable in READ_AS_ANOTHER_TYPE:
    call("step", f"{function} of `{variable}`", WRONG, variable, function, Reference(variable), 1, reals(0.0))
for function in ("fmi2SetReal", "fmi2SetBoolean", "fmi2SetInteger"):
    call("step", f"{function} of the output `saturated`", WRONG, "saturated", function, Reference("saturated"), 1, reals(0.0))
for function in ("fmi2SetReal", "fmi2SetBoolean"):
    call("step", f"{function} of the enumeration `failure`", WRONG, "failure", function, Reference("failure"), 1, reals(1.0))
set_real("instantiated", "fmi2SetReal of the enumeration `surface`", WRONG, "surface", "surface", 1.0)
call("instantiated", "fmi2SetString to a NULL string", WRONG, "fmi2SetString", "fmi2SetString", COMMAND, 1, (c_char_p * 1)(None))

for value in (nan, inf, -inf):
    for variable in ("command", "load"):
        set_real("step", f"{variable} {value}", REFUSED, [variable, str(abs(value))], variable, value)
        call(
            "step", f"derivative of the {variable} {value}", REFUSED, variable,
            "fmi2SetRealInputDerivatives", Reference(variable), 1, integers(1), reals(value),
        )  # fmt: skip
    for variable in ("custom.k", "custom.p", "initial_position"):
        set_real("instantiated", f"{variable} {value}", REFUSED, variable, variable, value)
for variable, value in UNSTABLE:
    set_real("instantiated", f"an unstable {variable} = {value}", REFUSED, variable, variable, value)
for variable, values in OUT_OF_RANGE.items():
    for value in values:
        set_integer("instantiated", f"{variable} {value}", REFUSED, [variable, str(value)], variable, value)
set_integer("step", "an unknown failure between steps", REFUSED, ["failure", "6", "passive"], "failure", 6)

for variable in ("position", "deflection", "rate", "active.k"):
    for state in ("instantiated", "step"):
        set_real(state, f"setting {variable}, which is calculated, in state {state}", WRONG, variable, variable, 1.0)
for variable in FIXED:
    set_integer("step", f"setting the fixed parameter {variable} between steps", WRONG, variable, variable, 1)
set_real("step", "setting the fixed parameter initial_position between steps", WRONG, "initial_position", "initial_position", 1.0)

# Derivatives

for order in (0, 2, -1):
    call(
        "step", f"input derivative of order {order}", REFUSED, ["order", str(order)],
        "fmi2SetRealInputDerivatives", COMMAND, 1, integers(order), reals(1.0),
    )  # fmt: skip
call(
    "step", "input derivative of an output", WRONG, "position",
    "fmi2SetRealInputDerivatives", Reference("position"), 1, integers(1), reals(1.0),
)  # fmt: skip
for variable in ("delay.time", "initial_position"):
    call(
        "step", f"input derivative of the parameter {variable}", WRONG, variable,
        "fmi2SetRealInputDerivatives", Reference(variable), 1, integers(1), reals(1.0),
    )  # fmt: skip
for function in ("fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives"):
    call("step", f"{function} with NULL behind a count", WRONG, function, function, None, 1, None, None)
function = "fmi2GetDirectionalDerivative"
call("step", f"{function} with NULL behind the counts", WRONG, function, function, None, 1, None, 1, None, None)

# Time and order of calls

for h_s in (0.0, -0.005, nan, inf, -inf):
    call("step", f"a step of {h_s} s", REFUSED, "step", "fmi2DoStep", 0.0, h_s, 1)
for point in (0.5, -0.005, nan, inf):
    call("step", f"a first step from {point} s on", REFUSED, "communication point", "fmi2DoStep", point, STEP_S, 1)
for state in ("instantiated", "initialization", "terminated"):
    call(state, f"a step in state {state}", WRONG, "fmi2DoStep", "fmi2DoStep", 0.0, STEP_S, 1)
for state, function in (
    ("instantiated", "fmi2ExitInitializationMode"),
    ("instantiated", "fmi2Terminate"),
    ("initialization", "fmi2EnterInitializationMode"),
    ("step", "fmi2EnterInitializationMode"),
    ("step", "fmi2ExitInitializationMode"),
    ("terminated", "fmi2EnterInitializationMode"),
    ("terminated", "fmi2Terminate"),
    ("step", "fmi2CancelStep"),
):
    call(state, f"{function} in state {state}", WRONG, function, function)
call("step", "fmi2SetupExperiment in state step", WRONG, "fmi2SetupExperiment", "fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
set_real("terminated", "setting a value after termination", WRONG, "fmi2SetReal", "command", 1.0)
call("terminated", "getting a value after termination, which is allowed", {OK}, [], "fmi2GetReal", COMMAND, 1, reals(0.0))
call("terminated", "fmi2Reset after termination, which is allowed", {OK}, [], "fmi2Reset")
for start in (nan, inf):
    call(
        "instantiated", f"an experiment that starts at {start}", REFUSED, "start",
        "fmi2SetupExperiment", 0, 0.0, start, 0, 0.0,
    )  # fmt: skip
call("instantiated", "NaN where the flag says undefined, which is allowed", {OK}, [], "fmi2SetupExperiment", 0, nan, 0.0, 0, nan)
for function in (f"fmi2Get{kind}Status" for kind in ("", *KINDS)):
    call("step", f"{function} of kind 99", REFUSED, "99", function, 99, reals(0.0))
    call("step", f"{function} without a place for the value", REFUSED, function, function, LAST_SUCCESSFUL_TIME, None)


@mistake("communication points that differ in the last bits", FINE)
def last_bits(host):
    """A thousand steps, each point off by one bit in either direction, then a sum of steps instead of a multiple."""
    c, worst, total = host.instance(), OK, 0.0
    for i in range(1000):
        worst, total = max(worst, host.step(c, nextafter(i * STEP_S, (inf, -inf)[i % 2]))), total + STEP_S
    return max(worst, host.step(c, total))


@mistake("a step that ends a last bit behind the stop time", FINE)
def beyond_stop(host):
    c = host.instance("instantiated")
    host.call("fmi2SetupExperiment", c, 0, 0.0, 0.0, 1, STEP_S)
    host.harmless("fmi2EnterInitializationMode", c), host.harmless("fmi2ExitInitializationMode", c)
    return host.step(c, 0.0, nextafter(STEP_S, inf))


@mistake("an error, and then fmi2Reset", {OK})
def reset_after_error(host):
    c = host.instance()
    assert host.step(c, 0.0, nan) in REFUSED
    return max(host.call("fmi2Reset", c), host.works(c))


@mistake("inquiries before anything else", {OK})
def inquiries(host):
    return OK if [host.call(name) for name in INQUIRIES] == [b"default", b"2.0"] else ERROR
