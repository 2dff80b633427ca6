"""Flutter suppression with the actuator FMU in the loop: tables and pictures.

    python suppress.py [--actuator F.fmu] [--wing F.fmu] [-o FOLDER]

`run` builds both FMUs first. Exit code 1 if one of the numbers that this example stands for is not met.
"""

import argparse
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices: threads only wait for each other

import matplotlib

matplotlib.use("Agg")

import numpy as np  # noqa: E402

import flutter  # noqa: E402
from flutter import figures, limit_cycles, linear, loop, margins, pair, studies, system, wing  # noqa: E402

import bact  # noqa: E402  after flutter, which says where it is
from actuator_fmu import DEFAULT_FMU, Actuator, unpacked  # noqa: E402

WING_FMU = flutter.REPOSITORY / "target" / "fmu" / "BactWing.fmu"
SHOWN_PSF = (130.0, 160.0, 225.0)  # of the time responses: below flutter, a little above, far above
PAIR_PSF, PAIR_DELAY_S, PAIR_SECONDS = 225.0, 0.004, 2.0
COUPLING_STEPS_S = (0.0005, 0.001, 0.002, 0.004)
HOST_TOLERANCE = 1e-9  # of the largest pitch: both compute the same numbers
MARGIN_TOLERANCE = 0.005  # analysis against time responses, relative; found: 0.0003


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--actuator", type=Path, default=DEFAULT_FMU)
    parser.add_argument("--wing", type=Path, default=WING_FMU)
    parser.add_argument("-o", "--output", type=Path, default=flutter.OUTPUT)
    return parser.parse_args()


def print_wing():
    pressure_psf, frequency_hz = linear.flutter_point()
    first, second = wing.modes(wing.wing(0.0)[0])
    print(f"Wing alone: modes without wind {first[0]:.3f} and {second[0]:.3f} Hz; flutter at {pressure_psf:.1f} psf, {frequency_hz:.2f} Hz")
    print("  dynamic pressure, psf     " + "".join(f"{q:>9g}" for q in (100, 140, 150, 160, 175, 200, 225)))
    print("  damping of critical mode  " + "".join(f"{linear.critical_damping(float(q)):>9.4f}" for q in (100, 140, 150, 160, 175, 200, 225)))


def print_sets(damping, delays):
    print("\nLoop closed. Spoiler actuators stand in for the trailing edge's, with their own k: hypothetical.")
    print(f"{'':<20}{'k':>8}  damping ratio, % at psf      extra delay until unstable, ms: eigenvalues / FMU    k = 1")
    print(f"{'actuator':<20}{'':>8}" + "".join(f"{q:>9g}" for q in studies.PRESSURES_PSF) + "".join(f"{q:>16g}" for q in studies.PRESSURES_PSF) + f"{225:>9}")
    for s in bact.SETS:
        line = studies.closed_loop_damping(s, studies.PRESSURES_PSF)
        exact, found = studies.delay_margins(s, studies.PRESSURES_PSF), delays[s.name][1]
        alone = linear.delay_margin(225.0, studies.with_unit_gain(s))[0]
        print(f"{s.name:<20}{s.k:>8.4f}" + "".join(f"{100 * value:>9.2f}" for value in line)
              + "".join(f"{f'{1e3 * a:.2f} / {1e3 * b:.2f}':>16}" for a, b in zip(exact, found)) + f"{1e3 * alone:>9.2f}")  # fmt: skip
    worst = max(
        np.abs(delays[s.name][1] / studies.delay_margins(s, studies.PRESSURES_PSF) - 1.0).max() for s in bact.SETS
    )
    worst_damping = max(np.abs(damping[s.name][1] - studies.closed_loop_damping(s, studies.POINTS_PSF)).max() for s in bact.SETS)
    print(f"Eigenvalues against time responses with the FMU: margins differ by {100 * worst:.3f} % at most, damping ratios by {worst_damping:.1e}")
    return worst


def print_eaten(left, plunge, cycles):
    print(f"\n{studies.REFERENCE.name}, limits: stops 15 deg; let go from {studies.PLUNGE_FT:g} ft for the delay")
    print("  rate limit, deg/s              " + "".join(f"{rate:>8g}" for rate in studies.RATES_DEG_S))
    for q in studies.PRESSURES_PSF:
        print(f"  {q:g} psf: delay it recovers with, ms" + "".join(f"{1e3 * value:>8.2f}" for value in left[q])[1:])
        print(f"  {q:g} psf: plunge it recovers from, in" + "".join(f"{12 * value:>8.2f}" for value in plunge[q])[2:])
    print(f"\nLimit cycles with {studies.GAP_DEG:g} deg of backlash: pitch amplitude, deg, describing function / FMU; frequency, Hz")
    for s, (predicted, measured) in cycles.items():
        for q, amplitude, frequency_hz in measured:
            foreseen = [cycle for at, cycle in predicted if at == q and cycle.stable]
            words = ", ".join(f"{cycle.pitch_deg:.4f} ({cycle.frequency_hz:.3f} Hz)" for cycle in foreseen) or "none"
            print(f"  {s.name:<18}{q:>6g} psf  {words:>20} / {amplitude:.4f} ({frequency_hz:.3f} Hz)")


def pair_study(options):
    """The loop as two FMUs: scripted, in libcosim and in Ecos; what coupling costs."""
    s, step_s = studies.REFERENCE, loop.STEP_S
    actuator_values = studies.selected(s, **{"delay.time": PAIR_DELAY_S})
    wing_values = {"dynamic_pressure": PAIR_PSF, "initial_plunge": 0.01, "prediction": step_s}
    ssp = system.write(options.output / f"{system.NAME}.ssp", {"wing": options.wing, "actuator": options.actuator},
                       {"wing": wing_values, "actuator": actuator_values})  # fmt: skip
    runs, differences, coupling = {}, {}, {"wing here, in turn": [], "side by side": [], "side by side, predicted": []}
    with pair.opened(options.actuator, options.wing) as units:
        scripted = pair.side_by_side(units, actuator_values, wing_values, PAIR_SECONDS)
        turned = pair.in_turn(units, actuator_values, {**wing_values, "prediction": 0.0}, PAIR_SECONDS)
        plain = pair.side_by_side(units, actuator_values, {**wing_values, "prediction": 0.0}, PAIR_SECONDS)
        here = loop.in_turn(units[0], actuator_values, PAIR_PSF, PAIR_SECONDS)
        runs |= {"in turn": turned, "side by side": plain, "side by side, predicted": scripted}
        same = np.abs(turned.pitch - here.pitch).max() / np.abs(here.pitch).max()
        for step in COUPLING_STEPS_S:
            for label, run, more in (
                ("wing here, in turn", loop.in_turn, {}),
                ("side by side", loop.side_by_side, {}),
                ("side by side, predicted", loop.side_by_side, {"prediction_s": step}),
            ):
                coupling[label].append(margins.delay_margin(units[0], s, PAIR_PSF, run, step_s=step, **more))
    print(f"\nTwo FMUs, {PAIR_PSF:g} psf, {1e3 * PAIR_DELAY_S:g} ms extra delay, communication step {1e3 * step_s:g} ms: {ssp}")
    print(f"  wing FMU against the wing here, in turn: {same:.1e} of the peak")
    worst = 0.0
    for host in system.HOSTS:
        run = system.run_in(host, ssp, PAIR_SECONDS, options.output)
        if run is None:
            print(f"  {host}: does not load here (Debian: apt install libtbb12); skipped")
            continue
        difference = np.abs(run.pitch - scripted.pitch[1:]) / np.abs(scripted.pitch).max()
        differences[host], worst = (run.time, difference), max(worst, difference.max())
        print(f"  {host} against the scripted pair, side by side: {difference.max():.1e} of the peak")
    print("  margin, ms, at a step of  " + "".join(f"{1e3 * step:>9g} ms" for step in COUPLING_STEPS_S))
    for label, found in coupling.items():
        print(f"    {label:<24}" + "".join(f"{1e3 * value:>12.3f}" for value in found))
    return runs, differences, {label: (COUPLING_STEPS_S, found) for label, found in coupling.items()}, worst


def print_sister(points):
    if points is None:
        print("\nNo measured flutter points here (set ACTUATOR_DATA): comparison with the sister wing skipped")
        return None
    modelled = [linear.flutter_point(float(speed)) for speed in points["U_flutter_ft_s"]]
    print("\nMeasured on the sister wing without controls (NASA TM-104211), and the quasi-steady model at the same speeds")
    for point, (pressure_psf, frequency_hz) in zip(points, modelled):
        print(f"  M {point['Mach']:.2f}: {point['q_flutter_psf']:.1f} psf, {point['freq_flutter_Hz']:.2f} Hz;"
              f" model {pressure_psf:.1f} psf, {frequency_hz:.2f} Hz")  # fmt: skip
    return modelled


def main():
    options, started = arguments(), time.perf_counter()
    for file, package in ((options.actuator, ""), (options.wing, " examples/flutter-suppression/wing")):
        if not file.is_file():
            print(f"No FMU at {file}. Build it with `cargo run -p fmu-build --{package}`", file=sys.stderr)
            return 2
    options.output.mkdir(parents=True, exist_ok=True)
    print_wing()
    with unpacked(options.actuator) as package, Actuator(package) as actuator:
        damping = {s.name: (studies.closed_loop_damping(s), studies.measured_damping(actuator, s)) for s in bact.SETS}
        delays = {s.name: (studies.delay_margins(s), studies.measured_delay_margins(actuator, s)) for s in bact.SETS}
        worst_margin = print_sets(damping, delays)
        by_pressure = lambda study: {q: study(actuator, studies.REFERENCE, q) for q in studies.PRESSURES_PSF}  # noqa: E731
        left, plunge = by_pressure(studies.delay_left_against_rate), by_pressure(studies.largest_plunge_against_rate)
        against_delay, cycles_delay = by_pressure(studies.damping_against_delay), by_pressure(studies.cycles_against_delay)
        cycles = {s: studies.cycles_against_pressure(actuator, s) for s in (studies.REFERENCE, studies.SLOWEST)}
        print_eaten(left, plunge, cycles)
        responses = {q: studies.responses(actuator, bact.SETS, q) for q in SHOWN_PSF}
        alone = {q: loop.in_turn(actuator, {}, q, studies.SECONDS_SHOWN, gain=0.0) for q in SHOWN_PSF}
        play, no_play = (
            loop.in_turn(actuator, studies.selected(studies.REFERENCE, **{"backlash.gap": gap}), 200.0, 4.0, plunge_ft=0.005)
            for gap in (studies.GAP_DEG, 0.0)
        )
    runs, differences, coupling, worst_host = pair_study(options)
    points = studies.sister_wing()
    modelled = print_sister(points)

    written = [
        figures.margins_picture({"wing": studies.open_loop_damping(), **damping}, delays, options.output / "margins.png"),
        figures.responses_picture(responses, alone, options.output / "time-responses.png"),
        figures.eaten_picture(against_delay, left, plunge, cycles_delay, options.output / "what-eats-the-margin.png"),
        figures.cycles_picture(cycles, play, no_play, options.output / "limit-cycles.png"),
        figures.pair_picture(runs, differences, coupling, options.output / "two-fmus.png"),
    ]
    if modelled is not None:
        written.append(figures.measured_picture(points, modelled, options.output / "sister-wing.png"))
    good = worst_margin <= MARGIN_TOLERANCE and worst_host <= HOST_TOLERANCE
    print("\nPictures: " + "\n          ".join(map(str, written)))
    print(f"{'Good' if good else 'NOT GOOD'}: margins within {100 * MARGIN_TOLERANCE:g} %, hosts within {HOST_TOLERANCE:g} of the peak")
    print(f"{time.perf_counter() - started:.0f} s")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
