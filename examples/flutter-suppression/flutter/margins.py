"""The delay margin from time responses: the FMU's `delay.time` is increased until the loop no longer decays.

Independent of `linear`: runs the loop, determines the roots from the free response (`modes`), and searches for the delay at which the
least damped oscillation neither grows nor decays.
"""

import numpy as np
from scipy.optimize import brentq

from flutter import loop, modes

DURATION_S = 2.5  # ten periods, and enough to distinguish the aperiodic mode
SHORTEST_S, LONGEST_S = 0.0, 0.030
LOWEST_HZ, HIGHEST_HZ = 2.0, 12.0  # where the decisive oscillations are searched
TOLERANCE_S = 1e-6


def least_damped(actuator, parameters, pressure_psf, run=loop.in_turn, **options):
    """The root [1/s] of the least damped oscillation in a free response of the loop."""
    response = run(actuator, parameters, pressure_psf, DURATION_S, **options)
    found = modes.roots(response.time, response.pitch)
    hertz = found.imag / (2.0 * np.pi)
    found = found[(hertz > LOWEST_HZ) & (hertz < HIGHEST_HZ)]
    return found[np.argmax(found.real / np.abs(found))]


def damping(root):
    """Damping ratio of a root."""
    return -root.real / abs(root)


def delay_margin(actuator, s, pressure_psf, run=loop.in_turn, **options):
    """Extra delay [s] at which the loop with the FMU becomes unstable."""

    def growth(delay_s):
        parameters = {"set_number": s.number, "delay.time": delay_s}
        return least_damped(actuator, parameters, pressure_psf, run, **options).real

    return brentq(growth, SHORTEST_S, LONGEST_S, xtol=TOLERANCE_S)


def highest(response, near_hz, within=0.4):
    """The least damped root of a free response with a frequency within this share of `near_hz`."""
    found = modes.roots(response.time, response.pitch)
    found = found[np.abs(found.imag / (2.0 * np.pi) / near_hz - 1.0) < within]
    return modes.nearest(found, 2j * np.pi * near_hz)
