"""The drive in short steps: position d and rate v under all effects inside the loop.

    servo     x = u - u'/p + C exp(-p s),  u = k (1 + drift t) c,  s = time since the last corner of the command, C from continuity
    loop      e = dead zone(x - d);   F = clamp(w^2 e) - 2 zeta w v - w^2 cubic d^3 + w^2 (load + bias - stiffness d - h)
              d' = v,   v' = F - w^2 level sign(v);   v in [-down, up];   d in [min, max]
    Bouc-Wen  h = hysteresis z,   z' = v / reach (1 - |z| (1 + sign(v z)) / 2)
    drifting  w = omega (1 + omega_drift t + swing sin(2 pi t / period))

In each step the drive is FREE, LIMITED (its rate), or HELD (at rest, by friction or a stop), and the error is in one region of the
drive's polygon. A step in which either changes is cut there by bisection.
"""

from collections import namedtuple

import numba
import numpy as np

STEP_S = 1e-4  # longest step
FAST_POLE = 1e6  # 1/s; above it the pole settles before anything moves: only the delay u'/p remains in x
BISECTIONS = 30  # cut a step of 0.1 ms to 1e-13 s
FORGOTTEN = 40.0  # exp(-40) = 4e-18
FREE, LIMITED, HELD = 0, 1, 2

Loop = namedtuple("Loop", "k p omega zeta gain_drift half_width cubic stiffness bias level acceleration up down lowest highest "
                          "hysteresis reach omega_drift swing period")  # fmt: skip
# The target within a piece of the command: u = u0 + u1 s + u2 s^2, and C.
Target = namedtuple("Target", "u0 u1 u2 p transient")
# Quantities of a step other than the target: w, load + bias, friction with its sign, and whether a rate limit holds v.
Acting = namedtuple("Acting", "w load friction limited")


def constants(base, effects, order):
    k, p, omega, zeta = base
    limit, stops, drifting = effects["rate_limit"], effects["position_limit"], effects["drifting_omega"]
    values = (k, p if order == 3 else 1e30, omega, zeta, effects["gain_drift"]["rate"], effects["dead_zone"]["half_width"],
              effects["amplitude_gain"]["cubic"], effects["hinge_load"]["stiffness"], effects["hinge_load"]["bias"],
              effects["coulomb_friction"]["level"], effects["acceleration_limit"]["value"], limit["up"], limit["down"],
              stops["min"], stops["max"], effects["bouc_wen"]["hysteresis"], effects["bouc_wen"]["reach"],
              drifting["drift"], drifting["swing"], drifting["period"])  # fmt: skip
    return Loop(*map(float, values))


@numba.njit(cache=True)
def servo_target(target, s):
    x = target.u0 + s * (target.u1 + s * target.u2) - (target.u1 + 2.0 * s * target.u2) / target.p
    decayed = target.p * s
    return x + target.transient * np.exp(-decayed) if target.transient != 0.0 and decayed < FORGOTTEN else x


@numba.njit(cache=True)
def force(s, d, v, z, target, acting, loop):
    """F, the acceleration without friction."""
    e = servo_target(target, s) - d
    e = max(e - loop.half_width, 0.0) + min(e + loop.half_width, 0.0)
    w2 = acting.w**2
    drive = min(max(w2 * e, -loop.acceleration), loop.acceleration)
    restoring = loop.cubic * d**3 + loop.stiffness * d + loop.hysteresis * z - acting.load
    return drive - 2.0 * loop.zeta * acting.w * v - w2 * restoring


@numba.njit(cache=True)
def rates(s, d, v, z, target, acting, loop):
    """d', v', z'"""
    z_rate = v / loop.reach * (1.0 - 0.5 * abs(z) * (1.0 + np.sign(v * z)))
    if acting.limited:
        return v, 0.0, z_rate
    return v, force(s, d, v, z, target, acting, loop) - acting.friction, z_rate


@numba.njit(cache=True)
def runge_kutta(h, s, d, v, z, target, acting, loop):
    d1, v1, z1 = rates(s, d, v, z, target, acting, loop)
    d2, v2, z2 = rates(s + 0.5 * h, d + 0.5 * h * d1, v + 0.5 * h * v1, z + 0.5 * h * z1, target, acting, loop)
    d3, v3, z3 = rates(s + 0.5 * h, d + 0.5 * h * d2, v + 0.5 * h * v2, z + 0.5 * h * z2, target, acting, loop)
    d4, v4, z4 = rates(s + h, d + h * d3, v + h * v3, z + h * z3, target, acting, loop)
    sixth = h / 6.0
    return (d + sixth * (d1 + 2.0 * (d2 + d3) + d4), v + sixth * (v1 + 2.0 * (v2 + v3) + v4),
            z + sixth * (z1 + 2.0 * (z2 + z3) + z4))  # fmt: skip


@numba.njit(cache=True)
def region(s, d, target, loop):
    """Region of the error on the drive's polygon: lower limit, slope, dead zone, slope, upper limit."""
    e = servo_target(target, s) - d
    reach = loop.half_width + loop.acceleration / loop.omega**2
    return int(e > loop.half_width) - int(e < -loop.half_width) + int(e > reach) - int(e < -reach)


@numba.njit(cache=True)
def move(motion, h, s, d, v, z, target, acting, loop):
    if motion == HELD:
        return d, 0.0, z
    return runge_kutta(h, s, d, v, z, target, acting, loop)


@numba.njit(cache=True)
def has_ended(motion, sign, here, s, d, v, z, target, acting, friction, loop):
    """Whether the motion, sign of the rate or region of the beginning of a step no longer apply at its end s, d, v, z."""
    if region(s, d, target, loop) != here:
        return True
    if motion == FREE:
        return d > loop.highest or d < loop.lowest or v > loop.up or v < -loop.down or sign != 0.0 and v * sign < 0.0
    now = force(s, d, v, z, target, acting, loop)
    if motion == LIMITED:
        return d > loop.highest or d < loop.lowest or (now < friction if v > 0.0 else now > -friction)
    if d >= loop.highest:
        return now < -friction
    if d <= loop.lowest:
        return now > friction
    return abs(now) > friction


@numba.njit(cache=True)
def one_step(h, s, t, d, v, z, load, target, loop):
    """Moves over at most h; returns the elapsed time, d, v, z."""
    w = loop.omega * (1.0 + loop.omega_drift * t + loop.swing * np.sin(2.0 * np.pi * t / loop.period))
    friction = w * w * loop.level
    acting = Acting(w, load + loop.bias, 0.0, False)
    now = force(s, d, v, z, target, acting, loop)
    motion, sign = FREE, 0.0
    if d >= loop.highest and v >= 0.0 and now >= -friction or d <= loop.lowest and v <= 0.0 and now <= friction:
        motion = HELD
    elif friction > 0.0 and v == 0.0 and abs(now) <= friction:
        motion = HELD
    else:
        if friction > 0.0:
            sign = np.sign(v) if v != 0.0 else np.sign(now)
        if v >= loop.up and now >= friction or v <= -loop.down and now <= -friction:
            motion = LIMITED
    acting = Acting(w, load + loop.bias, friction * sign, motion == LIMITED)
    here = region(s, d, target, loop)
    d_new, v_new, z_new = move(motion, h, s, d, v, z, target, acting, loop)
    if has_ended(motion, sign, here, s + h, d_new, v_new, z_new, target, acting, friction, loop):
        early, late = 0.0, h
        for _ in range(BISECTIONS):
            h = 0.5 * (early + late)
            d_new, v_new, z_new = move(motion, h, s, d, v, z, target, acting, loop)
            if has_ended(motion, sign, here, s + h, d_new, v_new, z_new, target, acting, friction, loop):
                late = h
            else:
                early = h
        h = late
        d_new, v_new, z_new = move(motion, h, s, d, v, z, target, acting, loop)
        if motion != HELD:
            if d_new > loop.highest or d_new < loop.lowest or sign != 0.0 and v_new * sign < 0.0:
                d_new, v_new = min(max(d_new, loop.lowest), loop.highest), 0.0
            v_new = min(max(v_new, -loop.down), loop.up)
    return h, d_new, v_new, z_new


@numba.njit(cache=True)
def march(corners, commands, slopes, loads, loop):
    """Instants and drive positions of all steps, and the index of each corner among them.

    Between corners the command is commands[i] + slopes[i] s and the load is loads[i].
    """
    capacity = 4 * int((corners[-1] - corners[0]) / STEP_S) + 40 * len(corners)
    instants, drive, at_corner = np.zeros(capacity), np.zeros(capacity), np.zeros(len(corners), np.int64)
    d = v = z = x = 0.0
    d = min(max(d, loop.lowest), loop.highest)
    drive[0] = d
    count = 0
    for i in range(len(corners) - 1):
        duration, t0, c, slope = corners[i + 1] - corners[i], corners[i], commands[i], slopes[i]
        gain = loop.k * (1.0 + loop.gain_drift * t0)
        change = loop.k * loop.gain_drift
        target = Target(gain * c, gain * slope + change * c, change * slope, loop.p, 0.0)
        transient = 0.0 if loop.p > FAST_POLE else x - servo_target(target, 0.0)
        target = Target(target.u0, target.u1, target.u2, loop.p, transient)
        s = 0.0
        while s < duration * (1.0 - 1e-12):
            left = duration - s
            h, d, v, z = one_step(left / np.ceil(left / STEP_S - 1e-9), s, t0 + s, d, v, z, loads[i], target, loop)
            s += h
            count += 1
            if count >= capacity:
                raise RuntimeError("the drive changes its motion without end")
            instants[count], drive[count] = t0 + s, d
        x = servo_target(target, duration)
        at_corner[i + 1] = count
    return instants[: count + 1], drive[: count + 1], at_corner
