"""Equations of motion of six more rigs: a drive and a load behind an elastic coupling with play, under six kinds of control.

    c reference, x drive, y load; v and u their speeds; e = dead zone(c - x) with half_width; [..] limited; all in deg and s
    coupling   s = x - y,  T = k dead zone(s, gap/2) + d (v - u) in contact, never against s;  k = r (1 - r) w^2,  d = 2 r (1 - r) z w
               (1 - r) v' = a - T,   r u' = T - r load_damping u, less friction, r = load_share, stops at the load
    BRUSHLESS  each period: v_r = [kp e + feed_forward f], i_r = [kv (v_r - v) + int ki (v_r - v)], in force a period later;
               f the speed of c, smoothed;   a' = (i_r - a)/lag
    SERVOVALVE each period: o_r = [kp (c - x)];  o'' = w^2 (o_r - o) - 2 z w o' of the valve;  o behind a dead zone of kp half_width;
               P' = w (o sqrt(1 - sign(o) P/supply) - v) - 2 z w P of the oil,  a = [w P];  supply 0: no root
    PNEUMATIC  each period: p_r = [dead zone(kp (c - x) + int ki (c - x))];  P' = (p_r - P)/lag,  a = [(P - v)/motor_lag]
    RC_SERVO   each period: m_r = [kp e - kd v],   a = [(m_r - v)/motor_lag]
    VOICE_COIL one mass on a flexure: a = [coil dead zone(gain c - feedback x) - kd v] - w^2 (x + cubic x^3) - 2 z w v, less friction;
               the sensor sees x + mode_gain (q - x),  q a mode of x
    STEPPER    r' = [filter_1 dead zone(r_2 - r)],  r_2' = filter_2 (c - r_2);  a = [w^2 sin(poles (R - x))/poles] - 2 z w v,
               R = r in microsteps

`rate` limits v_r, o_r, p_r, m_r and r'; `acceleration` limits i_r or a. Semi-implicit Euler in steps of 50 us; friction is solved implicitly.
"""

from collections import namedtuple

import numba
import numpy as np

from .rig_equations import after_friction, clamp, dead_zone

STEP_S = 5e-5
BRUSHLESS, SERVOVALVE, PNEUMATIC, RC_SERVO, VOICE_COIL, STEPPER = range(6)
SMOOTHING = 0.1  # of the fed-forward speed, per control period

Rig = namedtuple(
    "Rig",
    "structure period kp ki kv kd feed_forward integral_limit lag motor_lag valve_w valve_z w z supply coil gain feedback mode_w mode_z mode_gain "
    "filter_1 filter_2 poles microstep load_share coupling_w coupling_z load_damping at_load rate acceleration lowest highest gap coulomb "
    "half_width cubic",
)
NEUTRAL = Rig(**{name: 0.0 for name in Rig._fields})._replace(
    period=1.0, lag=1.0, motor_lag=1.0, w=1.0, valve_w=1.0, mode_w=1.0, poles=1.0, microstep=1.0, load_share=0.5, coupling_w=1.0, at_load=1.0,
    rate=1e9, acceleration=1e9, lowest=-1e9, highest=1e9)  # fmt: skip


@numba.njit(cache=True)
def march(rig, h, reference):
    """The position at the sensor at the ends of the steps; at rest at 0 before. `period` counts steps."""
    seen = np.zeros(len(reference))
    x = v = load = load_speed = mode = mode_rate = 0.0
    integral = asked = ahead = current = smoothed = opening = opening_rate = pressure = profile = profile_2 = 0.0
    before, period, seconds = reference[0], int(rig.period), rig.period * h
    for n in range(len(reference)):
        c, tick = reference[n], n % period == 0
        if rig.structure == BRUSHLESS:
            if tick:
                smoothed += SMOOTHING * ((c - before) / seconds - smoothed)
                before = c
                missing = clamp(rig.kp * dead_zone(c - x, rig.half_width) + rig.feed_forward * smoothed, rig.rate) - v
                integral = clamp(integral + rig.ki * missing * seconds, rig.integral_limit)
                asked, ahead = ahead, clamp(rig.kv * missing + integral, rig.acceleration)
            current += h * (asked - current) / rig.lag
            acceleration = current
        elif rig.structure == SERVOVALVE:
            if tick:
                asked = clamp(rig.kp * (c - x), rig.rate)
            opening_rate += h * (rig.valve_w**2 * (asked - opening) - 2.0 * rig.valve_z * rig.valve_w * opening_rate)
            opening += h * opening_rate
            flow = dead_zone(opening, rig.half_width * rig.kp)
            if rig.supply > 0.0:
                flow *= np.sqrt(max(1.0 - (1.0 if flow > 0.0 else -1.0) * pressure / rig.supply, 0.0))
            pressure += h * (rig.w * (flow - v) - 2.0 * rig.z * rig.w * pressure)
            acceleration = clamp(rig.w * pressure, rig.acceleration)
        elif rig.structure == PNEUMATIC:
            if tick:
                integral = clamp(integral + rig.ki * (c - x) * seconds, rig.integral_limit)
                asked = clamp(dead_zone(rig.kp * (c - x) + integral, rig.half_width * rig.kp), rig.rate)
            pressure += h * (asked - pressure) / rig.lag
            acceleration = clamp((pressure - v) / rig.motor_lag, rig.acceleration)
        elif rig.structure == RC_SERVO:
            if tick:
                asked = clamp(rig.kp * dead_zone(c - x, rig.half_width) - rig.kd * v, rig.rate)
            acceleration = clamp((asked - v) / rig.motor_lag, rig.acceleration)
        elif rig.structure == VOICE_COIL:
            force = clamp(rig.coil * dead_zone(rig.gain * c - rig.feedback * x, rig.half_width) - rig.kd * v, rig.acceleration)
            acceleration = force - rig.w**2 * (x + rig.cubic * x**3) - 2.0 * rig.z * rig.w * v
        else:
            profile_2 += h * rig.filter_2 * (c - profile_2)
            profile += h * clamp(rig.filter_1 * dead_zone(profile_2 - profile, rig.half_width), rig.rate)
            field = np.floor(profile / rig.microstep + 0.5) * rig.microstep
            torque = clamp(rig.w**2 * np.sin(rig.poles * (field - x)) / rig.poles, rig.acceleration)
            acceleration = torque - 2.0 * rig.z * rig.w * v
        if rig.structure == VOICE_COIL:
            v = after_friction(v + h * acceleration, h * rig.coulomb)
            x, v = stopped(rig, x + h * v, v)
            mode_rate += h * (rig.mode_w**2 * (x - mode) - 2.0 * rig.mode_z * rig.mode_w * mode_rate)
            mode += h * mode_rate
            seen[n] = x + rig.mode_gain * (mode - x)
        else:
            x, v, load, load_speed = coupled(rig, h, x, v, load, load_speed, acceleration)
            seen[n] = load if rig.at_load > 0.5 else x
    return seen


@numba.njit(cache=True)
def coupled(rig, h, x, v, load, load_speed, acceleration):
    """Drive and load after a step."""
    both = rig.load_share * (1.0 - rig.load_share)
    twist, half = x - load, 0.5 * rig.gap
    torque = rig.coupling_w**2 * both * dead_zone(twist, half)
    if abs(twist) > half or half == 0.0:
        torque += 2.0 * rig.coupling_z * rig.coupling_w * both * (v - load_speed)
        if half > 0.0 and torque * twist < 0.0:
            torque = 0.0
    v += h * (acceleration - torque) / (1.0 - rig.load_share)
    load_speed += h * (torque / rig.load_share - rig.load_damping * load_speed)
    load_speed = after_friction(load_speed, h * rig.coulomb / rig.load_share)
    load, load_speed = stopped(rig, load + h * load_speed, load_speed)
    return x + h * v, v, load, load_speed


@numba.njit(cache=True)
def stopped(rig, position, speed):
    """At a stop, any speed into it is removed."""
    if position > rig.highest:
        return rig.highest, min(speed, 0.0)
    if position < rig.lowest:
        return rig.lowest, max(speed, 0.0)
    return position, speed
