"""Prints the results of `studies` as tables."""

import numpy as np

import bact
from flutter import linear, loop, recovery, studies, system, wing

INCHES, PERCENT, MILLI = 12.0, 100.0, 1e3
TABLED_PSF = (100.0, 140.0, 150.0, 160.0, 175.0, 200.0, 225.0)


def wing_alone():
    pressure_psf, frequency_hz = linear.flutter_point()
    (first_hz, _), (second_hz, _) = wing.modes(wing.wing(0.0)[0])
    modes = f"modes without wind {first_hz:.3f} and {second_hz:.3f} Hz"
    print(f"Wing alone: {modes}; flutter at {pressure_psf:.1f} psf, {frequency_hz:.2f} Hz")
    print("  dynamic pressure, psf     " + row(TABLED_PSF, "9g"))
    print("  damping of critical mode  " + row([linear.critical_damping(q) for q in TABLED_PSF], "9.4f"))


def row(values, form):
    return "".join(f"{value:>{form}}" for value in values)


def actuators(damping, margins):
    """Both map a set's name to (line, points from time responses). Returns the worst relative difference of a margin."""
    at = studies.PRESSURES_PSF
    print("\nLoop closed. Spoiler actuators stand in for the trailing edge's, with their own k: hypothetical.")
    print(f"{'':<28}  damping ratio, % at psf      extra delay until unstable, ms, at psf: eigenvalues / FMU     k = 1")
    print(f"{'actuator':<20}{'k':>8}" + row(at, "9g") + row(at, "16g") + f"{at[-1]:>9g}")
    worst = 0.0
    for s in bact.SETS:
        exact, found = studies.delay_margins(s, at), margins[s.name][1]
        worst = max(worst, np.abs(found / exact - 1.0).max())
        lag_alone = linear.delay_margin(at[-1], studies.with_unit_gain(s))[0]
        pairs = [f"{MILLI * a:.2f} / {MILLI * b:.2f}" for a, b in zip(exact, found)]
        ratios = PERCENT * studies.closed_loop_damping(s, at)
        print(f"{s.name:<20}{s.k:>8.4f}" + row(ratios, "9.2f") + row(pairs, "16") + f"{MILLI * lag_alone:>9.2f}")
    far = max(np.abs(damping[s.name][1] - studies.closed_loop_damping(s, studies.POINTS_PSF)).max() for s in bact.SETS)
    print(f"Eigenvalues against time responses: margins within {PERCENT * worst:.3f} %, damping ratios within {far:.1e}")
    return worst


def eaten(left, plunge):
    """Both map dynamic pressure to numbers over `studies.RATES_DEG_S`."""
    print(f"\n{studies.REFERENCE.name} with stops at {recovery.STOPS_DEG:g} deg, let go from a plunge")
    print(f"  {'rate limit, deg/s':<52}" + row(studies.RATES_DEG_S, "8g"))
    for q in studies.PRESSURES_PSF:
        words = f"{q:g} psf: extra delay that it bears after {INCHES * studies.PLUNGE_FT:g} in, ms"
        print(f"  {words:<52}" + row(MILLI * left[q], "8.2f"))
        print(f"  {f'{q:g} psf: plunge that it recovers from, in':<52}" + row(INCHES * plunge[q], "8.2f"))


def below_flutter(amplitudes):
    plunge, rate = INCHES * studies.BELOW_PLUNGE_FT, studies.BELOW_RATE_DEG_S
    print(
        f"  {studies.BELOW_PSF:g} psf, below flutter, {studies.BELOW_SECONDS:g} s after {plunge:g} in of plunge, pitch amplitude:"
    )
    print("    " + "; ".join(f"{case} {amplitude:.2g} deg" for case, amplitude in amplitudes.items()) + f" ({rate:g} deg/s)")


def limit_cycles(cycles):
    """{set: (predicted, measured)}."""
    print(f"\nLimit cycles with {studies.GAP_DEG:g} deg of backlash: pitch amplitude and frequency, describing function / FMU")
    for s, (predicted, measured) in cycles.items():
        for q, amplitude, frequency_hz in measured:
            foreseen = [cycle for at, cycle in predicted if at == q and cycle.stable]
            words = ", ".join(f"{cycle.pitch_deg:.4f} deg {cycle.frequency_hz:.3f} Hz" for cycle in foreseen) or "none"
            print(f"  {s.name:<18}{q:>6g} psf  {words} / {amplitude:.4f} deg {frequency_hz:.3f} Hz")


def two_units(found):
    """Returns the worst difference of a host from the scripted pair."""
    delay, step = MILLI * studies.PAIR_DELAY_S, MILLI * loop.STEP_S
    print(f"\nTwo FMUs, {studies.PAIR_PSF:g} psf, {delay:g} ms extra delay, communication step {step:g} ms: {found.ssp}")
    print(f"  the wing's FMU against the wing in Python, in turn: {found.wing_difference:.1e} of the peak")
    for host in system.HOSTS:
        if host in found.hosts:
            print(f"  {host} against the scripted pair, side by side: {found.hosts[host][1].max():.1e} of the peak")
        else:
            print(f"  {host}: does not load here (Debian: apt install libtbb12); skipped")
    print("  delay margin, ms, at a step of  " + "".join(f"{MILLI * step_s:>9g} ms" for step_s in studies.COUPLING_STEPS_S))
    for label, margins in found.coupling.items():
        print(f"    {label:<30}" + row([MILLI * margin_s for margin_s in margins], "12.3f"))
    return max((difference.max() for _, difference in found.hosts.values()), default=0.0)


def sister_wing(points, modelled):
    if points is None:
        print("\nNo measured flutter points here (set ACTUATOR_DATA): comparison with the sister wing skipped")
        return
    print("\nMeasured on the sister wing without controls (NASA TM-104211), and the quasi-steady model at the same speeds")
    for point, (pressure_psf, frequency_hz) in zip(points, modelled):
        measured = f"{point['q_flutter_psf']:.1f} psf, {point['freq_flutter_Hz']:.2f} Hz"
        print(f"  M {point['Mach']:.2f}: {measured}; model {pressure_psf:.1f} psf, {frequency_hz:.2f} Hz")
