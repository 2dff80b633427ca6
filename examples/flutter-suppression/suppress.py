"""Flutter suppression with the actuator FMU in the loop: tables and pictures.

    python suppress.py [--actuator F.fmu] [--wing F.fmu] [-o FOLDER]

`run` builds both FMUs first. Exit code 1 if a number that this example stands for is not met, 2 if an FMU is missing.
"""

import argparse
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices: threads would only wait for each other

import matplotlib  # noqa: E402

matplotlib.use("Agg")

import flutter  # noqa: E402
from flutter import figures, loop, studies, tables  # noqa: E402

import bact  # noqa: E402  after flutter, which sets its path
from actuator_fmu import DEFAULT_FMU, Actuator, unpacked  # noqa: E402

WING_FMU = flutter.REPOSITORY / "target" / "fmu" / "BactWing.fmu"
HOST_TOLERANCE = 1e-9  # of the largest pitch: both compute the same numbers
MARGIN_TOLERANCE = 0.005  # analysis against time responses, relative; found: 0.00005


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--actuator", type=Path, default=DEFAULT_FMU)
    parser.add_argument("--wing", type=Path, default=WING_FMU)
    parser.add_argument("-o", "--output", type=Path, default=flutter.OUTPUT)
    return parser.parse_args()


def actuators(actuator, folder):
    """All 17 sets: damping, margins, time responses."""
    damping = {s.name: (studies.closed_loop_damping(s), studies.measured_damping(actuator, s)) for s in bact.SETS}
    margins = {s.name: (studies.delay_margins(s), studies.measured_delay_margins(actuator, s)) for s in bact.SETS}
    worst = tables.actuators(damping, margins)
    alone = {q: loop.in_turn(actuator, {}, q, studies.SECONDS_SHOWN, gain=0.0) for q in studies.SHOWN_PSF}
    responses = {q: studies.responses(actuator, bact.SETS, q) for q in studies.SHOWN_PSF}
    return worst, [
        figures.margins_picture({"wing": studies.open_loop_damping(), **damping}, margins, folder / "margins.png"),
        figures.responses_picture(responses, alone, folder / "time-responses.png"),
    ]


def limits(actuator, folder):
    """Remaining margin of one actuator with delay, rate limit and backlash; limit cycles of two."""

    def by_pressure(study):
        return {q: study(actuator, studies.REFERENCE, q) for q in studies.PRESSURES_PSF}

    left, plunge = by_pressure(studies.delay_left_against_rate), by_pressure(studies.largest_plunge_against_rate)
    damping, delayed = by_pressure(studies.damping_against_delay), by_pressure(studies.cycles_against_delay)
    cycles = {s: studies.cycles_against_pressure(actuator, s) for s in (studies.REFERENCE, studies.SLOWEST)}
    tables.eaten(left, plunge)
    tables.below_flutter(studies.rate_limit_below_flutter(actuator))
    tables.limit_cycles(cycles)
    return [
        figures.eaten_picture(damping, left, plunge, delayed, folder / "what-eats-the-margin.png"),
        figures.cycles_picture(cycles, *studies.with_and_without_play(actuator), folder / "limit-cycles.png"),
    ]


def main():
    options, started = arguments(), time.perf_counter()
    for file, package in ((options.actuator, ""), (options.wing, " -- examples/flutter-suppression/wing")):
        if not file.is_file():
            print(f"No FMU at {file}. Build it with `cargo run -p fmu-build{package}`", file=sys.stderr)
            return 2
    folder = options.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    tables.wing_alone()
    with unpacked(options.actuator) as package, Actuator(package) as actuator:
        worst_margin, written = actuators(actuator, folder)
        written += limits(actuator, folder)
    units = studies.two_units(options.actuator, options.wing, folder)
    worst_host = tables.two_units(units)
    written.append(figures.pair_picture(units, folder / "two-fmus.png"))
    points, modelled = studies.sister_wing(), studies.model_at_its_speeds()
    tables.sister_wing(points, modelled)
    if points is not None:
        written.append(figures.measured_picture(points, modelled, folder / "sister-wing.png"))
    good = worst_margin <= MARGIN_TOLERANCE and worst_host <= HOST_TOLERANCE
    print("\nPictures: " + "\n          ".join(map(str, written)))
    verdict = "Good" if good else "NOT GOOD"
    print(f"{verdict}: margins within {100 * MARGIN_TOLERANCE:g} %, hosts within {HOST_TOLERANCE:g} of the peak")
    print(f"{time.perf_counter() - started:.0f} s")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
