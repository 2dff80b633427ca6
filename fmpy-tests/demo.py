"""The packaged FMU next to the report: `python demo.py [--fmu F.fmu] [-o FOLDER]`.

Steps all 17 parameter sets of NASA/TM-1998-208452 through the FMU at 200 Hz, prints how far the measured frequency response
is from the analytic one, and draws both. Exit code 1 if any error is above 1e-6 deg/deg or 1e-4 deg, 2 if there is no FMU.
"""

import argparse
import sys
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import numpy as np  # noqa: E402

import bact  # noqa: E402
import pictures  # noqa: E402
from actuator_fmu import DEFAULT_FMU, REPOSITORY, Actuator, selection, unpacked  # noqa: E402
from frequency_sweep import FREQUENCIES_HZ, magnitude_and_phase_error, measure  # noqa: E402

SEED = 208452  # phases of the multisine; arbitrary
HEAD = f"{'set':<20}{'k':>8}{'p, 1/s':>12}{'omega, rad/s':>14}{'zeta':>8}{'magnitude error':>17}{'phase error, deg':>18}"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, default=DEFAULT_FMU)
    parser.add_argument("-o", "--output", type=Path, default=REPOSITORY / "target" / "demo")
    return parser.parse_args()


def step_responses(actuator, times):
    """Unit step of every set, positions at `times` (which start at 0)."""
    measured = {}
    for s in bact.SETS:
        actuator.restart(selection(s, bact.THIRD))
        measured[s.name] = np.append(actuator["position"], actuator.run(np.ones(len(times) - 1), bact.CONTROL_PERIOD_S))
    return measured


def compare(actuator, rng):
    """Frequency responses by name, and the largest errors; also prints the table."""
    measured, worst = {}, [0.0, 0.0]
    print(HEAD)
    for s in bact.SETS:
        measured[s.name] = measure(actuator, s, bact.THIRD, rng)
        errors = magnitude_and_phase_error(measured[s.name], bact.frequency_response(s, bact.THIRD, FREQUENCIES_HZ))
        magnitude, phase_deg = (error.max() for error in errors)
        p = f"{s.p:.0f}" if s.p < 1e6 else f"{s.p:.3g}"
        print(f"{s.name:<20}{s.k:>8.4f}{p:>12}{s.omega:>14.2f}{s.zeta:>8.4f}{magnitude:>17.1e}{phase_deg:>18.1e}")
        worst = [max(worst[0], magnitude), max(worst[1], phase_deg)]
    return measured, worst


def main():
    options, started = arguments(), time.perf_counter()
    if not options.fmu.is_file():
        print(
            f"No FMU at {options.fmu}. Build it with `cargo run -p fmu-build`, or name one: --fmu F.fmu",
            file=sys.stderr,
        )
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    print(
        f"Stepping {options.fmu} in fmpy: {len(bact.SETS)} sets, {len(FREQUENCIES_HZ)} frequencies from 0.5 to 12 Hz, h = 5 ms\n"
    )
    times = np.arange(0, pictures.STEP_TIME_S, bact.CONTROL_PERIOD_S)
    with unpacked(options.fmu) as package, Actuator(package) as actuator:
        measured, (magnitude, phase_deg) = compare(actuator, np.random.default_rng(SEED))
        steps = step_responses(actuator, times)
    written = [
        pictures.frequency_response_picture(
            surface, measured, options.output / f"frequency-response-{bact.INITIALS[surface]}.png"
        )
        for surface in pictures.TITLES
    ]
    written.append(pictures.step_response_picture(times, steps, options.output / "step-response.png"))
    good = magnitude <= bact.MAGNITUDE_TOLERANCE and phase_deg <= bact.PHASE_TOLERANCE_DEG
    print(f"\nLargest error {magnitude:.1e} deg/deg and {phase_deg:.1e} deg: {'good' if good else 'NOT GOOD'}")
    print(f"Allowed       {bact.MAGNITUDE_TOLERANCE:.1e} deg/deg and {bact.PHASE_TOLERANCE_DEG:.1e} deg")
    print("Pictures: " + "\n          ".join(map(str, written)))
    print(f"{time.perf_counter() - started:.1f} s")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
