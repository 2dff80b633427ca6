"""Effect of limits: the largest disturbance from which the loop recovers, and the delay that it tolerates after one.

Above the flutter point a surface that moves too slowly, or not far enough, cannot hold a large motion: the loop is stable for
small disturbances only. The wing is released from a plunge and has to come to rest; rate limit and stops are those of the FMU.
"""

import numpy as np

from flutter import loop

STOPS_DEG, RATE_DEG_S = 15.0, 600.0  # limits assumed by the published control law; not measured
NO_LIMIT = 1e9  # neutral value of limits in the FMU
DURATION_S = 8.0  # forty periods: a growing motion has left the range or is visibly growing
LOST_DEG = 20.0  # of pitch: far outside the validity of the linear wing
RESOLUTION = 0.005  # of the result, relative


def limits(rate_deg_s=RATE_DEG_S, stops_deg=STOPS_DEG):
    """Parameters of the FMU."""
    return {
        "rate_limit.up": rate_deg_s, "rate_limit.down": rate_deg_s,
        "position_limit.min": -stops_deg, "position_limit.max": stops_deg,
    }  # fmt: skip


def recovers(actuator, parameters, pressure_psf, plunge_ft):
    """Whether a wing released from this plunge [ft] recovers: the motion still decays in the last of the seconds."""
    run = loop.in_turn(actuator, parameters, pressure_psf, DURATION_S, plunge_ft, bound_deg=LOST_DEG)
    if run.time[-1] < DURATION_S - 0.5 * loop.STEP_S:
        return False
    second = round(1.0 / loop.STEP_S)
    return np.ptp(run.pitch[-second:]) < np.ptp(run.pitch[-2 * second : -second])


def largest(holds, low, high):
    """The largest number in [low, high] for which `holds`, by bisection; `high` if it holds there, 0 if it does not at `low`."""
    if holds(high):
        return high
    if not holds(low):
        return 0.0
    while high - low > RESOLUTION * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def largest_plunge(actuator, s, pressure_psf, rate_deg_s, most_ft=0.6):
    """The largest plunge [ft] from which the loop recovers with this rate limit."""
    parameters = {"set_number": s.number, **limits(rate_deg_s)}
    return largest(lambda plunge_ft: recovers(actuator, parameters, pressure_psf, plunge_ft), 0.001, most_ft)


def delay_left(actuator, s, pressure_psf, rate_deg_s, plunge_ft, most_s=0.020):
    """The largest extra delay [s] with which it still recovers from this plunge."""
    parameters = {"set_number": s.number, **limits(rate_deg_s)}
    return largest(
        lambda delay_s: recovers(actuator, {**parameters, "delay.time": delay_s}, pressure_psf, plunge_ft), 0.0, most_s
    )
