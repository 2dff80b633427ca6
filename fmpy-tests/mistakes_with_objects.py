"""Mistakes with instances, kept states and the logger: NULL, garbage, freed, foreign."""

import threading
from ctypes import addressof, byref, c_char_p, c_size_t, c_void_p, create_string_buffer

from hostile_host import ERROR, EXCHANGE_STATES, FATAL, OK, SIGNATURES, STEP_S
from mistakes import (
    ABSURD_COUNT,
    GARBAGE,
    MISTAKES,
    NO_INSTANCE,
    NOTHING,
    SURVIVED,
    UNKNOWN,
    UNKNOWN_REFERENCE,
    WRONG,
    Mistake,
    call,
    mistake,
)

RESOURCES = (
    None,
    b"",
    b"file:///x",
    b"file:///x/",
    b"file:////x",
    b"file:/x",
    b"x",
    b"http://x/y",
    b"file:///%20%s%n",
    b"file:///\xff\xfe",
    b"file:///" + b"x" * 100_000,
)

# Instances


def instantiate(what, statuses, words, **changes):
    def make(host):
        made = host.instantiate(**changes)
        return host.works(made) if made else None

    MISTAKES.append(Mistake(what, make, statuses, tuple(words)))


for uri in RESOURCES:
    label = repr(uri if uri is None or len(uri) < 99 else uri[:12] + b"...")
    instantiate(f"resources at {label}, which the own GUID does not need", {OK}, [], resources=uri)
    instantiate(f"a wrong GUID and resources at {label}", NOTHING, ["guid"], guid=b"{0}", resources=uri)
instantiate("a wrong GUID", NOTHING, ["guid", "{12345678-0000}"], guid=b"{12345678-0000}")
instantiate("a GUID of printf directives", NOTHING, ["guid"], guid=b"%s%n%s%n")
instantiate("a GUID that is no UTF-8", NOTHING, ["guid"], guid=b"\xff\xfe")
instantiate("an empty GUID", NOTHING, ["guid"], guid=b"")
instantiate("no GUID", NOTHING, ["guid"], guid=None)
instantiate("no instance name", NOTHING, ["name"], name=None)
instantiate("an empty instance name", NOTHING, ["name"], name=b"")
instantiate("an instance name that is no UTF-8", {OK}, [], name=b"\xff\xfe")
instantiate("an instance of kind 7", NOTHING, ["7"], kind=7)
instantiate("no callbacks at all", NOTHING | {OK}, [], callbacks=None)
instantiate("no callbacks and a wrong GUID", NOTHING, [], callbacks=None, guid=b"{0}")


@mistake("neither logger nor memory callbacks", {OK})
def no_callback_functions(host):
    """Memory callbacks are NULL in all other cases as well. Errors are silent, and do not crash."""
    made = host.instantiate(callbacks=byref(host.callbacks(logger=None)))
    assert host.get_real(made, UNKNOWN_REFERENCE)[0] == ERROR
    return max(host.call("fmi2Reset", made), host.works(made))


@mistake("printf directives in the instance name", WRONG, UNKNOWN)
def percent_name(host):
    return host.get_real(host.instance(name=b"%s%n%d"), UNKNOWN_REFERENCE)[0]


def every_function(host, instance):
    return {host.harmless(name, instance) for name in SIGNATURES}


def worst_of(statuses):
    return next(iter(statuses - NO_INSTANCE), ERROR)


@mistake("NULL for the instance, in every function", NO_INSTANCE)
def null_instance(host):
    host.dll.fmi2FreeInstance(None)
    return worst_of(every_function(host, None))


@mistake("garbage for the instance, in every function", NO_INSTANCE)
def garbage_instance(host):
    memory = create_string_buffer(4096)
    statuses = set()
    for address in (GARBAGE, 1, 8, (1 << 64) - 8, addressof(memory)):
        statuses |= every_function(host, address)
        host.dll.fmi2FreeInstance(address)
    return worst_of(statuses)


@mistake("use after free, in every function", NO_INSTANCE)
def use_after_free(host):
    c = host.instance()
    host.dll.fmi2FreeInstance(c)
    return worst_of(every_function(host, c))


@mistake("double free, next to a living instance", {OK})
def double_free(host):
    c, other = host.instance(), host.instance("instantiated")
    host.dll.fmi2FreeInstance(c)
    host.dll.fmi2FreeInstance(c)
    return host.works(other)


@mistake("freeing without terminating, in every state", {OK})
def free_at_once(host):
    for state in ("instantiated", "initialization", "step", "terminated", *EXCHANGE_STATES):
        host.dll.fmi2FreeInstance(host.instance(state))
    return OK


@mistake("a logger that calls the instance", WRONG, UNKNOWN)
def logger_calls_back(host):
    c, depth = host.instance(), []

    def again():
        if len(depth) < 3:
            depth.append(host.get_real(c, UNKNOWN_REFERENCE))

    host.on_log = again
    return host.get_real(c, UNKNOWN_REFERENCE)[0]


@mistake("two threads in one instance, which then disappears", SURVIVED)
def two_threads(host):
    c = host.instance()

    def hammer():
        for i in range(3000):
            host.set_real(c, "command", 1.0)
            host.step(c, i * STEP_S)
            host.get_real(c, "position")

    threads = [threading.Thread(target=hammer) for _ in range(2)]
    for thread in threads:
        thread.start()
    host.dll.fmi2FreeInstance(c)
    for thread in threads:
        thread.join()
    return OK


# Log and states

LOGGING, FOREIGN = "fmi2SetDebugLogging", byref(c_void_p(GARBAGE))
GET, SET, FREE = "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"
SIZE, WRITE, READ = "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"

call("step", "no log categories behind a count", WRONG, LOGGING, LOGGING, 1, 2, None)
call("step", "a NULL among the log categories", SURVIVED, [], LOGGING, 1, 2, (c_char_p * 2)(b"logAll", None))
call("step", "an unknown log category", SURVIVED, [], LOGGING, 1, 1, (c_char_p * 1)(b"%s%n nonsense"))
call("step", "a state that is NULL", WRONG, "state", SET, None)
call("step", "a state that is garbage", WRONG, "state", SET, GARBAGE)
call("step", "no place for a state", WRONG, GET, GET, None)
call("step", "garbage where an earlier state is expected", {OK, ERROR}, [], GET, FOREIGN)
call("step", "freeing no state", {OK}, [], FREE, byref(c_void_p()))
call("step", "freeing a NULL pointer to a state", {OK, ERROR}, [], FREE, None)
call("step", "freeing garbage", WRONG, "state", FREE, FOREIGN)
call("step", "the size of a garbage state", WRONG, "state", SIZE, GARBAGE, byref(c_size_t()))
call("step", "writing a garbage state", WRONG, "state", WRITE, GARBAGE, create_string_buffer(8), 8)
call("step", "reading a state from NULL", WRONG, READ, READ, None, 8, byref(c_void_p()))
call("step", "reading a state into NULL", WRONG, READ, READ, b"12345678", 8, None)
call("step", "reading a state of absurd size", WRONG, "state", READ, b"12345678", ABSURD_COUNT, byref(c_void_p()))


def with_state(what, statuses, *words):
    def register(make):
        def prepared(host):
            c, state = host.instance(), c_void_p()
            assert host.call("fmi2GetFMUstate", c, byref(state)) == OK and state.value
            return make(host, c, state)

        MISTAKES.append(Mistake(what, prepared, statuses, words))
        return make

    return register


@with_state("a state used after it was freed", WRONG, "state")
def freed_state(host, c, state):
    stale = c_void_p(state.value)
    assert host.call("fmi2FreeFMUstate", c, byref(state)) == OK and not state.value
    assert host.call("fmi2FreeFMUstate", c, byref(c_void_p(stale.value))) == ERROR
    host.call("fmi2Reset", c)
    return host.call("fmi2SetFMUstate", c, stale)


@with_state("a state that outlives its instance", SURVIVED)
def orphaned_state(host, c, state):
    host.dll.fmi2FreeInstance(c)
    other = host.instance()
    return max(host.call("fmi2SetFMUstate", other, state), host.call("fmi2FreeFMUstate", other, byref(state)))


@with_state("a state written into too small a place", WRONG, "fmi2SerializeFMUstate")
def small_place(host, c, state):
    size = c_size_t()
    assert host.call("fmi2SerializedFMUstateSize", c, state, byref(size)) == OK
    place = create_string_buffer(b"\x5a" * size.value, size.value)
    status = host.call("fmi2SerializeFMUstate", c, state, place, size.value - 1)
    return status if place.raw == b"\x5a" * size.value else FATAL


@with_state("a state written to NULL, its size to NULL", WRONG, "fmi2SerializeFMUstate")
def null_place(host, c, state):
    assert host.call("fmi2SerializedFMUstateSize", c, state, None) == ERROR
    return host.call("fmi2SerializeFMUstate", c, state, None, 4096)


@with_state("a state of another instance, whose own states are others", {OK, ERROR})
def foreign_state(host, c, state):
    """Refused, or recognised as foreign, but never confused with a state of the instance itself."""
    other, own = host.instance("initialization"), c_void_p()
    host.set_real(other, "initial_position", 5.0)
    assert host.call("fmi2GetFMUstate", other, byref(own)) == OK
    status = host.call("fmi2SetFMUstate", other, state)
    return status if status == ERROR or host.get_real(other, "position") == host.get_real(c, "position") else FATAL
