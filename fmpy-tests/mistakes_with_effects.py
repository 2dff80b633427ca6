"""Mistakes with effects: impossible parameters, limits that cross, divergent actuators, steps that have to end."""

import os
import random
import sys
from ctypes import c_uint
from math import exp, inf, isfinite, log, nan, nextafter

from hostile_host import ERROR, FATAL, OK, STEP_S, integers, reals
from mistakes import REFUSED, WRONG, mistake

LARGEST = 1e9  # the neutral value of limits, and the bound of every parameter without a specific one
RUNAWAY = {"amplitude_gain.cubic": -0.03}  # beyond 3.3 deg the spring pulls outwards
COMPANIONS = (
    {}, {"backlash.gap": 0.1}, {"coulomb_friction.level": 0.1}, {"dead_zone.half_width": 0.1}, {"acceleration_limit.value": 1e6},
    {"sensor_lag.time": 0.01}, {"structural_mode.gain": 0.3},
)  # fmt: skip
ACTUATORS, STEPS = 1000, 20
ABROAD = 100.0  # random strengths lie up to this factor outside the usual range


def effect_parameters(host):
    """{name: (min, max)} of every effect parameter, as the description declares it."""
    found = {}
    for variable in host.variables:
        name, real = variable.get("name"), variable.find("Real")
        if variable.get("causality") == "parameter" and "." in name and not name.startswith("custom."):
            found[name] = (float(real.get("min")), float(real.get("max")))
    return found


def set_all(host, instance, values):
    """In one call."""
    references = (c_uint * len(values))(*(host.references[name] for name in values))
    return host.call("fmi2SetReal", instance, references, len(values), reals(*values.values()))


def started(host, values):
    """An instance in step mode with these parameters, or the status with which they were refused."""
    c = host.instance("instantiated")
    assert set_all(host, c, values) == OK
    host.call("fmi2SetupExperiment", c, 0, 0.0, 0.0, 0, 0.0)
    host.harmless("fmi2EnterInitializationMode", c)
    return c, host.harmless("fmi2ExitInitializationMode", c)


@mistake("every effect parameter just outside its range, or no number", WRONG, "delay.time", "quantisation.step", "nan", "inf")
def outside(host):
    """Refused with its name before the start and between steps; the ends of the range are accepted."""
    parameters = effect_parameters(host)
    assert len(parameters) >= 30
    for name, (low, high) in parameters.items():
        for state in ("instantiated", "step"):
            c = host.instance(state)
            for value in (nextafter(low, -inf), nextafter(high, inf), nan, inf, -inf):
                del host.log[:-10]
                if host.set_real(c, name, value) not in REFUSED or name not in host.log[-1][2]:
                    print(f"{name} = {value} in state {state}", file=sys.stderr)
                    return FATAL
            host.dll.fmi2FreeInstance(c)
        c = host.instance("instantiated")
        if max(host.set_real(c, name, low), host.set_real(c, name, high)) != OK:
            print(f"{name} = {low} or {high}, which the description allows", file=sys.stderr)
            return FATAL
    host.log.clear()
    for name in parameters:
        host.set_real(c, name, nan)
    return max(host.set_real(c, name, inf) for name in parameters)


for limit in ("position_limit", "command_limit"):
    for low, high in ((1.0, -1.0), (2.0, 2.0)):

        @mistake(f"{limit} from {low} to {high} at the start", WRONG, limit, "min", "max")
        def crossed(host, limit=limit, low=low, high=high):
            return started(host, {f"{limit}.min": low, f"{limit}.max": high})[1]

    @mistake(f"{limit} crossed between steps", WRONG, limit, "min", "max")
    def crossed_later(host, limit=limit):
        """Refused as a whole, and the old pair remains in force; a new pair in one call is accepted in either order."""
        c, status = started(host, {f"{limit}.min": -1.0, f"{limit}.max": 1.0})
        refused = host.set_real(c, f"{limit}.max", -2.0)
        assert status == OK and host.get_real(c, f"{limit}.max") == (OK, 1.0) and host.step(c) == OK
        assert set_all(host, c, {f"{limit}.max": -2.0, f"{limit}.min": -3.0}) == OK
        assert set_all(host, c, {f"{limit}.min": 2.0, f"{limit}.max": 3.0}) == OK
        return max(refused, host.step(c, STEP_S) and FATAL)


for start, stops in ((5.0, {"position_limit.max": 2.0}), (-5.0, {"position_limit.min": -2.0})):

    @mistake(f"a start at {start} deg, beyond a stop", WRONG, "initial_position", "position_limit", str(abs(start))[:1])
    def beyond(host, start=start, stops=stops):
        return started(host, {"initial_position": start, **stops})[1]


for companion in COMPANIONS:

    @mistake(f"an actuator that runs away, with {companion or 'nothing else'}", WRONG, "runs away", "amplitude_gain.cubic")
    def runaway(host, companion=companion):
        """A status, not NaN or infinity; its last position can still be read, and after a reset it works."""
        c, status = started(host, RUNAWAY | companion)
        host.set_real(c, "command", 8.0)
        for i in range(1000):
            status = host.step(c, i * STEP_S)
            if status != OK:
                break
        read, position = host.get_real(c, "position")
        assert read == OK and isfinite(position)
        assert max(host.call("fmi2Reset", c), host.works(c)) == OK
        return status


@mistake("a step of 1e300 s with an effect, which would never end", WRONG, "communicationStepSize", "effects")
def endless(host):
    return host.step(started(host, {"backlash.gap": 0.1})[0], 0.0, 1e300)


@mistake("a runaway that a stop catches, which is allowed", {OK})
def caught(host):
    c, _ = started(host, RUNAWAY | {"position_limit.max": 20.0})
    host.set_real(c, "command", 8.0)
    worst = max(host.step(c, i * STEP_S) for i in range(50))
    return worst if host.get_real(c, "position") == (OK, 20.0) else FATAL


for companion in ({"amplitude_gain.cubic": 0.0016}, {"delay.time": 0.001}, {"command_dead_zone.half_width": 0.01}):

    @mistake(f"a moving command under a rate limit that it does not reach, with {companion}", {OK})
    def followed(host, companion=companion):
        """The limited command equals the command up to rounding; distinguishing them must not take unbounded time."""
        c, _ = started(host, {"command_rate_limit.up": 35.4, "command_rate_limit.down": 62.6, **companion})
        host.set_real(c, "command", 0.02)
        host.call("fmi2SetRealInputDerivatives", c, host.reference("command"), 1, integers(1), reals(-16.0))
        return max(host.step(c, i * STEP_S) for i in range(20))


class Anything:
    """Random actuators: several effects, their strengths within the usual range or moderately outside."""

    def __init__(self, host, seed):
        self.host, self.random, self.ranges = host, random.Random(seed), effect_parameters(host)

    def strength(self, name):
        """On a logarithmic scale about the usual value."""
        low, high = self.ranges[name]
        usual = {"value": 2e4, "up": 100.0, "down": 100.0, "frequency": 20.0, "min": 5.0, "max": 5.0, "stiffness": 0.3,
                 "damping": 0.05, "cubic": 0.002, "time": 0.01, "step": 0.05}.get(name.split(".")[1], 0.3)  # fmt: skip
        size = usual * exp(self.random.uniform(-log(ABROAD), log(ABROAD)))
        sided = name.endswith((".cubic", ".bias", ".offset", ".drift", ".rate", ".phase", ".gain"))
        sign = -1.0 if name.endswith(".min") else self.random.choice((-1.0, 1.0)) if sided else 1.0
        return min(max(sign * size, low), high)

    def actuator(self):
        effects = sorted({name.split(".")[0] for name in self.ranges})
        chosen = self.random.sample(effects, self.random.choice((1, 2, 3, 6, len(effects))))
        values = {name: self.strength(name) for name in self.ranges if name.split(".")[0] in chosen}
        c, status = started(self.host, values)
        return c, status, values

    def drive(self, c):
        """Steps of any size; returns the worst status."""
        pick, time, worst = self.random, 0.0, OK
        for _ in range(STEPS):
            for name in ("command", "load"):
                self.host.set_real(c, name, pick.uniform(-8.0, 8.0) * (name == "command" or 0.2))
                if pick.random() < 0.5:
                    slope = reals(pick.uniform(-300.0, 300.0))
                    self.host.call("fmi2SetRealInputDerivatives", c, self.host.reference(name), 1, integers(1), slope)
            if pick.random() < 0.1:
                self.host.set_integer(c, "failure", pick.randint(1, 3))
            h = pick.choice((STEP_S, STEP_S, exp(pick.uniform(log(1e-7), log(0.3)))))
            worst, time = max(worst, self.host.step(c, time, h)), time + h
            if worst != OK:
                break
            for name in ("position", "deflection", "rate"):
                assert isfinite(self.host.get_real(c, name)[1]), name
        return worst


@mistake(f"{ACTUATORS} random actuators", {OK})
def random_actuators(host):
    """Every step ends, with finite numbers and without an error: only a spring that pushes outwards may diverge."""
    seed = int(os.environ.get("ACTUATOR_SEED", "208452"))
    print(f"seed {seed}", file=sys.stderr)
    anything, failed = Anything(host, seed), 0
    for number in range(ACTUATORS):
        c, status, values = anything.actuator()
        print(f"number {number}: {values}", file=sys.stderr, flush=True)
        status = max(status, anything.drive(c))
        if status == FATAL:
            return FATAL
        if status != OK and values.get("amplitude_gain.cubic", 0.0) >= 0.0:
            failed += 1
        host.dll.fmi2FreeInstance(c)
        del host.log[:-20]
    print(f"{failed} failed", file=sys.stderr)
    return ERROR if failed else OK
