"""Thousands of random calls: valid and invalid ones, in any order, on several instances that are created and freed."""

import os
import random
import sys
from ctypes import byref, c_char_p, c_size_t, c_uint, c_void_p, create_string_buffer
from math import inf, nan

from hostile_host import DISCARD, ERROR, EXCHANGE_STATES, OK, SIGNATURES, WARNING, EventInfo, integers, reals
from mistakes import GARBAGE, UNKNOWN_REFERENCE, mistake

CALLS = 20_000
ROOM = 64  # elements of every array that is passed
STATES = ("instantiated", "initialization", "step", *EXCHANGE_STATES)
STATES_AND_INDICATORS = (7, 24)
NUMBERS = (0.0, -0.0, 1.0, -1.0, 0.005, 1e-300, 1e-7, 1e7, 1e300, -1e300, 5e-324, nan, inf, -inf)
WHOLES = (0, 1, 2, 3, 4, 17, 18, -1, 2**31 - 1, -(2**31))


class Chaos:
    """Random arguments, of the right type and length but of any value, for any function."""

    def __init__(self, host, seed):
        self.host, self.random = host, random.Random(seed)
        self.instances, self.states = [host.instance(state) for state in STATES], []
        self.text = create_string_buffer(4096)

    def instance(self):
        return self.random.choice([*self.instances, *self.instances, None, GARBAGE])

    def state(self):
        return self.random.choice([*self.states, *self.states, None, GARBAGE])

    def references(self):
        known = list(self.host.references.values())
        return (c_uint * ROOM)(*(self.random.choice([*known, *known, UNKNOWN_REFERENCE]) for _ in range(ROOM)))

    def numbers(self):
        return reals(*self.random.choices([*NUMBERS, *(self.random.gauss(0, 10) for _ in NUMBERS)], k=ROOM))

    def count(self):
        return self.random.choice((0, 1, 1, 1, 2, 5))

    def time(self):
        return self.random.choice([*NUMBERS, 0.005 * self.random.randrange(10)])

    def arguments(self, function):
        pick, count = self.random.choice, self.count()
        wholes = integers(*self.random.choices(WHOLES, k=ROOM))
        if function == "fmi2DoStep":
            return self.time(), pick([*NUMBERS, 0.005, 0.005]), pick((0, 1))
        if function == "fmi2SetupExperiment":
            return pick((0, 1)), pick(NUMBERS), self.time(), pick((0, 1)), pick(NUMBERS)
        if function == "fmi2SetDebugLogging":
            return pick((0, 1)), min(count, 2), (c_char_p * 2)(b"logAll", pick((b"logStatusError", b"%n", None)))
        if function.endswith("InputDerivatives") or function.endswith("OutputDerivatives"):
            return self.references(), count, wholes, self.numbers()
        if function == "fmi2GetDirectionalDerivative":
            return self.references(), count, self.references(), self.count(), self.numbers(), self.numbers()
        if function.endswith("Status"):
            return pick(WHOLES), self.numbers()
        if function.endswith("String"):
            return self.references(), count, (c_char_p * ROOM)(*(pick((b"text", b"\xff", None)) for _ in range(ROOM)))
        if function.endswith(("Integer", "Boolean")):
            return self.references(), count, wholes
        if function.endswith("Real"):
            return self.references(), count, self.numbers()
        if function == "fmi2NewDiscreteStates":
            return (byref(EventInfo()),)
        if function == "fmi2CompletedIntegratorStep":
            return pick((0, 1)), wholes, integers(*WHOLES)
        if function == "fmi2SetTime":
            return (self.time(),)
        if function.endswith(("ContinuousStates", "Derivatives", "Indicators")):
            return self.numbers(), pick((count, *STATES_AND_INDICATORS))
        if function == "fmi2SetFMUstate":
            return (self.state(),)
        if function == "fmi2SerializedFMUstateSize":
            return self.state(), byref(c_size_t())
        if function == "fmi2SerializeFMUstate":
            return self.state(), self.text, pick((0, 1, len(self.text)))
        if function == "fmi2DeSerializeFMUstate":
            return self.text, pick((0, 1, 100, 200, len(self.text))), byref(c_void_p(self.state()))
        return ()

    def state_call(self, instance, function):
        """Getting or freeing a state: the handle is returned."""
        handle = c_void_p(self.state())
        before, status = handle.value, self.host.call(function, instance, byref(handle))
        if status == OK and function == "fmi2FreeFMUstate" and before in self.states and self.random.random() < 0.5:
            self.states.remove(before)  # otherwise it remains as a stale one
        if status == OK and handle.value:
            self.states = [*self.states[-9:], handle.value]
        return status

    def replace_an_instance(self):
        old = self.random.choice(self.instances)
        self.host.dll.fmi2FreeInstance(old)
        if self.random.random() < 0.8:  # otherwise it remains as a freed one
            self.instances.remove(old)
        self.instances = [
            *self.instances[-5:],
            self.host.instance(self.random.choice(STATES)),
        ]

    def call(self):
        if self.random.random() < 0.01:
            self.replace_an_instance()
        function, instance = self.random.choice(list(SIGNATURES)), self.instance()
        if function in ("fmi2GetFMUstate", "fmi2FreeFMUstate"):
            return self.state_call(instance, function)
        return self.host.call(function, instance, *self.arguments(function))


@mistake(f"{CALLS} random calls", {OK})
def random_calls(host):
    """Every status is one of the standard's, none is fatal, and many calls succeed (otherwise this would test nothing)."""
    seed = int(os.environ.get("ACTUATOR_SEED", "208452"))
    print(f"seed {seed}", file=sys.stderr)
    chaos, tally = Chaos(host, seed), {}
    for _ in range(CALLS):
        status = chaos.call()
        tally[status] = tally.get(status, 0) + 1
        del host.log[:-20]  # last output, in case one of the calls crashes
        if status not in (OK, WARNING, DISCARD, ERROR):
            return status
    print(f"statuses {tally}", file=sys.stderr)
    return OK if tally[OK] > CALLS / 10 else ERROR
