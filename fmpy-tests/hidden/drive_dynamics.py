"""Equations of motion of eight drives: a linear part that is propagated exactly, nonlinear terms as its inputs, friction and stops.

    z' = A z + B_u u + B_q q(z) + B_l l(z) + B_f f;   x, v of the motor or piston, y and yv of the load, all in deg and s
    u   demand of the controller, held over a control period           f   friction of motor or piston, an acceleration
    q   nonlinear part of the transmission or the power stage          l   a stiffening spring at the load, -hardening y^3

    EHA        n' = (u - n)/lag of the pump,  p' = oil (n - v) - leak p,  |p| <= relief,  v' = oil p - viscous v
    SPOOL      o'' = valve^2 (u - o) - 2 zeta valve o',  p' = oil (lap(o) sqrt(1 - sign(o) p/supply) - v) - leak p,  v' = oil p - viscous v
    PIEZO      U' = (u - U)/lag of the amplifier,  v' = resonance^2 (U - share D(U) - x) - 2 zeta resonance v
    LINEAR     i' = (u - i)/lag of the current,  v' = i - viscous v - cogging sin(2 pi x/pitch)
    HARMONIC   i' as above,  v' = i - viscous v - ratio T,  yv' = T - drag yv,  T = shaft^2 (s + e(x) + share D(s)) + 2 zeta shaft s'
    CABLE      the same with T of two cables, one of which is slack where s exceeds the pretension
    PWM, WORM  v' = (u - v)/lag - ratio T,  yv' = T - drag yv,  T with play of `gap`;  friction of a worm grows with |T|

s = x - y is the twist; e(x) the kinematic error (the effect of its slope, at most a tenth, on the motor torque is neglected); D Dahl's
operator, D' = r' - |r'| D/reach. Controllers see x: of EHA and SPOOL PI, of PIEZO I, of LINEAR, HARMONIC and CABLE P about a PI loop of the speed,
of PWM and WORM PD; the speed of CABLE and WORM is a difference of positions.

Steps are those of ETD2RK (Cox and Matthews, J. Comput. Phys. 176, 2002): q and l are linear within a step, the linear part is exact.
Friction is the force, held over the step, that brings the mass to rest at its end, limited to its level: a sticking mass does not creep.
"""

from collections import namedtuple

import numba
import numpy as np
from scipy import linalg

EHA, SPOOL, PIEZO, LINEAR, HARMONIC, CABLE, PWM, WORM = range(8)
UNLIMITED = 1e9

Rig = namedtuple(
    "Rig",
    "structure period kp ki kv kd feed_forward lag viscous oil leak valve valve_zeta supply overlap underlap relief resonance zeta share reach "
    "cogging pitch shaft ratio drag kinematic kinematic_per_deg pretension gap hardening coulomb stribeck stribeck_speed locking half_width rate "
    "acceleration lowest highest stop_low stop_high integral_limit",
)
NEUTRAL = Rig(**{name: 0.0 for name in Rig._fields})._replace(
    lag=1.0, valve=1.0, supply=UNLIMITED, relief=UNLIMITED, resonance=1.0, reach=1.0, pitch=1.0, shaft=1.0, pretension=UNLIMITED, stribeck_speed=1.0,
    rate=UNLIMITED, acceleration=UNLIMITED, lowest=-UNLIMITED, highest=UNLIMITED, stop_low=-UNLIMITED, stop_high=UNLIMITED,
    integral_limit=UNLIMITED)  # fmt: skip


def linear_part(rig):
    """A and the columns of u, q, l and f."""
    kind = rig.structure
    if kind in (EHA, SPOOL):
        a = np.zeros((4 if kind == EHA else 5,) * 2)  # x v p n, or x v p o o'
        a[0, 1], a[1, 1:3], a[2, 1:4] = 1.0, [-rig.viscous, rig.oil], [-rig.oil, -rig.leak, rig.oil]
        if kind == EHA:
            a[3, 3] = -1.0 / rig.lag
            return a, columns(4, {3: 1.0 / rig.lag}, {2: 1.0}, {1: 1.0}, {1: 1.0})
        a[3, 4], a[4, 3:] = 1.0, [-(rig.valve**2), -2.0 * rig.valve_zeta * rig.valve]
        return a, columns(5, {4: rig.valve**2}, {2: rig.oil}, {1: 1.0}, {1: 1.0})
    if kind in (PIEZO, LINEAR):
        a = np.zeros((3, 3))  # x v U, or x v i
        a[0, 1], a[2, 2] = 1.0, -1.0 / rig.lag
        w = rig.resonance
        a[1] = [-(w**2), -2.0 * rig.zeta * w, w**2] if kind == PIEZO else [0.0, -rig.viscous, 1.0]
        return a, columns(3, {2: 1.0 / rig.lag}, {1: 1.0}, {1: 1.0}, {1: 1.0})
    electric = kind in (HARMONIC, CABLE)
    count = 5 if electric else 4
    a = np.zeros((count, count))  # x v y yv, and i
    torque = np.array([rig.shaft**2, 2.0 * rig.zeta * rig.shaft, -(rig.shaft**2), -2.0 * rig.zeta * rig.shaft])
    a[0, 1] = a[2, 3] = 1.0
    a[1, :4], a[3, :4] = -rig.ratio * torque, torque
    a[3, 3] -= rig.drag
    if electric:
        a[1, 1] -= rig.viscous
        a[1, 4], a[4, 4] = 1.0, -1.0 / rig.lag
    else:
        a[1, 1] -= 1.0 / rig.lag
    return a, columns(count, {4 if electric else 1: 1.0 / rig.lag}, {1: -rig.ratio, 3: 1.0}, {3: 1.0}, {1: 1.0})


def columns(count, *entries):
    b = np.zeros((count, len(entries)))
    for column, rows in enumerate(entries):
        for row, value in rows.items():
            b[row, column] = value
    return b


def propagators(a, b, h):
    """For a step h: e^(A h), the weight of held inputs, and that of inputs that rise linearly from 0 to their value."""
    n, m = b.shape
    whole = linalg.expm(np.block([[a * h, b * h, np.zeros((n, m))], [np.zeros((m, n + m)), np.eye(m)], [np.zeros((m, n + 2 * m))]]))
    return tuple(np.ascontiguousarray(part) for part in (whole[:n, :n], whole[:n, n : n + m], whole[:n, n + m :]))


@numba.njit(cache=True)
def limited(value, limit):
    return min(max(value, -limit), limit)


@numba.njit(cache=True)
def control(rig, z, c, memory, seconds):
    """The demand of a controller from now on; its memory is the previous [integral, reference, position]."""
    error = c - z[0]
    beyond = error - limited(error, rig.half_width)
    if rig.structure == PIEZO:
        memory[0] = min(max(memory[0] + limited(rig.ki * error, rig.rate) * seconds, rig.lowest), rig.highest)
        return memory[0]
    if rig.structure == EHA or rig.structure == SPOOL:
        memory[0] = limited(memory[0] + rig.ki * error * seconds, rig.integral_limit)
        return limited(rig.kp * (error if rig.structure == SPOOL else beyond) + memory[0], rig.rate)
    speed = (z[0] - memory[2]) / seconds if rig.structure == CABLE or rig.structure == WORM else z[1]
    memory[2] = z[0]
    if rig.structure == PWM or rig.structure == WORM:
        return limited(rig.kp * beyond - rig.kd * speed, rig.rate)
    missing = limited(rig.kp * beyond + rig.feed_forward * (c - memory[1]) / seconds, rig.rate) - speed
    memory[1] = c
    memory[0] = limited(memory[0] + rig.ki * missing * seconds, rig.integral_limit)
    return limited(rig.kv * missing + memory[0], rig.acceleration)


@numba.njit(cache=True)
def dahl(rig, before, change):
    """The operator after a monotonic change of its argument."""
    side = rig.reach if change > 0.0 else -rig.reach
    return side + (before - side) * np.exp(-abs(change) / rig.reach)


@numba.njit(cache=True)
def stretch(rig, z):
    """Argument of the hysteresis: voltage, or twist."""
    return z[2] if rig.structure == PIEZO else z[0] - z[2]


@numba.njit(cache=True)
def beyond_linear(rig, z, hysteresis):
    """q: the terms not in A."""
    if rig.structure == EHA:
        return 0.0
    if rig.structure == SPOOL:
        opening = limited(z[3], rig.rate)
        flow = opening - limited(opening, rig.overlap) + limited(opening, rig.underlap)
        return flow * np.sqrt(max(1.0 - (1.0 if flow > 0.0 else -1.0) * z[2] / rig.supply, 0.0)) - z[3]
    if rig.structure == PIEZO:
        return -(rig.resonance**2) * rig.share * hysteresis
    if rig.structure == LINEAR:
        return -rig.cogging * np.sin(2.0 * np.pi * z[0] / rig.pitch)
    twist = z[0] - z[2]
    if rig.structure == HARMONIC:
        return rig.shaft**2 * (rig.kinematic * np.sin(rig.kinematic_per_deg * z[0]) + rig.share * hysteresis)
    engaged = twist - limited(twist, 0.5 * rig.gap)
    slack = 0.5 * (limited(engaged, rig.pretension) - engaged)  # one of two cables is slack: half of the stiffness is lost
    if rig.gap == 0.0:
        return rig.shaft**2 * slack
    brake = 2.0 * rig.zeta * rig.shaft * (z[1] - z[3])
    torque = rig.shaft**2 * (engaged + slack) + brake
    if engaged == 0.0 or torque * engaged < 0.0:  # apart: contact does not pull
        torque = 0.0
    return torque - rig.shaft**2 * twist - brake


@numba.njit(cache=True)
def friction_level(rig, z):
    """Coulomb friction, increased near rest (Stribeck), and in a worm gear the part proportional to the load."""
    level = rig.coulomb * (1.0 + rig.stribeck * np.exp(-((z[1] / rig.stribeck_speed) ** 2)))
    if rig.locking > 0.0:
        twist = z[0] - z[2]
        level += rig.locking * rig.ratio * rig.shaft**2 * abs(twist - limited(twist, 0.5 * rig.gap))
    return level


@numba.njit(cache=True)
def march(rig, phi, held, rising, reference, h, at):
    """State `at` at the ends of the steps of the reference; at rest at 0 before. `period` counts steps."""
    seen, z, memory = np.zeros(len(reference)), np.zeros(len(phi)), np.zeros(3)
    period, u, hysteresis = int(rig.period), 0.0, 0.0
    memory[1] = reference[0]
    loaded, hysteretic = rig.hardening != 0.0, rig.share > 0.0
    stopped = len(phi) > 3 and rig.structure > LINEAR  # index of the mass that reaches the stops: the load, if there is one
    place = 2 if stopped else 0
    for n in range(len(reference)):
        if n % period == 0:
            u = control(rig, z, reference[n], memory, period * h)
        q, load = beyond_linear(rig, z, hysteresis), -rig.hardening * z[place] ** 3
        after = phi @ z + held[:, 0] * u + held[:, 1] * q
        if loaded:
            after += held[:, 2] * load
        predicted = dahl(rig, hysteresis, stretch(rig, after) - stretch(rig, z)) if hysteretic else 0.0
        after += rising[:, 1] * (beyond_linear(rig, after, predicted) - q)
        if loaded:
            after += rising[:, 2] * (-rig.hardening * after[place] ** 3 - load)
        if rig.coulomb > 0.0:
            needed, level = -after[1] / held[1, 3], friction_level(rig, z)
            after += held[:, 3] * limited(needed, level)
            if abs(needed) <= level:
                after[1] = 0.0
                if z[1] == 0.0:  # it sticks for the whole step
                    after[0] = z[0]
        if rig.structure == EHA:
            after[2] = limited(after[2], rig.relief)
        if after[place] > rig.stop_high:
            after[place], after[place + 1] = rig.stop_high, min(after[place + 1], 0.0)
        elif after[place] < rig.stop_low:
            after[place], after[place + 1] = rig.stop_low, max(after[place + 1], 0.0)
        if hysteretic:
            hysteresis = dahl(rig, hysteresis, stretch(rig, after) - stretch(rig, z))
        z = after
        seen[n] = z[at]
    return seen
