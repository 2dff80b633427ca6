"""From the drive to the sensor: plays, structural mode, lag, along the steps of the drive.

    play  each y_j follows d with its gap (half each side);  y = sum weight_j y_j
          one play with weight 1 is backlash; several of growing gap are a distributed hysteresis (Prandtl-Ishlinskii)
    mode  m'' = w^2 (y - m) - 2 zeta w m',   y becomes y + gain (m - y)     Runge-Kutta, y linear within a step
    lag   s' = (y - s) / lag                                                exact for y linear within a step
"""

from collections import namedtuple

import numba
import numpy as np

Output = namedtuple("Output", "mode damping gain lag")


def constants(effects):
    mode = effects["structural_mode"]
    return Output(2.0 * np.pi * mode["frequency"], float(mode["damping"]), float(mode["gain"]), float(effects["sensor_lag"]["time"]))


def plays(effects):
    """Weights and gaps."""
    spread = effects["distributed_play"]
    count = int(spread["count"])
    weights = np.array([1.0 - (spread["share"] if count else 0.0)] + count * [spread["share"] / max(count, 1)])
    return weights, np.array([effects["backlash"]["gap"], *np.linspace(spread["first"], spread["last"], count)])


@numba.njit(cache=True)
def mode_step(h, m, rate, y0, y1, output):
    """m and m' after h, for y from y0 to y1."""

    stiffness, damping = output.mode**2, 2.0 * output.damping * output.mode
    middle = 0.5 * (y0 + y1)
    a1 = stiffness * (y0 - m) - damping * rate
    r2 = rate + 0.5 * h * a1
    a2 = stiffness * (middle - m - 0.5 * h * rate) - damping * r2
    r3 = rate + 0.5 * h * a2
    a3 = stiffness * (middle - m - 0.5 * h * r2) - damping * r3
    r4 = rate + h * a3
    a4 = stiffness * (y1 - m - h * r3) - damping * r4
    return m + h / 6.0 * (rate + 2.0 * (r2 + r3) + r4), rate + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)


@numba.njit(cache=True)
def follow(instants, drive, weights, gaps, output):
    """The measured position, before bias, chatter, noise and rounding, at all instants."""
    held = np.full(len(gaps), drive[0])
    m, m_rate, before = drive[0], 0.0, drive[0]
    lagged = deflection = drive[0]
    measured = np.zeros(len(drive))
    measured[0] = drive[0]
    for i in range(1, len(drive)):
        h = instants[i] - instants[i - 1]
        y = 0.0
        for j in range(len(gaps)):
            held[j] = min(max(held[j], drive[i] - 0.5 * gaps[j]), drive[i] + 0.5 * gaps[j])
            y += weights[j] * held[j]
        if output.gain != 0.0:
            m, m_rate = mode_step(h, m, m_rate, before, y, output)
        deflection_before, deflection = deflection, y + output.gain * (m - y)
        before = y
        if output.lag > 0.0 and h > 0.0:
            behind = output.lag * (deflection - deflection_before) / h
            lagged = deflection - behind + (lagged - deflection_before + behind) * np.exp(-h / output.lag)
        measured[i] = lagged if output.lag > 0.0 else deflection
    return measured
