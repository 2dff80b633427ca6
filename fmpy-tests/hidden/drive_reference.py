"""The drives of `drive_dynamics.py` reimplemented as plain differential equations and controllers for an adaptive solver: nothing is linearised,
split off or propagated."""

import numpy as np

from .drive_dynamics import CABLE, EHA, HARMONIC, LINEAR, PIEZO, PWM, SPOOL, WORM

STATES = {EHA: 4, SPOOL: 5, PIEZO: 4, LINEAR: 3, HARMONIC: 6, CABLE: 5, PWM: 4, WORM: 4}


def rates(_, z, plant, u):
    """Derivatives of the states under a held demand u."""
    kind = plant.structure
    if kind == EHA:
        x, v, pressure, pump = z
        return [v, plant.oil * pressure - plant.viscous * v, plant.oil * (pump - v) - plant.leak * pressure, (u - pump) / plant.lag]
    if kind == SPOOL:
        x, v, pressure, spool, spool_rate = z
        flow = spool * np.sqrt(1.0 - np.sign(spool) * pressure / plant.supply)
        spring = plant.valve**2 * (u - spool) - 2.0 * plant.valve_zeta * plant.valve * spool_rate
        return [v, plant.oil * pressure - plant.viscous * v, plant.oil * (flow - v) - plant.leak * pressure, spool_rate, spring]
    if kind == PIEZO:
        x, v, volts, hysteresis = z
        stretch, slew = volts - plant.share * hysteresis, (u - volts) / plant.lag
        force = plant.resonance**2 * (stretch - x) - 2.0 * plant.zeta * plant.resonance * v
        return [v, force, slew, slew - abs(slew) * hysteresis / plant.reach]
    if kind == LINEAR:
        x, v, current = z
        return [v, current - plant.viscous * v - plant.cogging * np.sin(2.0 * np.pi * x / plant.pitch), (u - current) / plant.lag]
    x, v, y, yv, *own = z
    twisting = v - yv
    torque = plant.shaft**2 * (x - y) + 2.0 * plant.zeta * plant.shaft * twisting
    if kind in (PWM, WORM):
        return [v, (u - v) / plant.lag - plant.ratio * torque, yv, torque - plant.drag * yv]
    more = [(u - own[0]) / plant.lag]
    if kind == HARMONIC:
        torque += plant.shaft**2 * (plant.kinematic * np.sin(plant.kinematic_per_deg * x) + plant.share * own[1])
        more.append(twisting - abs(twisting) * own[1] / plant.reach)
    return [v, own[0] - plant.viscous * v - plant.ratio * torque, yv, torque - plant.drag * yv, *more]


def controller(plant, reference, seconds):
    """The demand at the beginning of each control period, from reference, position and speed; `reference` before the first."""
    total, before, last = 0.0, reference, 0.0

    def demand(c, x, v):
        nonlocal total, before, last
        error, speed = c - x, (x - last) / seconds if plant.structure in (CABLE, WORM) else v
        ahead, before, last = plant.feed_forward * (c - before) / seconds, c, x
        if plant.structure in (EHA, SPOOL):
            total = np.clip(total + plant.ki * error * seconds, -plant.integral_limit, plant.integral_limit)
            return plant.kp * error + total
        if plant.structure == PIEZO:
            total = np.clip(total + plant.ki * error * seconds, plant.lowest, plant.highest)
            return total
        if plant.structure in (PWM, WORM):
            return plant.kp * error - plant.kd * speed
        missing = plant.kp * error + ahead - speed
        total = np.clip(total + plant.ki * missing * seconds, -plant.integral_limit, plant.integral_limit)
        return plant.kv * missing + total

    return demand
