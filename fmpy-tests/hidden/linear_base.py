"""The base without effects, exact at the samples, by filters of scipy; and its refit to the motion of a hidden plant.

The gap of a case is the residual of the best base: (k, omega, zeta) refitted to the positions without noise. ENR, the
effect-to-noise ratio, is its rms over that of the noise.
"""

from types import SimpleNamespace

import numpy as np
from scipy import optimize, signal

import bact

from .excitation import SAMPLE_TIME_S

REACH = 0.7  # half or twice of each
ORDERS = {2: bact.SECOND, 3: bact.THIRD}


def respond(base, order, command, load=None, sample_time_s=SAMPLE_TIME_S, hold=True):
    """Position at the samples, at rest at 0 before; a load is always held. Each pole is one filter, q = s h:

        held    y+ = e^q y + r h phi1 c,                     phi1 = (e^q - 1)/q
        linear  y+ = e^q y + r h (phi1 c + phi2 (c+ - c)),   phi2 = (phi1 - 1)/q
    """
    k, p, omega, zeta = base
    position = _filtered(SimpleNamespace(k=k, p=p, omega=omega, zeta=zeta), ORDERS[order], command, sample_time_s, hold)
    if load is not None:
        position = position + _filtered(SimpleNamespace(k=1.0, p=p, omega=omega, zeta=zeta), bact.SECOND, load, sample_time_s, True)
    return position


def _filtered(constants, order, wave, sample_time_s, hold):
    poles, residues = bact.poles(constants, order), bact.residues(constants, order)
    total = np.zeros(len(wave))
    for pole, residue in zip(poles, residues):
        if pole.imag < 0.0:
            continue  # the conjugate of another pole
        q = pole * sample_time_s
        old, new = residue * sample_time_s * np.expm1(q) / q, 0.0
        if not hold:
            new = residue * sample_time_s * (np.expm1(q) / q - 1.0) / q
            old = old - new
        at_rest = [-new * wave[0]]
        mode, _ = signal.lfilter([new, old], [1.0, -np.exp(q)], wave.astype(complex), zi=np.array(at_rest, complex))
        total += mode.real * (2.0 if pole.imag > 0.0 else 1.0)
    return total


def refit(base, order, records, sample_time_s=SAMPLE_TIME_S, hold=True):
    """The base nearest to the records [(command, load, position)], p held, and its residual on each.

    k, omega and zeta stay within a factor e^REACH: with a drifting gain, omega would otherwise fit any decrease with frequency.
    """

    def moved(steps):
        k, omega, zeta = np.array([base[0], base[2], base[3]]) * np.exp(REACH * np.tanh(steps))
        return (float(k), base[1], float(omega), float(zeta))

    def gaps(steps):
        return [position - respond(moved(steps), order, command, load, sample_time_s, hold) for command, load, position in records]

    best = optimize.least_squares(lambda steps: np.concatenate(gaps(steps)), np.zeros(3), method="lm", ftol=1e-7, xtol=1e-6)
    return moved(best.x), gaps(best.x)


def without_base(base, order, records, differences, sample_time_s=SAMPLE_TIME_S, hold=True):
    """Small differences on the records, less the part that small changes of k, omega and zeta explain."""
    columns = []
    for i in (0, 2, 3):
        ways = []
        for factor in (0.999, 1.001):
            moved = list(base)
            moved[i] *= factor
            ways.append(np.concatenate([respond(moved, order, command, load, sample_time_s, hold) for command, load, _ in records]))
        columns.append(ways[1] - ways[0])
    together = np.concatenate(differences)
    matrix = np.array(columns).T
    return together - matrix @ np.linalg.lstsq(matrix, together, rcond=None)[0]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
