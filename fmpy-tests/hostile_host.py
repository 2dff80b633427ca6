"""The bare C side of a host: no importer in between that would catch a mistake. Standard library only, so that it starts fast."""

import ctypes
import sys
import xml.etree.ElementTree as xml
from ctypes import CFUNCTYPE, Structure, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
MODEL_EXCHANGE, CO_SIMULATION = 0, 1
STEP_S = 0.005
SIGNATURES = {  # argument types: p pointer, i int, n size_t, d double
    "fmi2SetDebugLogging": "pinp",
    "fmi2SetupExperiment": "piddid",
    "fmi2EnterInitializationMode": "p",
    "fmi2ExitInitializationMode": "p",
    "fmi2Terminate": "p",
    "fmi2Reset": "p",
    **{f"fmi2{verb}{kind}": "ppnp" for verb in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")},
    "fmi2GetFMUstate": "pp",
    "fmi2SetFMUstate": "pp",
    "fmi2FreeFMUstate": "pp",
    "fmi2SerializedFMUstateSize": "ppp",
    "fmi2SerializeFMUstate": "pppn",
    "fmi2DeSerializeFMUstate": "ppnp",
    "fmi2GetDirectionalDerivative": "ppnpnpp",
    "fmi2SetRealInputDerivatives": "ppnpp",
    "fmi2GetRealOutputDerivatives": "ppnpp",
    "fmi2DoStep": "pddi",
    "fmi2CancelStep": "p",
    **{f"fmi2Get{kind}Status": "pip" for kind in ("", "Real", "Integer", "Boolean", "String")},
    "fmi2EnterEventMode": "p",
    "fmi2NewDiscreteStates": "pp",
    "fmi2EnterContinuousTimeMode": "p",
    "fmi2CompletedIntegratorStep": "pipp",
    "fmi2SetTime": "pd",
    "fmi2SetContinuousStates": "ppn",
    "fmi2GetDerivatives": "ppn",
    "fmi2GetEventIndicators": "ppn",
    "fmi2GetContinuousStates": "ppn",
    "fmi2GetNominalsOfContinuousStates": "ppn",
}
EXCHANGE_STATES = ("events", "continuous-time")  # of a model-exchange instance
INQUIRIES = ("fmi2GetTypesPlatform", "fmi2GetVersion")
LIFETIME = ("fmi2Instantiate", "fmi2FreeInstance")
TYPES = {"p": c_void_p, "i": c_int, "n": c_size_t, "d": c_double}
HARMLESS = {"p": None, "i": 0, "n": 0, "d": 0.0}

# The sixth argument is the first of the variable arguments; it is read only if the message refers to it.
LoggerType = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p)


class EventInfo(Structure):
    _fields_ = [(name, c_int) for name in ("needed", "terminate", "nominals", "values", "defined")] + [("time", c_double)]


class Callbacks(Structure):
    _fields_ = [("logger", c_void_p)] + [(name, c_void_p) for name in ("allocate", "free", "finished", "environment")]


def reals(*values):
    return (c_double * len(values))(*values)


def integers(*values):
    return (c_int * len(values))(*values)


class Host:
    """Loads the library of an unpacked FMU and calls it with arbitrary arguments."""

    def __init__(self, directory):
        root = xml.parse(Path(directory) / "modelDescription.xml").getroot()
        self.guid = root.get("guid").encode()
        self.variables = list(root.iter("ScalarVariable"))
        self.references = {v.get("name"): int(v.get("valueReference")) for v in self.variables}
        self.resources = (Path(directory) / "resources").as_uri().encode()
        identifier = root.find("CoSimulation").get("modelIdentifier")
        self.dll = ctypes.CDLL(str(Path(directory) / "binaries" / "linux64" / f"{identifier}.so"))
        for name, signature in SIGNATURES.items():
            getattr(self.dll, name).argtypes = [TYPES[letter] for letter in signature]
        for name in INQUIRIES:
            getattr(self.dll, name).restype = c_char_p
        self.dll.fmi2Instantiate.argtypes = [c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int]
        self.dll.fmi2Instantiate.restype = c_void_p
        self.dll.fmi2FreeInstance.argtypes, self.dll.fmi2FreeInstance.restype = [c_void_p], None
        self.log, self.on_log = [], None
        self.logger = LoggerType(self._write)

    def _write(self, _environment, name, status, category, message, extra):
        if message == b"%s":
            message = ctypes.string_at(extra)
        elif b"%" in message.replace(b"%%", b""):
            message = b"UNESCAPED PERCENT SIGN: " + message
        self.log.append(
            (status, (category or b"").decode(), message.decode(errors="replace"), (name or b"").decode(errors="replace"))
        )
        if self.on_log:
            self.on_log()

    def callbacks(self, **changes):
        return Callbacks(**{"logger": ctypes.cast(self.logger, c_void_p).value, **changes})

    def instantiate(self, **changes):
        """An instance (an address, or None), from valid arguments except for `changes`."""
        arguments = {
            "name": b"hostile", "kind": CO_SIMULATION, "guid": self.guid, "resources": self.resources,
            "callbacks": byref(self.callbacks()), "visible": 0, "logging": 1, **changes,
        }  # fmt: skip
        return self.dll.fmi2Instantiate(*arguments.values())

    def call(self, name, *arguments):
        return getattr(self.dll, name)(*arguments)

    def harmless(self, name, instance):
        """Calls with NULL, 0 and 0.0 after the instance."""
        return self.call(name, instance, *(HARMLESS[letter] for letter in SIGNATURES[name][1:]))

    def instance(self, state="step", **changes):
        """A valid instance, brought to a state: instantiated, initialization, step or terminated; events or continuous-time."""
        exchange = state in EXCHANGE_STATES
        made = self.instantiate(**{"kind": MODEL_EXCHANGE if exchange else CO_SIMULATION, **changes})
        assert made, f"a sound instance was refused: {self.log}"
        path = ["instantiated", "initialization", "step", "terminated"]
        reached = 2 if exchange else path.index(state)
        if reached >= 1:
            assert self.call("fmi2SetupExperiment", made, 0, 0.0, 0.0, 0, 0.0) == OK
            assert self.call("fmi2EnterInitializationMode", made) == OK
        if reached >= 2:
            assert self.call("fmi2ExitInitializationMode", made) == OK
        if reached >= 3:
            assert self.call("fmi2Terminate", made) == OK
        if state == "continuous-time":
            assert self.call("fmi2NewDiscreteStates", made, byref(EventInfo())) == OK
            assert self.call("fmi2EnterContinuousTimeMode", made) == OK
        return made

    def reference(self, variable):
        """An array of one value reference, by name or number."""
        return (c_uint * 1)(self.references.get(variable, variable))

    def set_real(self, instance, variable, value):
        return self.call("fmi2SetReal", instance, self.reference(variable), 1, reals(value))

    def set_integer(self, instance, variable, value):
        return self.call("fmi2SetInteger", instance, self.reference(variable), 1, integers(value))

    def get_real(self, instance, variable):
        value = reals(0.0)
        return self.call("fmi2GetReal", instance, self.reference(variable), 1, value), value[0]

    def step(self, instance, time=0.0, h=STEP_S):
        return self.call("fmi2DoStep", instance, time, h, 1)

    def works(self, instance):
        """Initializes, steps and frees it; returns the worst status."""
        statuses = [
            self.call("fmi2SetupExperiment", instance, 0, 0.0, 0.0, 0, 0.0),
            self.call("fmi2EnterInitializationMode", instance),
            self.call("fmi2ExitInitializationMode", instance),
            self.set_real(instance, "command", 1.0),
            self.step(instance),
        ]
        status, position = self.get_real(instance, "position")
        self.dll.fmi2FreeInstance(instance)
        print(f"position {position}", file=sys.stderr)
        return max(*statuses, status, OK if 0.0 < position < 2.0 else FATAL)
