"""Equations of motion of the rigs: position loops of five structures, none of which is the third-order servo of the product.

    r reference, x position of the load, v its speed, e = dead zone(r - measured position), all in deg and s
    friction at a speed v: (coulomb + load_friction |gravity|) against v; at rest it balances any smaller force

    MOTOR      u = [kp e + ki int(e)] in [-rate, rate];    v' = [(u - v)/lag] in [-acceleration, acceleration] - gravity sin(x + zero)
    CASCADE    v_r = [kp e] in [-rate, rate];  i_r = [kv (v_r - v) + kvi int(v_r - v)] in [-acceleration, acceleration]
               i' = (i_r - i)/lag;   v' = i - viscous v
    FLEXIBLE   torque = [kv (v_r - v1)] in [-acceleration, acceleration];  v1' = torque - ratio s - LuGre(v1) - viscous v1
               v' = s = w^2 (x1 - x) + 2 z w (v1 - v);  the encoder sits on the motor (x1) or on the load (x)
    DIGITAL    each control period: measured = x rounded to encoder steps, speed = its difference, low-passed;
               torque = [kv (v_r - speed)] in [-acceleration, acceleration], held;  v' = torque - viscous v
    HYDRAULIC  opening o' = (u/full_speed - o)/lag, |o| <= rate/full_speed;  q = full_speed o sqrt(1 - sign(o) P);
               P' = w^2/supply (q - v) - 2 z w P;   v' = supply P - viscous v - load;  P load pressure over supply pressure
    LuGre      z' = v - stiffness |v| z / g(v),  g = level (1 + excess exp(-(v/stribeck)^2)),  force = stiffness z

Semi-implicit Euler in steps of at most `STEP_S`; friction and LuGre are solved implicitly, without regularisation. The error is a
change of the damping by about w h / 2, below 2 %: a slightly different rig, not an artefact in its record.
"""

from collections import namedtuple

import numba
import numpy as np

STEP_S = 1e-4  # longest step
MOTOR, CASCADE, FLEXIBLE, DIGITAL, HYDRAULIC = range(5)
RADIANS = np.pi / 180.0

Rig = namedtuple(
    "Rig",
    "structure kp ki kv kvi lag viscous coulomb load_friction gravity zero ratio w z lugre_stiffness lugre_level lugre_excess stribeck "
    "encoder_on_load encoder_step control_period speed_filter supply full_speed load rate acceleration lowest highest half_width",
)
NEUTRAL = Rig(**{name: 0.0 for name in Rig._fields})._replace(
    kp=1.0, lag=1.0, w=1.0, stribeck=1.0, control_period=1e-3, supply=1.0, full_speed=1.0, rate=1e9, acceleration=1e12, lowest=-1e9,
    highest=1e9)  # fmt: skip


@numba.njit(cache=True)
def clamp(value, limit):
    return min(max(value, -limit), limit)


@numba.njit(cache=True)
def after_friction(v, held_back):
    """The speed after friction has reduced it by `held_back`, at most to zero."""
    return np.sign(v) * max(abs(v) - held_back, 0.0)


@numba.njit(cache=True)
def dead_zone(e, half_width):
    return max(e - half_width, 0.0) + min(e + half_width, 0.0)


@numba.njit(cache=True)
def march(rig, h, reference, start):
    """Load position, encoder position and speed of the load at the ends of the steps; at rest at `start` before."""
    count = len(reference)
    positions, encoder, speeds = np.zeros(count), np.zeros(count), np.zeros(count)
    x = x1 = measured_before = start
    v = v1 = bristle = integral = inner = current = opening = pressure = torque = filtered = 0.0
    period = max(1, int(round(rig.control_period / h)))
    for n in range(count):
        measured = x1 if rig.structure == FLEXIBLE and rig.encoder_on_load == 0.0 else x
        if rig.structure == DIGITAL and rig.encoder_step > 0.0:
            measured = rig.encoder_step * np.round(x / rig.encoder_step)
        e = dead_zone(reference[n] - measured, rig.half_width)
        wanted = rig.kp * e + rig.ki * integral
        speed_wanted = clamp(wanted, rig.rate)
        if wanted == speed_wanted or wanted * e < 0.0:  # anti-windup
            integral += h * e
        if rig.structure == MOTOR:
            gravity = rig.gravity * np.sin(RADIANS * (x + rig.zero))
            v += h * (clamp((speed_wanted - v) / rig.lag, rig.acceleration) - gravity)
            v = after_friction(v, h * (rig.coulomb + rig.load_friction * abs(gravity)))
        elif rig.structure == CASCADE:
            asked = rig.kv * (speed_wanted - v) + rig.kvi * inner
            allowed = clamp(asked, rig.acceleration)
            if asked == allowed:
                inner += h * (speed_wanted - v)
            current += h / rig.lag * (allowed - current)
            v += h * (current - rig.viscous * v)
            v = after_friction(v, h * rig.coulomb)
        elif rig.structure == FLEXIBLE:
            torque = clamp(rig.kv * (speed_wanted - v1), rig.acceleration)
            spring = rig.w**2 * (x1 - x) + 2.0 * rig.z * rig.w * (v1 - v)
            v1 += h * (torque - rig.ratio * spring - rig.viscous * v1 - rig.lugre_stiffness * bristle)
            if rig.lugre_level > 0.0:
                reach = rig.lugre_level / rig.lugre_stiffness * (1.0 + rig.lugre_excess * np.exp(-((v1 / rig.stribeck) ** 2)))
                bristle = (bristle + h * v1) / (1.0 + h * abs(v1) / reach)
            x1 += h * v1
            v = after_friction(v + h * spring, h * rig.coulomb)
        elif rig.structure == DIGITAL:
            if n % period == 0:
                difference = (measured - measured_before) / (period * h)
                measured_before = measured
                filtered += (difference - filtered) * period * h / (rig.speed_filter + period * h)
                torque = clamp(rig.kv * (speed_wanted - filtered), rig.acceleration)
            v += h * (torque - rig.viscous * v)
            v = after_friction(v, h * rig.coulomb)
        else:
            most = rig.rate / rig.full_speed
            opening = clamp(opening + h / rig.lag * (speed_wanted / rig.full_speed - opening), most)
            flow = rig.full_speed * opening * np.sqrt(max(1.0 - np.sign(opening) * pressure, 0.0))
            pressure += h * (rig.w**2 / rig.supply * (flow - v) - 2.0 * rig.z * rig.w * pressure)
            v += h * (rig.supply * pressure - rig.viscous * v - rig.load)
            v = after_friction(v, h * rig.coulomb)
        x += h * v
        if x > rig.highest or x < rig.lowest:
            x, v = min(max(x, rig.lowest), rig.highest), 0.0
        positions[n], speeds[n] = x, v
        encoder[n] = x1 if rig.structure == FLEXIBLE and rig.encoder_on_load == 0.0 else x
    return positions, encoder, speeds


@numba.njit(cache=True)
def play(wave, gap, start):
    """The output follows the input with free play, half of it on each side."""
    followed, held = np.zeros(len(wave)), start
    for n in range(len(wave)):
        held = min(max(held, wave[n] - 0.5 * gap), wave[n] + 0.5 * gap)
        followed[n] = held
    return followed


@numba.njit(cache=True)
def slew(wave, step, start):
    """The output follows the input by at most `step` per value."""
    followed, held = np.zeros(len(wave)), start
    for n in range(len(wave)):
        held += clamp(wave[n] - held, step)
        followed[n] = held
    return followed
