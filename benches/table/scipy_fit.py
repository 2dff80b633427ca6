"""A second-order servo fitted to records as one would do with scipy: output error, white noise, simulated by `lfilter`."""

import numpy as np
import pandas as pd
from scipy import optimize, signal

# As in benches/library.rs.
STARTS = [(1.0, omega, zeta) for omega in (90.0, 130.0, 180.0, 250.0) for zeta in (0.4, 0.9)]


def read(path):
    """Interval, command, position."""
    frame = pd.read_csv(path)
    time = frame["time"].to_numpy()
    return (time[-1] - time[0]) / (len(time) - 1), frame["command"].to_numpy(), frame["position"].to_numpy()


def sampled(k, omega, zeta, interval):
    """Numerator and denominator between samples, with the command held."""
    damped = omega * np.sqrt(complex(1.0 - zeta * zeta))
    pole = np.exp((-zeta * omega + 1j * damped) * interval), np.exp((-zeta * omega - 1j * damped) * interval)
    denominator = np.real([1.0, -(pole[0] + pole[1]), pole[0] * pole[1]])
    size = np.exp(-zeta * omega * interval)
    c = np.real(size * np.cos(damped * interval))
    s = np.real(size * np.sin(damped * interval) / damped)
    first = 1.0 - c - zeta * omega * s
    return k * np.array([0.0, first, denominator.sum() - first]), denominator


def residual(record, parameters):
    interval, command, position = record
    return position - signal.lfilter(*sampled(*parameters, interval), command)


def least_squares(record, starts):
    """The best of all starts: k, omega, zeta."""
    ends = [optimize.least_squares(lambda x: residual(record, x * start), np.ones(3), bounds=(0.05, 20.0)) for start in map(np.array, starts)]
    best = min(range(len(ends)), key=lambda place: ends[place].cost)
    return ends[best].x * np.array(starts[best])


def bfgs(record, starts):
    """As above by quasi-Newton steps on the mean square, with finite-difference gradients."""
    rms = np.mean(record[2] ** 2)

    def search(start):
        def cost(logarithm):  # of the parameters relative to the start, which keeps them positive
            return np.mean(residual(record, np.exp(np.clip(logarithm, -3.0, 3.0)) * start) ** 2) / rms

        return optimize.minimize(cost, np.zeros(3), method="BFGS")

    ends = [search(np.array(start)) for start in starts]
    best = min(range(len(ends)), key=lambda place: ends[place].fun)
    return np.exp(ends[best].x) * np.array(starts[best])
