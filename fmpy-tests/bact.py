"""The independent truth: the exact response of the FMU, derived from the report alone and not from the product.

Source: Waszak and Fung, NASA/TM-1998-208452, tables 1 and 2, equation (1) (third order) and equation (6) (second order)::

    position    k p w^2                                                      k w^2
    -------- = ---------------------------- (1)              = -------------------- (6)
    command    (s + p)(s^2 + 2 z w s + w^2)                    s^2 + 2 z w s + w^2

In the time domain, with pole state x, drive position d and its rate v::

    x' = p (k c - x)   (eq. (6): x = k c),      d' = v,      v' = w^2 (x - d) - 2 z w v

Everything exact in time is written as partial fractions over the three poles: every mode is one complex exponential, so
p h = 1.5e6 (us-late-loaded at 5 ms) is as harmless as p h = 1e-3. Scaling and squaring of a matrix exponential is not:
it loses digits in step with log2(p h). `test_truth.py` compares this file with a 160-digit matrix exponential.

Not covered: a pole p that coincides with a second-order pole, and z = 1 (double pole). No tabulated set comes near.
"""

import cmath
import functools
from dataclasses import dataclass

import numpy as np

SECOND, THIRD = "second", "third"  # item names of the FMU's enumeration `order`
ORDERS = (SECOND, THIRD)

CONTROL_PERIOD_S = 0.005  # the BACT records hold 200 samples per second (report, "Experimental Data")
LOWEST_HZ, HIGHEST_HZ = 0.5, 12.0  # the frequency range of the report's figures
MAGNITUDE_TOLERANCE = 1e-6  # deg/deg; guaranteed by the product, far above rounding (1e-13)
PHASE_TOLERANCE_DEG = 1e-4  # guaranteed by the product


@dataclass(frozen=True)
class ParameterSet:
    """One row of tables 1 and 2: gain k [deg/deg], pole p [1/s], omega [rad/s], damping ratio zeta [1]."""

    number: int  # `set_number` of the FMU
    surface: str
    stage: str
    load_case: str
    k: float
    p: float
    omega: float
    zeta: float

    @property
    def name(self):
        return f"{INITIALS[self.surface]}-{self.stage}-{self.load_case}"


TE, US, LS = "trailing_edge", "upper_spoiler", "lower_spoiler"
INITIALS = {TE: "te", US: "us", LS: "ls"}

SETS = (
    # table 1, no aerodynamic load
    ParameterSet(1, TE, "early", "unloaded", 1.0198, 10_000.0, 165.26, 0.5624),
    ParameterSet(2, TE, "middle", "unloaded", 1.0413, 10_000.0, 223.57, 0.7269),
    ParameterSet(3, TE, "late", "unloaded", 1.0159, 10_000.0, 212.50, 0.5776),
    ParameterSet(4, US, "early", "unloaded", 1.1617, 10_000.0, 164.00, 0.8478),
    ParameterSet(5, US, "middle", "unloaded", 1.1180, 10_000.0, 142.02, 0.6463),
    ParameterSet(6, US, "late", "unloaded", 1.1219, 10_000.0, 138.21, 0.6024),
    ParameterSet(7, LS, "early", "unloaded", 1.0903, 10_000.0, 168.45, 0.7583),
    ParameterSet(8, LS, "middle", "unloaded", 1.0362, 10_000.0, 155.08, 0.6795),
    ParameterSet(9, LS, "late", "unloaded", 1.0942, 10_000.0, 175.77, 0.7885),
    # table 2, with aerodynamic load; its last row (lower spoiler, late) is N/A
    ParameterSet(10, TE, "early", "loaded", 0.9607, 10_000.0, 139.20, 0.4281),
    ParameterSet(11, TE, "middle", "loaded", 0.9345, 10_000.0, 133.44, 0.4055),
    ParameterSet(12, TE, "late", "loaded", 1.0468, 6_898.0, 242.32, 0.7475),
    ParameterSet(13, US, "early", "loaded", 1.1152, 9_995.0, 125.65, 0.6187),
    ParameterSet(14, US, "middle", "loaded", 1.1702, 9_996.0, 135.87, 0.6827),
    ParameterSet(15, US, "late", "loaded", 1.0767, 2.97e8, 100.72, 0.4615),
    ParameterSet(16, LS, "early", "loaded", 1.0289, 9_998.0, 145.07, 0.6314),
    ParameterSet(17, LS, "middle", "loaded", 1.0265, 9_999.0, 150.85, 0.6444),
)
BY_NAME = {s.name: s for s in SETS}
STIFFEST = BY_NAME["us-late-loaded"]
NOT_IN_THE_REPORT = (LS, "late", "loaded")


def poles(s, order):
    """The poles of equation (6), or of equation (1) with -p first."""
    pair = [s.omega * (-s.zeta + sign * 1j * cmath.sqrt(1 - s.zeta**2)) for sign in (1, -1)]
    return np.array(([complex(-s.p)] if order == THIRD else []) + pair)


def residues(s, order):
    """r_i of H(s) = sum r_i / (s - s_i)."""
    pole = poles(s, order)
    numerator = s.k * s.omega**2 * (s.p if order == THIRD else 1.0)
    return np.array([numerator / np.prod(si - np.delete(pole, i)) for i, si in enumerate(pole)])


def frequency_response(s, order, frequency_hz):
    """Equations (1) and (6) at s = j 2 pi f: the analytic, continuous frequency response [deg/deg]."""
    jw = 2j * np.pi * np.asarray(frequency_hz, dtype=float)
    response = s.k * s.omega**2 / (jw**2 + 2 * s.zeta * s.omega * jw + s.omega**2)
    return response * s.p / (jw + s.p) if order == THIRD else response


def sampled_response(s, order, frequency_hz, h, linear=False):
    """The exact sampled response: position samples over command samples in steady state, at z = exp(j 2 pi f h).

    Between samples the command is held, or (`linear`) a straight line to the next sample. Each mode y_i' = s_i y_i + r_i c
    then advances by y_i+ = e^q y_i + r_i h [phi1(q) c + phi2(q) (c+ - c)] with q = s_i h, phi1 = (e^q - 1)/q,
    phi2 = (e^q - 1 - q)/q^2, and c+ = z c. No approximation: this is the z-transform of the exact solution.
    """
    z = np.exp(2j * np.pi * np.asarray(frequency_hz, dtype=float) * h)
    total = np.zeros_like(z)
    for pole, residue in zip(poles(s, order), residues(s, order)):
        q = pole * h
        phi1 = np.expm1(q) / q
        phi2 = (phi1 - 1) / q
        total += residue * h * (phi1 + ((z - 1) * phi2 if linear else 0)) / (z - np.exp(q))
    return total


def account_for_hold(s, order, frequency_hz, h, linear=False):
    """The factor that turns a measured sampled response into the continuous one.

    A held sine is not a sine: it is the sine times (1 - e^(-jwh))/(jwh), plus copies around every multiple of 1/h, which the
    actuator passes on and sampling folds back: H_sampled(w) = sum over m of H(j w_m) hold(w_m), w_m = w + 2 pi m/h. For a
    straight line the hold is sinc^2. `sampled_response` is that sum in closed form (`test_truth.py` sums it term by
    term), so H/H_sampled is the correction for the hold. It is about half a period of delay: 10.8 deg at 12 Hz.
    """
    return frequency_response(s, order, frequency_hz) / sampled_response(s, order, frequency_hz, h, linear)


@functools.lru_cache(maxsize=4096)
def transition(s, order, h):
    """exp(A h) of (x, d, v) for zero command, one exponential per pole (Lagrange's form of the partial fractions)."""
    s2, s3 = poles(s, SECOND)
    e2, e3, gap = cmath.exp(s2 * h), cmath.exp(s3 * h), s2 - s3
    matrix = np.zeros((3, 3))
    matrix[1, 1] = ((s2 * e3 - s3 * e2) / gap).real
    matrix[1, 2] = ((e2 - e3) / gap).real
    matrix[2, 1] = (s2 * s3 * (e3 - e2) / gap).real
    matrix[2, 2] = ((s2 * e2 - s3 * e3) / gap).real
    if order == THIRD:
        decay, w2 = np.exp(-s.p * h), s.omega**2
        share_p, share_2, share_3 = w2 / ((s.p + s2) * (s.p + s3)), w2 / ((s2 + s.p) * gap), -w2 / ((s3 + s.p) * gap)
        matrix[0, 0] = decay
        matrix[1, 0] = (share_p * decay + share_2 * e2 + share_3 * e3).real
        matrix[2, 0] = (-s.p * share_p * decay + share_2 * s2 * e2 + share_3 * s3 * e3).real
    matrix.flags.writeable = False
    return matrix


def steady_motion(s, order, command, slope):
    """The forced motion (x, d, v) under a command of this value and slope, after all transients."""
    lag = 1 / s.p if order == THIRD else 0.0
    return s.k * np.array([command - slope * lag, command - slope * (lag + 2 * s.zeta / s.omega), slope])


def advance(s, order, state, command, h, slope=0.0):
    """(x, d, v) a time h later, exactly, for the command c(t) = command + slope t."""
    later = steady_motion(s, order, command + slope * h, slope)
    return later + transition(s, order, h) @ (state - steady_motion(s, order, command, slope))


def at_rest(position):
    """The drive at rest at `position` without acceleration: the pole state equals the drive position."""
    return np.array([position, position, 0.0])


def respond(s, order, commands, steps, slopes=None, initial_position=0.0, state=None):
    """States (x, d, v) at the end of every step, shape (n, 3). `steps` [s] and `slopes` [deg/s] may be single numbers."""
    commands = np.asarray(commands, dtype=float)
    steps = np.broadcast_to(steps, commands.shape)
    slopes = np.broadcast_to(0.0 if slopes is None else slopes, commands.shape)
    state = at_rest(initial_position) if state is None else state
    states = np.empty((commands.size, 3))
    for i, (command, h, slope) in enumerate(zip(commands, steps, slopes)):
        states[i] = state = advance(s, order, state, float(command), float(h), float(slope))
    return states


def output_derivatives(s, order, state, command, slope=0.0):
    """(d, d', d'', d''') just before a communication point, where the command still has this value and slope."""
    x, d, v = state
    x, x_rate = (x, s.p * (s.k * command - x)) if order == THIRD else (s.k * command, s.k * slope)
    acceleration = s.omega**2 * (x - d) - 2 * s.zeta * s.omega * v
    return d, v, acceleration, s.omega**2 * (x_rate - v) - 2 * s.zeta * s.omega * acceleration


def command_sensitivity(s, order, h):
    """Derivative of (d, v) at the end of a step of length h with respect to the command held over it."""
    step = advance(s, order, at_rest(0.0), 1.0, h)
    return step[1], step[2]
