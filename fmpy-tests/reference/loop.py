"""The servo loop: drive position d and rate v with all limits, dead zone and friction.

    error   e = x - d through a dead zone w
    drive     = clamp(omega^2 error, -a, a)
    force   F = drive - 2 zeta omega v - omega^2 cubic d^3 + omega^2 (load + bias - stiffness d)
    d' = v,   v' = F - omega^2 level sign(v);   v in [-down, up];   d in [min, max], stops without rebound

At any time the loop is in one motion and in one region of the drive, and within these everything is smooth:

    motion        holds while                                        then
    FREE          -down < v < up, min < d < max  (level = 0)         AT_UP, AT_DOWN, ON_MAX, ON_MIN
    FORWARD       0 < v < up, d < max            (level > 0)         STICK, AT_UP, ON_MAX
    BACKWARD      -down < v < 0, d > min         (level > 0)         STICK, AT_DOWN, ON_MIN
    AT_UP         F >= omega^2 level, d < max                        FORWARD or FREE, ON_MAX
    AT_DOWN       F <= -omega^2 level, d > min                       BACKWARD or FREE, ON_MIN
    STICK         |F| <= omega^2 level, v = 0                        FORWARD, BACKWARD
    ON_MAX        F >= -omega^2 level, d = max, v = 0                BACKWARD or FREE
    ON_MIN        F <= omega^2 level, d = min, v = 0                 FORWARD or FREE
    FROZEN        failure `stuck`                                    STICK, ON_MAX, ON_MIN or FREE

The drive is a continuous polygon of e: limit, slope, dead zone, slope, limit (the regions). A motion that holds for
no time at all is left at once for its successor, so that several events at one instant need no special case.
"""

from dataclasses import dataclass

import numpy as np

from . import spectral

NONE, PASSIVE, STUCK, HARDOVER_POSITIVE, HARDOVER_NEGATIVE = range(5)
FREE, FORWARD, BACKWARD, AT_UP, AT_DOWN, STICK, ON_MAX, ON_MIN, FROZEN = (
    "free", "forward", "backward", "at_up", "at_down", "stick", "on_max", "on_min", "frozen")
LIMITED = (AT_UP, AT_DOWN, ON_MAX, ON_MIN)
RESTING = (STICK, ON_MAX, ON_MIN, FROZEN)

# Tolerance of guards relative to the signal: far above rounding (1e-15), far below the required 1e-7.
TOLERANCE = 1e-12
# A stretch is shortened until its last Chebyshev coefficients are below this fraction of omega x signal.
TAIL = 1e-12
# After this many changes at one instant the valid motion must be shorter than the nodes resolve: a load that jumps
# against the pole moves the drive for a nanosecond. Each further change refines the resolution by this factor.
AT_ONCE, CLOSER = 4, 0.1
# More changes of motion than this without time passing: the equations would have no solution.
MOST_CHANGES = 40


@dataclass
class Stretch:
    """A smooth piece of trajectory: duration, and d and v on the nodes."""

    duration: float
    d: np.ndarray
    v: np.ndarray


@dataclass
class Region:
    """drive = omega^2 (gain e + offset) for lower <= e <= upper."""

    lower: float
    upper: float
    gain: float
    offset: float
    limited: bool


class Loop:
    def __init__(self, base, effects, initial_position, scale, refinement=1.0):
        _, _, self.omega, self.zeta = base
        self.omega_squared = self.omega**2
        self.cubic = effects["amplitude_gain"]["cubic"]
        self.stiffness, self.bias = effects["hinge_load"]["stiffness"], effects["hinge_load"]["bias"]
        self.level = effects["coulomb_friction"]["level"] * self.omega**2
        self.up, self.down = effects["rate_limit"]["up"], effects["rate_limit"]["down"]
        self.lowest, self.highest = effects["position_limit"]["min"], effects["position_limit"]["max"]
        self.regions = _regions(effects["dead_zone"]["half_width"],
                                effects["acceleration_limit"]["value"] / self.omega**2)
        self.refinement = refinement
        self.scale = scale
        self.tolerance_d = TOLERANCE * scale
        self.tolerance_v = TOLERANCE * scale * self.omega
        self.tolerance_f = TOLERANCE * scale * self.omega**2
        self.d = min(max(initial_position, self.lowest), self.highest)
        self.v = 0.0
        self.failure = NONE
        self.region = self._region_of(0.0)
        self.motion = self._from_rest()

    # -- present motion of the loop -----------------------------------------------------------------------------

    @property
    def saturated(self):
        """A rate limit or a stop acts, or the drive is at the acceleration limit and connected."""
        drive = self.failure not in (PASSIVE, STUCK) and self.regions[self.region].limited
        return self.failure != STUCK and (self.motion in LIMITED or drive)

    def _from_rest(self):
        if self.d >= self.highest:
            return ON_MAX
        if self.d <= self.lowest:
            return ON_MIN
        return STICK if self.level > 0.0 else FREE

    def _region_of(self, e):
        return next(i for i, region in enumerate(self.regions) if e <= region.upper)

    def _moving(self, direction):
        return FREE if self.level == 0.0 else FORWARD if direction > 0 else BACKWARD

    def _target(self, interval, s):
        if self.failure == HARDOVER_POSITIVE:
            return self.highest + 0.0 * s
        if self.failure == HARDOVER_NEGATIVE:
            return self.lowest + 0.0 * s
        return interval.target_at(s)

    # -- one interval between breakpoints -----------------------------------------------------------------------

    def advance(self, interval):
        """Move over the interval; yields its stretches. `saturated` and `v` before the first one are the state
        just after the interval's start, once the changes of motion at that instant are done."""
        if interval.failure != self.failure:
            self.failure = interval.failure
            if self.failure == STUCK:
                self.motion, self.v = FROZEN, 0.0
            elif self.motion == FROZEN:
                self.motion = self._from_rest()
        e = float(self._target(interval, 0.0)) - self.d
        region = self.regions[self.region]
        if not region.lower - self.tolerance_d <= e <= region.upper + self.tolerance_d:
            self.region = self._region_of(e)
        s, changes = 0.0, 0
        while s < interval.duration:
            h, d, v, force, e = self._solve(interval, s, changes)
            rows, tolerances, successors = self._guards(d, v, force, e)
            x, row = None, None
            if rows:
                x, row = spectral.first_violation(np.array(rows), np.array(tolerances))
            if x is None:
                yield Stretch(h, d, v)
                self.d, self.v = float(d[-1]), float(v[-1])
                s, changes = (s + h if s + h < interval.duration * (1.0 - 1e-15) else interval.duration), 0
                continue
            if x > 0.0:
                part = spectral.restriction(0.0, x).T
                yield Stretch(x * h, d @ part, v @ part)
                self.d, self.v = float(spectral.interpolate(d, x)), float(spectral.interpolate(v, x))
                s, changes = s + x * h, 0
            changes += 1
            if changes > MOST_CHANGES:
                raise RuntimeError(f"no motion holds at d = {self.d}, v = {self.v}: {self.motion}, {self.region}")
            successors[row]()

    def _step(self, interval, s):
        """Longest step the polynomials can follow: the loop's frequencies, and the pole while it rings."""
        stiffening = max(0.0, 1.0 + self.stiffness + 3.0 * self.cubic * self.d**2)
        fastest = self.omega * max(np.sqrt(stiffening), 2.0 * self.zeta, 1.0)
        longest = spectral.LARGEST_PHASE / fastest
        left = interval.duration - s
        if s < interval.transient_end:
            longest = min(longest, spectral.LARGEST_DECAY / interval.pole)
            ringing = (interval.transient_end - s) * (1.0 + 1e-12)
            if ringing < left:
                return ringing / np.ceil(ringing * self.refinement / longest)
        return left / np.ceil(left * self.refinement / longest)

    def _solve(self, interval, s, changes):
        """One stretch in the present motion and region: h, and d, v, force without friction, e on the nodes."""
        h = self._step(interval, s) * CLOSER ** max(0, changes - AT_ONCE)
        for _ in range(60):
            t = s + h * spectral.NODES
            x = self._target(interval, t)
            region = self.regions[self.region]
            gain, offset = (0.0, 0.0) if self.failure == PASSIVE else (region.gain, region.offset)
            external = interval.load[0] + interval.load[1] * t + self.bias
            applied = self.omega_squared * (gain * x + offset + external)
            restoring = self.omega_squared * (gain + self.stiffness)
            damping = 2.0 * self.zeta * self.omega
            if self.motion in (FREE, FORWARD, BACKWARD):
                friction = self.level * ((self.motion == FORWARD) - (self.motion == BACKWARD))
                acceleration = self._collocate(h, applied - friction, damping, restoring)
                if acceleration is None:
                    h *= 0.5
                    continue
                v = self.v + h * (spectral.INTEGRAL @ acceleration)
                d = self.d + h * (self.v * spectral.NODES + h * (spectral.INTEGRAL_TWICE @ acceleration))
                if np.abs(spectral.HIGHEST_COEFFICIENTS @ v).max() > TAIL * self.omega * max(
                        self.scale, abs(self.d)):
                    h *= 0.5
                    continue
                force = acceleration + friction
            else:
                v = np.full(len(t), self.v)
                d = self.d + h * self.v * spectral.NODES
                force = applied - damping * v - restoring * d - self.omega_squared * self.cubic * d**3
            return h, d, v, force, x - d
        raise FloatingPointError(f"the drive runs away: d = {self.d} deg, v = {self.v} deg/s, cubic = {self.cubic}")

    def _collocate(self, h, applied, damping, restoring):
        """Node values of a = v' = applied - damping v - restoring d - omega^2 cubic d^3, or None."""
        linear = (spectral.IDENTITY + damping * h * spectral.INTEGRAL
                  + restoring * h * h * spectral.INTEGRAL_TWICE)
        coasting = self.d + h * self.v * spectral.NODES
        right = applied - damping * self.v - restoring * coasting
        if self.cubic == 0.0:
            return np.linalg.solve(linear, right)
        # Newton's method; it converges quadratically from the solution for constant d, or the step was too long.
        cubic = self.omega_squared * self.cubic
        a = np.linalg.solve(linear, right - cubic * self.d**3)
        for _ in range(12):
            d = coasting + h * h * (spectral.INTEGRAL_TWICE @ a)
            if not np.all(np.abs(d) < 1e50):
                return None
            jacobian = linear + (3.0 * cubic * h * h * d * d)[:, None] * spectral.INTEGRAL_TWICE
            change = np.linalg.solve(jacobian, right - cubic * d**3 - linear @ a)
            a = a + change
            if np.abs(change).max() <= 1e-13 * (np.abs(a).max() + self.omega_squared * self.scale):
                return a
        return None

    # -- guards and successors ----------------------------------------------------------------------------------

    def _guards(self, d, v, force, e):
        """What must stay >= 0 in the present motion and region, with tolerances and what happens otherwise.

        The regions come first: at one instant, the drive is put right before the forces are judged."""
        rows, tolerances, successors = [], [], []

        def guard(row, tolerance, successor, *arguments):
            rows.append(row)
            tolerances.append(tolerance)
            successors.append(lambda: successor(*arguments))

        if self.motion == FROZEN:
            return rows, tolerances, successors
        if self.failure != PASSIVE:
            region = self.regions[self.region]
            if np.isfinite(region.lower):
                guard(e - region.lower, self.tolerance_d, self._change_region, -1)
            if np.isfinite(region.upper):
                guard(region.upper - e, self.tolerance_d, self._change_region, 1)
        if self.motion in (FREE, FORWARD, AT_UP):
            guard(self.highest - d, self.tolerance_d, self._hit, self.highest, ON_MAX)
        if self.motion in (FREE, BACKWARD, AT_DOWN):
            guard(d - self.lowest, self.tolerance_d, self._hit, self.lowest, ON_MIN)
        if self.motion in (FREE, FORWARD):
            guard(self.up - v, self.tolerance_v, self._change, AT_UP, self.up)
        if self.motion in (FREE, BACKWARD):
            guard(v + self.down, self.tolerance_v, self._change, AT_DOWN, -self.down)
        if self.motion == FORWARD:
            guard(v, self.tolerance_v, self._change, STICK, 0.0)
        if self.motion == BACKWARD:
            guard(-v, self.tolerance_v, self._change, STICK, 0.0)
        if self.motion == AT_UP:
            guard(force - self.level, self.tolerance_f, self._change, self._moving(1), self.up)
        if self.motion == AT_DOWN:
            guard(-force - self.level, self.tolerance_f, self._change, self._moving(-1), -self.down)
        if self.motion in (STICK, ON_MIN):
            guard(self.level - force, self.tolerance_f, self._change, self._moving(1), 0.0)
        if self.motion in (STICK, ON_MAX):
            guard(self.level + force, self.tolerance_f, self._change, self._moving(-1), 0.0)
        return rows, tolerances, successors

    def _change_region(self, by):
        self.region += by

    def _hit(self, stop, motion):
        self.d, self.v, self.motion = stop, 0.0, motion

    def _change(self, motion, v):
        self.v, self.motion = v, motion


def _regions(half_width, limit):
    """The polygon drive(e): limit, slope, dead zone (unless it has no width), slope, limit."""
    w, far = half_width, half_width + limit
    inside = ([Region(-far, far, 1.0, 0.0, False)] if w == 0.0 else
              [Region(-far, -w, 1.0, w, False), Region(-w, w, 0.0, 0.0, False), Region(w, far, 1.0, -w, False)])
    return [Region(-np.inf, -far, 0.0, -limit, True), *inside, Region(far, np.inf, 0.0, limit, True)]
