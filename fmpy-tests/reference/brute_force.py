"""The same equations stepped naively: many tiny steps, no events, no modes, many cases at once.

It checks the logic of plant.py (which motion follows which) with code without such logic: Moreau's time stepping, in which
friction, rate limit and stop are projections of the rate after each step, in the order of the semantics.

    v* = v + dt F(t + dt/2, d + dt/2 v, v),   |v| = max(0, |v*| - dt omega^2 level),   v in [-down, up],
    d = d + dt (v_old + v) / 2, and v = 0 where d would pass a stop

Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, CISM 302, Springer 1988.
First order in dt at events, second between them: at dt = 1e-5 s about 1e-4 of the peak. Held command, held load.
"""

import numpy as np

from .command_side import holding
from .plant import complete, quantise


def step_through(cases, time, dt):
    """cases: list of dicts with base, effects, command, load, failure (numbers), order, initial_position.

    dt must divide the sample steps. Returns a dict of arrays [case, sample]: drive, rate, deflection, position.
    """
    k, p, omega, zeta = np.array([case["base"] for case in cases], float).T
    effects = [complete(case["effects"]) for case in cases]

    def column(effect, parameter):
        return np.array([e[effect][parameter] for e in effects])

    def inputs(name):
        zeros = np.zeros(len(time))
        return np.array([zeros if case.get(name) is None else case[name] for case in cases], float)

    command, load, failure = inputs("command"), inputs("load"), inputs("failure").astype(int)
    third = np.array([case["order"] == 3 for case in cases])
    d0 = np.array([case["initial_position"] for case in cases], float)
    wait, ratio, drift = column("delay", "time"), column("asymmetric_gain", "ratio"), column("gain_drift", "rate")
    c_min, c_max = column("command_limit", "min"), column("command_limit", "max")
    r_up, r_down = (column("command_rate_limit", name) for name in ("up", "down"))
    # A neutral limit is the identity for any step.
    r_up, r_down = np.where(r_up >= 1e9, np.inf, r_up), np.where(r_down >= 1e9, np.inf, r_down)
    c_zone, c_gap = column("command_dead_zone", "half_width"), 0.5 * column("command_backlash", "gap")
    zone, cubic = column("dead_zone", "half_width"), column("amplitude_gain", "cubic")
    stiffness, bias = column("hinge_load", "stiffness"), column("hinge_load", "bias")
    level, limit = column("coulomb_friction", "level"), column("acceleration_limit", "value")
    up, down = column("rate_limit", "up"), column("rate_limit", "down")
    low, high = column("position_limit", "min"), column("position_limit", "max")
    gap = 0.5 * column("backlash", "gap")
    w_mode = 2.0 * np.pi * column("structural_mode", "frequency")
    z_mode, mode_gain = column("structural_mode", "damping"), column("structural_mode", "gain")
    lag, offset, slope = column("sensor_lag", "time"), column("sensor_bias", "offset"), column("sensor_bias", "drift")
    amplitude, f_chatter = column("chatter", "amplitude"), column("chatter", "frequency")
    phase, quantum = column("chatter", "phase"), column("quantisation", "step")

    def shrink(value, width):
        return np.sign(value) * np.maximum(np.abs(value) - width, 0.0)

    row = np.arange(len(cases))
    with np.errstate(divide="ignore"):
        forget_x, forget_s = np.exp(-p * dt), np.exp(-dt / lag)
    mean_x = (1.0 - forget_x) / (p * dt)
    rest = np.array([holding(case["initial_position"] / case["base"][0], complete(case["effects"])) for case in cases], float)
    clamped_rest = np.clip(rest, c_min, c_max)
    limited = clamped_rest.copy()
    played = shrink(limited, c_zone)
    x, v, d = d0.copy(), np.zeros(len(cases)), np.clip(d0, low, high)
    y, m, s, m_rate = d.copy(), d.copy(), d.copy(), np.zeros(len(cases))
    deflection = d.copy()
    names = ("drive", "rate", "deflection", "position")
    result = {name: np.zeros((len(cases), len(time))) for name in names}

    def record(i):
        now = time[i] - time[0]
        measured = s + offset + slope * now + amplitude * np.sin(2.0 * np.pi * f_chatter * now + phase)
        result["drive"][:, i], result["rate"][:, i], result["deflection"][:, i] = d, v, deflection
        result["position"][:, i] = [quantise(a, q) for a, q in zip(measured, quantum)]

    record(0)
    for i in range(1, len(time)):
        steps = round((time[i] - time[i - 1]) / dt)
        stuck, passive = failure[:, i - 1] == 2, failure[:, i - 1] == 1
        positive, negative = failure[:, i - 1] == 3, failure[:, i - 1] == 4
        for j in range(steps):
            now = time[i - 1] - time[0] + (j + 0.5) * dt
            index = np.searchsorted(time - time[0], now - wait, side="right") - 1
            c = np.where(index < 0, rest, command[row, np.maximum(index, 0)])
            c = np.clip(c, c_min, c_max)
            limited = np.clip(c, limited - r_down * dt, limited + r_up * dt)
            c = shrink(limited, c_zone)
            played = np.clip(played, c - c_gap, c + c_gap)
            u = k * (1.0 + drift * now) * np.where(played < 0.0, ratio * played, played)
            servo = np.where(third, u + (x - u) * mean_x, u)
            x = u + (x - u) * forget_x
            servo = np.where(positive, high, np.where(negative, low, servo))
            d_mid = d + 0.5 * dt * v
            drive = np.where(passive, 0.0, np.clip(omega**2 * shrink(servo - d_mid, zone), -limit, limit))
            external = load[:, i - 1] + bias - stiffness * d_mid - cubic * d_mid**3
            free = (v * (1.0 - dt * zeta * omega) + dt * (drive + omega**2 * external)) / (1.0 + dt * zeta * omega)
            v_new = np.clip(shrink(free, dt * level * omega**2), -down, up)
            d_new = d + 0.5 * dt * (v + v_new)
            hit = (d_new >= high) & (v_new > 0.0) | (d_new <= low) & (v_new < 0.0)
            v = np.where(stuck | hit, 0.0, v_new)
            d = np.where(stuck, d, np.clip(d_new, low, high))
            y_old, y = y, np.clip(y, d - gap, d + gap)
            y_mid = 0.5 * (y_old + y)
            m_half = m + 0.5 * dt * m_rate
            m_rate = (m_rate * (1.0 - dt * z_mode * w_mode) + dt * w_mode**2 * (y_mid - m_half)) / (
                1.0 + dt * z_mode * w_mode)
            m = m_half + 0.5 * dt * m_rate
            before, deflection = deflection, y + mode_gain * (m - y)
            mean = 0.5 * (before + deflection)
            s = np.where(lag > 0.0, mean + (s - mean) * forget_s, deflection)
        record(i)
    return result
