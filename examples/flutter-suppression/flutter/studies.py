"""The computations for the tables and plots, one function each. Numbers only; `figures` plots them."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bact
from flutter import REPOSITORY, limit_cycles, linear, loop, margins, pair, recovery, system, wing

REFERENCE = bact.BY_NAME["te-early-loaded"]  # the trailing edge under air load, early: the surface that the control law would move
SLOWEST = bact.BY_NAME["us-early-loaded"]
PRESSURES_PSF = (160.0, 200.0, 225.0)  # at which margins are tabulated; all above the flutter point
LINE_PSF = np.linspace(100.0, 250.0, 31)
POINTS_PSF = (100.0, 125.0, 150.0, 175.0, 200.0, 225.0, 250.0)
GAP_DEG = 0.5  # free play; every amplitude is proportional to it
PLUNGE_FT = 0.05  # the disturbance after which limits are evaluated
RATES_DEG_S = (60.0, 80.0, 100.0, 125.0, 150.0, 200.0, 300.0, 450.0, 600.0)
SECONDS_SHOWN = 2.0
SHOWN_PSF = (130.0, 160.0, 225.0)  # of the time responses: below flutter, a little above, far above
PAIR_PSF, PAIR_DELAY_S, PAIR_SECONDS = 225.0, 0.004, 2.0
COUPLING_STEPS_S = (0.0005, 0.001, 0.002, 0.004)
BELOW_PSF, BELOW_RATE_DEG_S, BELOW_PLUNGE_FT, BELOW_SECONDS = 120.0, 100.0, 0.1, 15.0  # a rate limit below the flutter point
PLAY_PSF, PLAY_SECONDS, PLAY_PLUNGE_FT = 200.0, 4.0, 0.005
SISTER_MACH = 0.77  # of the measured point that the wing is compared with


def selected(s, **more):
    """The FMU's parameters for this actuator set."""
    return {"set_number": s.number, **more}


def oscillation(matrix):
    """Damping ratio of the least damped oscillation relevant to flutter, from a matrix."""
    return min(damping for frequency_hz, damping in wing.modes(matrix) if frequency_hz < margins.HIGHEST_HZ)


def open_loop_damping(pressures=LINE_PSF):
    return np.array([linear.critical_damping(q) for q in pressures])


def closed_loop_damping(s, pressures=LINE_PSF):
    return np.array([oscillation(linear.closed_loop(q, s)) for q in pressures])


def measured_damping(actuator, s, pressures=POINTS_PSF):
    """The same from time responses with the FMU."""
    return np.array([margins.damping(margins.least_damped(actuator, selected(s), q)) for q in pressures])


def delay_margins(s, pressures=LINE_PSF):
    """[s]"""
    return np.array([linear.delay_margin(float(q), s)[0] for q in pressures])


def measured_delay_margins(actuator, s, pressures=PRESSURES_PSF):
    """[s], from time responses with the FMU's delay."""
    return np.array([margins.delay_margin(actuator, s, q) for q in pressures])


def with_unit_gain(s):
    """The same actuator with k = 1: its lag alone."""
    return bact.ParameterSet(0, s.surface, s.stage, s.load_case, 1.0, s.p, s.omega, s.zeta)


def responses(actuator, sets, pressure_psf, **options):
    """{set name: response after the wing is released}."""
    return {s.name: loop.in_turn(actuator, selected(s), pressure_psf, SECONDS_SHOWN, **options) for s in sets}


def damping_against_delay(actuator, s, pressure_psf):
    """(delays [s] and damping of the dominant root, exact), (the same from time responses)."""
    most_s = 1.25 * linear.delay_margin(pressure_psf, s)[0]
    line_s, points_s = np.linspace(0.0, most_s, 60), np.linspace(0.0, most_s, 7)
    exact = [margins.damping(root) for root in linear.followed_root(pressure_psf, s, line_s)]
    frequency_hz = linear.delay_margin(pressure_psf, s)[1]
    measured = []
    for delay_s in points_s:
        run = loop.in_turn(actuator, selected(s, **{"delay.time": delay_s}), pressure_psf, margins.DURATION_S)
        measured.append(margins.damping(margins.highest(run, frequency_hz)))
    return (line_s, np.array(exact)), (points_s, np.array(measured))


def delay_left_against_rate(actuator, s, pressure_psf):
    return np.array([recovery.delay_left(actuator, s, pressure_psf, rate, PLUNGE_FT) for rate in RATES_DEG_S])


def largest_plunge_against_rate(actuator, s, pressure_psf):
    return np.array([recovery.largest_plunge(actuator, s, pressure_psf, rate) for rate in RATES_DEG_S])


def cycles_against_delay(actuator, s, pressure_psf):
    """(delays [s], pitch amplitudes [deg]) of the describing function, and of the FMU at some delays."""
    line = limit_cycles.predicted_with_delay(pressure_psf, s, GAP_DEG, 0.5 + np.geomspace(0.02, 60.0, 60))
    line += [(0.0, cycle) for cycle in limit_cycles.predicted(pressure_psf, s, GAP_DEG) if cycle.stable]
    margin_s = linear.delay_margin(pressure_psf, s)[0]
    points_s = margin_s * np.array([0.0, 0.25, 0.5, 0.7, 0.85, 0.93])
    found = [limit_cycles.measured(actuator, s, pressure_psf, GAP_DEG, delay_s, plunge_ft=0.02)[0] for delay_s in points_s]
    return (np.array([d for d, _ in line]), np.array([c.pitch_deg for _, c in line])), (points_s, np.array(found))


def cycles_against_pressure(actuator, s, pressures=POINTS_PSF):
    """Lists of (pressure, predicted cycle) and (pressure, pitch amplitude, frequency) of the FMU."""
    predicted = [(q, cycle) for q in LINE_PSF for cycle in limit_cycles.predicted(float(q), s, GAP_DEG)]
    measured = [(q, *limit_cycles.measured(actuator, s, q, GAP_DEG)[:2]) for q in pressures]
    return predicted, measured


def rate_limit_below_flutter(actuator):
    """Remaining pitch amplitudes [deg] after BELOW_SECONDS below the flutter point: {case: amplitude}.

    The motion of the wing alone decays, and so does that of the loop; with a rate limit it need not.
    """
    limited, free = ({**selected(REFERENCE), **recovery.limits(rate)} for rate in (BELOW_RATE_DEG_S, recovery.NO_LIMIT))

    def left(parameters, gain):
        run = loop.in_turn(actuator, parameters, BELOW_PSF, BELOW_SECONDS, BELOW_PLUNGE_FT, gain)
        return 0.5 * np.ptp(run.after(BELOW_SECONDS - 1.0).pitch)

    return {"wing alone": left(free, 0.0), "loop": left(free, 1.0), "loop with rate limit": left(limited, 1.0)}


def with_and_without_play(actuator):
    """Two runs from the same start."""
    return [
        loop.in_turn(actuator, selected(REFERENCE, **{"backlash.gap": gap}), PLAY_PSF, PLAY_SECONDS, PLAY_PLUNGE_FT)
        for gap in (GAP_DEG, 0.0)
    ]


@dataclass(frozen=True)
class TwoUnits:
    """The loop as two FMUs."""

    ssp: Path
    runs: dict  # {method of stepping: response}
    wing_difference: float  # largest difference of pitch between the wing's FMU and the wing in Python, of the peak
    hosts: dict  # {host: (time, difference of pitch from the scripted pair, of the peak)}
    coupling: dict  # {method of stepping: delay margins [s] at COUPLING_STEPS_S}


def two_units(actuator_path, wing_path, folder):
    """Stepped by a script in three ways and by the hosts, and the error of coupling as a function of the step."""
    actuator_values = selected(REFERENCE, **{"delay.time": PAIR_DELAY_S})
    plain = {"dynamic_pressure": PAIR_PSF, "initial_plunge": 0.01}
    predicted = {**plain, "prediction": loop.STEP_S}
    fmus = {"wing": wing_path, "actuator": actuator_path}
    ssp = system.write(folder / f"{system.NAME}.ssp", fmus, {"wing": predicted, "actuator": actuator_values})
    with pair.opened(actuator_path, wing_path) as units:
        runs = {
            "in turn": pair.in_turn(units, actuator_values, plain, PAIR_SECONDS),
            "side by side": pair.side_by_side(units, actuator_values, plain, PAIR_SECONDS),
            "side by side, predicted": pair.side_by_side(units, actuator_values, predicted, PAIR_SECONDS),
        }
        here = loop.in_turn(units[0], actuator_values, PAIR_PSF, PAIR_SECONDS)
        coupling = coupling_margins(units[0])
    scripted, hosts = runs["side by side, predicted"], {}
    for host in system.HOSTS:
        run = system.run_in(host, ssp, PAIR_SECONDS)
        if run is not None:
            hosts[host] = run.time, np.abs(run.pitch - scripted.pitch[1:]) / np.abs(scripted.pitch).max()
    difference = np.abs(runs["in turn"].pitch - here.pitch).max() / np.abs(here.pitch).max()
    return TwoUnits(ssp, runs, difference, hosts, coupling)


def coupling_margins(actuator):
    """{method of stepping: delay margins [s] at COUPLING_STEPS_S}, the wing in Python."""

    def found(run, options=lambda step_s: {}):
        return [
            margins.delay_margin(actuator, REFERENCE, PAIR_PSF, run, step_s=step_s, **options(step_s))
            for step_s in COUPLING_STEPS_S
        ]

    return {
        "in turn": found(loop.in_turn),
        "side by side": found(loop.side_by_side),
        "side by side, predicted": found(loop.side_by_side, lambda step_s: {"prediction_s": step_s}),
    }


def sister_wing():
    """Measured flutter points of the NACA 0012 wing on the same mount (Rivera et al., NASA TM-104211), or None.

    A structured array with `Mach`, `U_flutter_ft_s`, `freq_flutter_Hz`, `q_flutter_psf`, read from the folder ACTUATOR_DATA.
    """
    folder = Path(os.environ.get("ACTUATOR_DATA", REPOSITORY.parent / "shared" / "data"))
    file = folder / "papa_flutter" / "naca0012_papa_flutter.csv"
    return np.genfromtxt(file, delimiter=",", names=True) if file.is_file() else None


def model_at_its_speeds():
    """[(psf, Hz)]: flutter of the model at the speeds at which the sister wing fluttered."""
    points = sister_wing()
    return [] if points is None else [linear.flutter_point(float(speed)) for speed in points["U_flutter_ft_s"]]
