"""The servo as one would write it in Python and package with pythonfmu: exact over a step, with the transition computed once per step
size."""

from math import cos, exp, sin, sqrt

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class PythonActuator(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.command = self.position = self.rate = 0.0
        self.k, self.omega, self.zeta = 1.0, 120.0, 0.7
        self.step_size = None
        self.register_variable(Real("command", causality=Fmi2Causality.input))
        self.register_variable(Real("position", causality=Fmi2Causality.output))
        for name in ("k", "omega", "zeta"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, current_time, step_size):
        if step_size != self.step_size:
            decay, damped = self.zeta * self.omega, self.omega * sqrt(1.0 - self.zeta**2)
            size = exp(-decay * step_size)
            c, s = size * cos(damped * step_size), size * sin(damped * step_size) / damped
            self.transition = c + decay * s, s, -(self.omega**2) * s, c - decay * s
            self.step_size = step_size
        a, b, c, d = self.transition
        target = self.k * self.command
        error, rate = self.position - target, self.rate
        self.position = target + a * error + b * rate
        self.rate = c * error + d * rate
        return True
