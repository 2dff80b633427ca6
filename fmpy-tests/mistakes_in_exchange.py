"""Mistakes with a model-exchange instance: calls of the other kind, in the wrong mode, with wrong lengths, NULL, NaN and infinity."""

from ctypes import byref, c_int, c_void_p
from math import inf, nan

from hostile_host import DISCARD, ERROR, EXCHANGE_STATES, FATAL, OK, SIGNATURES, STEP_S, EventInfo, integers, reals
from mistakes import ABSURD_COUNT, REFUSED, WRONG, Reference, call, mistake, set_real

STATES, INDICATORS = 7, 24
COMMAND = Reference("command")
OF_EXCHANGE = tuple(SIGNATURES)[-10:]
OF_SIMULATION = (
    "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives", "fmi2DoStep", "fmi2CancelStep",
)  # fmt: skip
ARRAYS = {
    "fmi2SetContinuousStates": STATES,
    "fmi2GetDerivatives": STATES,
    "fmi2GetContinuousStates": STATES,
    "fmi2GetNominalsOfContinuousStates": STATES,
    "fmi2GetEventIndicators": INDICATORS,
}
SOUND = {
    "fmi2NewDiscreteStates": (byref(EventInfo()),),
    "fmi2CompletedIntegratorStep": (1, byref(c_int()), byref(c_int())),
    "fmi2SetTime": (0.0,),
    "fmi2SetRealInputDerivatives": (COMMAND, 1, integers(1), reals(1.0)),
    "fmi2GetRealOutputDerivatives": (Reference("position"), 1, integers(1), reals(0.0)),
    "fmi2DoStep": (0.0, STEP_S, 1),
    **{name: (reals(*[0.0] * count), count) for name, count in ARRAYS.items()},
}

# The other kind

for function in OF_EXCHANGE:
    for state in ("instantiated", "step", "terminated"):
        words = [function, "model exchange"]
        call(state, f"{function} of a co-simulation instance, {state}", WRONG, words, function, *SOUND.get(function, ()))
for function in OF_SIMULATION:
    for state in EXCHANGE_STATES:
        words = [function, "co-simulation"]
        call(state, f"{function} of a model-exchange instance, {state}", WRONG, words, function, *SOUND.get(function, ()))
for kind in ("Real", "Integer", "Boolean", "String", ""):
    function = f"fmi2Get{kind}Status"
    call("continuous-time", f"{function} of a model-exchange instance", REFUSED, function, function, 2, reals(0.0))
call(
    "continuous-time", "a directional derivative by an output", WRONG, "`command`",
    "fmi2GetDirectionalDerivative", Reference("position"), 1, Reference("rate"), 1, reals(1.0), reals(0.0),
)  # fmt: skip

# The wrong mode

for state, function in (
    ("events", "fmi2CompletedIntegratorStep"),
    ("events", "fmi2SetContinuousStates"),
    ("continuous-time", "fmi2NewDiscreteStates"),
    ("continuous-time", "fmi2EnterContinuousTimeMode"),
    ("continuous-time", "fmi2ExitInitializationMode"),
    ("events", "fmi2EnterInitializationMode"),
):
    call(state, f"{function} in {state} mode", WRONG, [function, "mode"], function, *SOUND.get(function, ()))
set_real("continuous-time", "a tunable parameter while the host integrates", WRONG, ["custom.k", "event mode"], "custom.k", 2.0)
set_real("events", "a tunable parameter at an event, which is allowed", {OK}, [], "custom.k", 2.0)
set_real("events", "a fixed parameter at an event", WRONG, "initial_position", "initial_position", 2.0)
set_real("continuous-time", "a state as a variable, which is calculated", WRONG, "drive.position", "drive.position", 1.0)

# Arrays and numbers

for function, count in ARRAYS.items():
    name = "ni" if function == "fmi2GetEventIndicators" else "nx"
    for wrong in (0, count - 1, count + 1):
        numbers = reals(*[0.0] * (count + 1))
        what = f"{function} of {wrong} numbers"
        call("continuous-time", what, WRONG, [function, name, str(count)], function, numbers, wrong)
    call("continuous-time", f"{function} of NULL", WRONG, [function, "NULL"], function, None, count)
    call("continuous-time", f"{function} of an absurd number", WRONG, function, function, reals(0.0), ABSURD_COUNT)
    call("continuous-time", f"{function} as it should be", {OK}, [], function, reals(*[0.0] * count), count)
call("events", "no place for the event information", WRONG, "fmi2eventInfo", "fmi2NewDiscreteStates", None)
call("continuous-time", "no place for what a step wants", WRONG, "NULL", "fmi2CompletedIntegratorStep", 1, None, None)
for number in (nan, inf, -inf):
    call("continuous-time", f"the time {number}", REFUSED, ["time", str(abs(number))], "fmi2SetTime", number)
    set_real("continuous-time", f"command {number} while the host integrates", REFUSED, "command", "command", number)
    for index in range(STATES):
        numbers = [0.0] * STATES
        numbers[index] = number
        words = ["continuous states", str(abs(number)), f"index {index}"]
        what = f"state {index} is {number}"
        call("continuous-time", what, {DISCARD}, words, "fmi2SetContinuousStates", reals(*numbers), STATES)


@mistake("states beyond numbers, whose derivatives are none", {DISCARD}, "fmi2GetDerivatives", "derivatives")
def overflow(host):
    """The cube of 1e200 is infinite; a solver that is notified tries a shorter step, and the next valid states are accepted."""
    c = host.instance("events")
    assert host.set_real(c, "amplitude_gain.cubic", 1.0) == OK
    assert host.call("fmi2NewDiscreteStates", c, byref(EventInfo())) == OK
    assert host.call("fmi2EnterContinuousTimeMode", c) == OK
    values = reals(*[1e200] * STATES)
    assert host.call("fmi2SetContinuousStates", c, values, STATES) == OK
    refused = host.call("fmi2GetDerivatives", c, values, STATES)
    assert host.call("fmi2SetContinuousStates", c, reals(*[0.0] * STATES), STATES) == OK
    return refused if host.call("fmi2GetDerivatives", c, values, STATES) == OK else FATAL


@mistake("a state saved by the other kind of instance", WRONG, "model exchange")
def other_kind(host):
    """Its bytes are refused with the reason; its handle is foreign."""
    from ctypes import c_size_t, create_string_buffer

    simulation, exchange, state, size = host.instance(), host.instance("continuous-time"), c_void_p(), c_size_t()
    assert host.call("fmi2GetFMUstate", simulation, byref(state)) == OK
    assert host.call("fmi2SetFMUstate", exchange, state) == ERROR
    assert host.call("fmi2SerializedFMUstateSize", simulation, state, byref(size)) == OK
    place = create_string_buffer(size.value)
    assert host.call("fmi2SerializeFMUstate", simulation, state, place, size.value) == OK
    return host.call("fmi2DeSerializeFMUstate", exchange, place, size.value, byref(c_void_p()))


@mistake("no event iteration after the start, and a step that ends where it began", {OK})
def careless(host):
    c = host.instance("events")
    numbers = reals(*[0.0] * STATES)
    return max(
        host.call("fmi2EnterContinuousTimeMode", c),
        host.call("fmi2GetDerivatives", c, numbers, STATES),
        host.call("fmi2CompletedIntegratorStep", c, 1, byref(c_int()), byref(c_int())),
        host.call("fmi2SetTime", c, 0.0),
        host.call("fmi2CompletedIntegratorStep", c, 1, byref(c_int()), byref(c_int())),
        host.call("fmi2GetDerivatives", c, numbers, STATES),
        host.call("fmi2EnterEventMode", c),
        host.call("fmi2EnterEventMode", c),
        host.call("fmi2Terminate", c),
        host.call("fmi2Reset", c),
    )
