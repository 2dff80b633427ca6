"""The command side of the chain: exact operators on piecewise linear signals.

A sampled command is piecewise linear in time (held: slopes are zero, with jumps). Delay, clamp, rate limit, dead
zone, play and sign-dependent gain all map a piecewise linear signal to a piecewise linear one, so that no
integration is needed: only breakpoints are computed, in closed form.

    delay              c1(t) = c0(t - time),  rest value for t < time
    command_limit      clamp to [min, max]
    command_rate_limit r follows c with -down <= dr/dt <= up; a jump of c becomes a ramp
    command_dead_zone  0 inside |c| <= w, c - sign(c) w outside
    command_backlash   play operator: |c - r| <= gap/2, r moves only when pushed
    asymmetric_gain    c < 0 is multiplied by ratio

Time is counted from the first sample. Before it the command was `rest`, and every operator with memory starts from
its value for the rest command.
"""

from dataclasses import dataclass

import numpy as np

# A neutral rate limit is the identity: from this value on a jump stays a jump.
UNLIMITED_RATE = 1e9


@dataclass
class PiecewiseLinear:
    """value[i] + slope[i] (t - start[i]) on [start[i], start[i+1]); start[0] = 0, the last piece ends at `end`."""

    start: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    end: float
    rest: float

    def pieces(self):
        """Tuples (start, duration, value, slope)."""
        return zip(self.start, np.diff(self.start, append=self.end), self.value, self.slope)


def holding(output, effects):
    """The constant command for which the output of the effects is this value."""
    ratio, width = effects["asymmetric_gain"]["ratio"], effects["command_dead_zone"]["half_width"]
    if output < 0.0:
        if ratio == 0.0:
            raise ValueError(f"no command gives {output}")
        output = output / ratio
    if output != 0.0:
        output += np.sign(output) * width
    limit = effects["command_limit"]
    if not limit["min"] <= output <= limit["max"]:
        raise ValueError(f"no command gives {output}")
    return output


class _Builder:
    """Collects pieces; a piece of no duration is replaced by its successor."""

    def __init__(self):
        self.rows = []

    def add(self, start, value, slope):
        if self.rows and self.rows[-1][0] >= start:
            start = self.rows.pop()[0]
        self.rows.append((start, value, slope))

    def signal(self, end, rest):
        rows = np.array(self.rows)
        return PiecewiseLinear(rows[:, 0], rows[:, 1], rows[:, 2], end, rest)


def sampled(time, samples, hold, rest, end):
    """Signal through the samples, held or linear between them; the last sample is held until `end`."""
    slope = np.zeros(len(time))
    if not hold:
        slope[:-1] = np.diff(samples) / np.diff(time)
    return PiecewiseLinear(np.array(time, float), np.array(samples, float), slope, end, rest)


def delay(signal, time):
    if time == 0.0:
        return signal
    late = signal.start + time
    kept = late < signal.end
    return PiecewiseLinear(np.r_[0.0, late[kept]], np.r_[signal.rest, signal.value[kept]],
                           np.r_[0.0, signal.slope[kept]], signal.end, signal.rest)


def _static(signal, levels, branch):
    """Apply a continuous function that is `offset + gain c` between the levels; branch(c) -> (offset, gain)."""
    out = _Builder()
    for start, duration, value, slope in signal.pieces():
        cuts = [(0.0, value)]
        if slope != 0.0:
            crossings = sorted(((level - value) / slope, level) for level in levels)
            cuts += [cut for cut in crossings if 0.0 < cut[0] < duration]
        for (after, left), (until, _) in zip(cuts, cuts[1:] + [(duration, None)]):
            offset, gain = branch(value + slope * 0.5 * (after + until))
            out.add(start + after, offset + gain * left, gain * slope)
    offset, gain = branch(signal.rest)
    return out.signal(signal.end, offset + gain * signal.rest)


def clamp(signal, lower, upper):
    if lower > upper:
        raise ValueError(f"command_limit: min {lower} is above max {upper}")
    return _static(signal, (lower, upper),
                   lambda c: (lower, 0.0) if c <= lower else (upper, 0.0) if c >= upper else (0.0, 1.0))


def dead_zone(signal, half_width):
    if half_width == 0.0:
        return signal
    return _static(signal, (-half_width, half_width),
                   lambda c: (0.0, 0.0) if abs(c) <= half_width else (-np.copysign(half_width, c), 1.0))


def asymmetric_gain(signal, ratio):
    if ratio == 1.0:
        return signal
    return _static(signal, (0.0,), lambda c: (0.0, ratio) if c < 0.0 else (0.0, 1.0))


def rate_limit(signal, up, down):
    """dr/dt = up while r < c, -down while r > c, clamp(dc/dt, -down, up) while r = c."""
    up = np.inf if up >= UNLIMITED_RATE else up
    down = np.inf if down >= UNLIMITED_RATE else down
    if np.isinf(up) and np.isinf(down):
        return signal
    out, r = _Builder(), signal.rest
    # A smaller distance between r and c is the rounding of the previous piece.
    same = 1e-14 * max(np.abs(signal.value).max(), abs(signal.rest))
    for start, duration, value, slope in signal.pieces():
        passed = 0.0
        distance = value - r
        limit = up if distance > 0.0 else -down
        if abs(distance) > same and np.isfinite(limit):
            closing = (limit - slope) * np.sign(distance)
            meeting = abs(distance) / closing if closing > 0.0 else np.inf
            out.add(start, r, limit)
            if meeting >= duration:
                r += limit * duration
                continue
            passed = meeting
        r = value + slope * passed
        followed = min(max(slope, -down), up)
        out.add(start + passed, r, followed)
        r += followed * (duration - passed)
    return out.signal(signal.end, signal.rest)


def play(signal, gap):
    """r stays while |c - r| < gap/2 and is carried along with c at either end of the play."""
    if gap == 0.0:
        return signal
    half, r, out = 0.5 * gap, signal.rest, _Builder()
    for start, duration, value, slope in signal.pieces():
        r = min(max(r, value - half), value + half)
        contact = np.inf
        if slope != 0.0:
            contact = max(0.0, (r + half * np.sign(slope) - value) / slope)
        if contact > 0.0:
            out.add(start, r, 0.0)
        if contact < duration:
            out.add(start + contact, r, slope)
            r = value + slope * duration - half * np.sign(slope)
    return out.signal(signal.end, signal.rest)


def shape(signal, effects):
    """The whole command side, in the order of the chain."""
    signal = delay(signal, effects["delay"]["time"])
    signal = clamp(signal, effects["command_limit"]["min"], effects["command_limit"]["max"])
    signal = rate_limit(signal, effects["command_rate_limit"]["up"], effects["command_rate_limit"]["down"])
    signal = dead_zone(signal, effects["command_dead_zone"]["half_width"])
    signal = play(signal, effects["command_backlash"]["gap"])
    return asymmetric_gain(signal, effects["asymmetric_gain"]["ratio"])
