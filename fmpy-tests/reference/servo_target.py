"""The servo target x(t), in closed form, on intervals between which nothing jumps.

    u = k (1 + drift t) c,   order 3: dx/dt = p (u - x),  x(0) = d0;   order 2: x = u

c is linear on an interval, so u is a parabola and x a parabola plus one exponential, exactly, for any p:

    u = a0 + a1 s + a2 s^2,   x = q0 + q1 s + q2 s^2 + C exp(-p s)
    q2 = a2,  q1 = a1 - 2 q2 / p,  q0 = a0 - q1 / p,  C = x(start) - q0          s = t - start of the interval

Thus the pole (up to 3e8 1/s) never enters a numerical integration. s, not t, is the time inside an interval,
because the rounding of t = 5 s is a millionth of such a pole's time constant.
"""

from dataclasses import dataclass

import numpy as np

# Below this fraction of the signal an exponential is dropped; it is below the rounding of the signal itself.
VANISHED = 1e-16


@dataclass
class Interval:
    """An interval between two breakpoints: all inputs of the loop."""

    duration: float
    target: tuple      # q0, q1, q2
    transient: float   # C
    pole: float        # p; infinite for order 2
    transient_end: float  # s after which C exp(-p s) has vanished
    load: tuple        # load and its slope
    failure: int
    sample: int        # index of the sample at its end, -1 if there is none

    def target_at(self, s):
        q0, q1, q2 = self.target
        x = q0 + s * (q1 + s * q2)
        if self.transient != 0.0 and np.min(s) < self.transient_end:
            x = x + self.transient * np.exp(-self.pole * s)
        return x


def intervals(command, load, failure, time, base, order, drift, initial_position, scale):
    """Cut time at every breakpoint of command, load and failure and at every sample, and solve for x.

    scale: size of the signals, of which a vanishing fraction is dropped."""
    k, p = base[0], base[1]
    end = command.end
    edges = np.unique(np.concatenate([command.start, load.start, time, [end]]))
    edges = edges[edges <= end]
    # Breakpoints closer than the rounding of time are merged into the last, at which all of them have occurred.
    edges = edges[np.r_[np.diff(edges) > 4e-16 * np.maximum(1.0, edges[1:]), True]]
    sample_of = {float(edges[np.argmin(np.abs(edges - t))]): i for i, t in enumerate(time)}
    at_command = np.searchsorted(command.start, edges[:-1], side="right") - 1
    at_load = np.searchsorted(load.start, edges[:-1], side="right") - 1
    at_failure = np.searchsorted(time, edges[:-1], side="right") - 1
    x = initial_position
    for j, start in enumerate(edges[:-1]):
        duration = edges[j + 1] - start
        i = at_command[j]
        slope = command.slope[i]
        c = command.value[i] + slope * (start - command.start[i])
        gain = 1.0 + drift * start
        a0, a1, a2 = k * gain * c, k * (gain * slope + drift * c), k * drift * slope
        transient, vanishing = 0.0, 0.0
        if order == 3:
            a1 = a1 - 2.0 * a2 / p
            a0 = a0 - a1 / p
            transient = x - a0
            if abs(transient) > VANISHED * scale:
                vanishing = np.log(abs(transient) / (VANISHED * scale)) / p
            x = a0 + duration * (a1 + duration * a2) + transient * np.exp(-p * duration)
        i = at_load[j]
        here = load.value[i] + load.slope[i] * (start - load.start[i])
        yield Interval(duration, (a0, a1, a2), transient, p if order == 3 else np.inf, vanishing,
                       (here, load.slope[i]), int(failure[at_failure[j]]), sample_of.get(float(edges[j + 1]), -1))
