"""Plots the results of `studies`, in the style and colours of the FMU's other plots."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

import bact
import pictures
from flutter import linear, studies

COLOURS = dict(zip(studies.PRESSURES_PSF, ("#0072b2", "#d55e00", "#009e73")))  # Okabe and Ito
GREY, SMALL = "0.45", 8.5
DPI = 120
INCHES = 12.0  # inches in a foot
RESPONSE_SHOWN_S = 1.4
PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
LIMITS = "stops ±15 deg"


def saved(figure, path):
    figure.savefig(path, dpi=DPI)
    plt.close(figure)
    return path


def by_surface():
    return {surface: [s for s in bact.SETS if s.surface == surface] for surface in pictures.TITLES}


def title(surface):
    """Only the trailing edge's own actuator moves it on the wing; the others are substitutes."""
    name = pictures.TITLES[surface]
    return "Trailing-edge actuator" if surface == bact.TE else f"{name}'s actuator in its place"


def margins_picture(damping, margins, path):
    """`damping` and `margins` map a set's name to (line over LINE_PSF, points); damping has 'wing' for the open loop."""
    flutter_psf, _ = linear.flutter_point()
    with plt.rc_context(pictures.STYLE):
        figure, rows = plt.subplots(2, 3, figsize=(11.5, 7.8), sharex=True, sharey="row", constrained_layout=True)
        for column, (surface, sets) in enumerate(by_surface().items()):
            upper, lower = rows[:, column]
            upper.plot(studies.LINE_PSF, 100 * damping["wing"], color=GREY, linewidth=1.6, linestyle=":")
            upper.axhline(0.0, color="black", linewidth=0.8)
            for s in sets:
                for panel, (line, points), at, factor in (
                    (upper, damping[s.name], studies.POINTS_PSF, 100.0),
                    (lower, margins[s.name], studies.PRESSURES_PSF, 1e3),
                ):
                    panel.plot(studies.LINE_PSF, factor * line, **pictures.look(s, marker=""))
                    panel.plot(at, factor * points, **pictures.look(s, linestyle="none"), clip_on=False, zorder=3)
            for panel in (upper, lower):
                panel.axvline(flutter_psf, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
            upper.set_title(title(surface))
            lower.set(ylim=(0, 20), xlim=(studies.LINE_PSF[0], studies.LINE_PSF[-1]), xlabel="dynamic pressure, psf")
            lower.legend(handles=[Line2D([], [], label=f"{s.stage}, {s.load_case}", **pictures.look(s)) for s in sets],
                         loc="upper right", fontsize=SMALL, handlelength=3.2)  # fmt: skip
        rows[0, 0].set(ylabel="least damping ratio of an oscillation, %", ylim=(-7, 13))
        rows[0, 0].annotate("wing alone", (215, -3.2), color=GREY, fontsize=SMALL)
        rows[0, 0].annotate("flutter of\nthe wing alone", (flutter_psf - 1.5, -6.6), color=GREY, fontsize=SMALL, ha="right")
        rows[1, 0].set_ylabel("extra delay until it is unstable, ms")
        figure.suptitle(
            "Control law and actuator in the loop. Lines: eigenvalues. Points: time responses with the FMU", fontsize=11
        )
        return saved(figure, path)


def responses_picture(responses, wing_alone, path):
    """`responses[q][name]` are runs of the loop, `wing_alone[q]` one with the loop open."""
    with plt.rc_context(pictures.STYLE):
        figure, rows = plt.subplots(len(responses), 3, figsize=(11.5, 2.7 * len(responses) + 1.0), sharex=True, sharey="row")
        for row, (q, runs) in zip(rows, responses.items()):
            for panel, sets in zip(row, by_surface().values()):
                panel.plot(wing_alone[q].time, wing_alone[q].pitch, color="0.8", linewidth=1.0)
                for s in sets:
                    panel.plot(runs[s.name].time, runs[s.name].pitch, **pictures.look(s, marker="", linewidth=1.1))
            bound = 1.15 * max(np.abs(run.pitch).max() for run in runs.values())
            row[0].set(ylim=(-bound, bound), xlim=(0, RESPONSE_SHOWN_S), ylabel=f"{q:g} psf\npitch, deg")
        for panel, surface in zip(rows[0], by_surface()):
            panel.set_title(title(surface))
        for panel in rows[-1]:
            panel.set_xlabel("time, s")
        sets = by_surface()[bact.TE]
        handles = [Line2D([], [], label=f"{s.stage}, {s.load_case}", **pictures.look(s, marker="")) for s in sets]
        handles.append(Line2D([], [], color="0.8", label="wing alone"))
        figure.suptitle("Let go from 0.01 ft of plunge, with the FMU in the loop", fontsize=11)
        figure.tight_layout(rect=(0, 0.045, 1, 1))
        figure.legend(handles=handles, loc="lower center", ncols=len(handles), fontsize=SMALL, handlelength=2.6)
        return saved(figure, path)


def eaten_picture(delay, left, plunge, cycles, path):
    """Four maps from dynamic pressure to results of `studies`: damping against delay, and the three limits."""
    with plt.rc_context(pictures.STYLE):
        figure, ((a, b), (c, d)) = plt.subplots(2, 2, figsize=(10.4, 8.2), constrained_layout=True)
        for q, colour in COLOURS.items():
            (line_s, exact), (points_s, measured) = delay[q]
            a.plot(1e3 * line_s, 100 * exact, color=colour, label=f"{q:g} psf")
            a.plot(1e3 * points_s, 100 * measured, "o", color=colour, markerfacecolor="white", markersize=5)
            b.plot(studies.RATES_DEG_S, 1e3 * left[q], "o-", color=colour, markersize=4, linewidth=1.2)
            b.axhline(1e3 * linear.delay_margin(q, studies.REFERENCE)[0], color=colour, linewidth=0.8, linestyle=(0, (2, 2)))
            c.plot(studies.RATES_DEG_S, INCHES * plunge[q], "o-", color=colour, markersize=4, linewidth=1.2)
            (line_s, amplitudes), (points_s, found) = cycles[q]
            d.plot(1e3 * line_s, amplitudes, color=colour)
            d.plot(1e3 * points_s, found, "o", color=colour, markerfacecolor="white", markersize=5)
            d.axvline(1e3 * linear.delay_margin(q, studies.REFERENCE)[0], color=colour, linewidth=0.8, linestyle=(0, (2, 2)))
        a.axhline(0.0, color="black", linewidth=0.8)
        a.set(title="Delay", xlabel="extra delay, ms", ylabel="damping ratio of the 5 Hz mode, %", xlim=(0, None))
        a.legend(title="dynamic pressure", title_fontsize=SMALL)
        b.set(title=f"Rate limit, after {INCHES * studies.PLUNGE_FT:g} in of plunge, {LIMITS}", xlabel="rate limit, deg/s",
              ylabel="extra delay from which it recovers, ms", ylim=(0, None), xlim=(0, None))  # fmt: skip
        b.annotate(
            "dashed: delay margin of the linear loop",
            (0.98, 0.04),
            xycoords="axes fraction",
            ha="right",
            fontsize=SMALL,
            color=GREY,
        )
        c.set(title=f"Rate limit, no extra delay, {LIMITS}", xlabel="rate limit, deg/s",
              ylabel="largest plunge from which it recovers, in", ylim=(0, None), xlim=(0, None))  # fmt: skip
        d.set(title=f"Backlash of {studies.GAP_DEG:g} deg and delay: limit cycle", xlabel="extra delay, ms",
              ylabel="pitch amplitude, deg", yscale="log", xlim=(0, None), ylim=(0.008, 1.0))  # fmt: skip
        d.annotate("lines: describing function\npoints: FMU\ndashed: delay margin without backlash", (0.03, 0.97),
                   xycoords="axes fraction", va="top", fontsize=SMALL, color=GREY)  # fmt: skip
        figure.suptitle(f"What eats the margin of the loop with the {studies.REFERENCE.name} actuator", fontsize=11.5)
        return saved(figure, path)


def cycles_picture(cycles, with_play, without, path):
    """`cycles[set]` is (predicted, measured); `with_play` and `without` are runs at one dynamic pressure."""
    flutter_psf, _ = linear.flutter_point()
    with plt.rc_context(pictures.STYLE):
        figure, (a, b, c) = plt.subplots(1, 3, figsize=(13.0, 4.4), constrained_layout=True)
        for (s, (predicted, measured)), colour in zip(cycles.items(), COLOURS.values()):
            for stable, style in ((True, "-"), (False, ":")):
                chosen = [(q, cycle) for q, cycle in predicted if cycle.stable == stable]
                a.plot([q for q, _ in chosen], [cycle.pitch_deg for _, cycle in chosen], style, color=colour)
                if stable:
                    b.plot([q for q, _ in chosen], [cycle.frequency_hz for _, cycle in chosen], style, color=colour, label=s.name)
            for panel, column in ((a, 1), (b, 2)):
                panel.plot([row[0] for row in measured], [row[column] for row in measured], "o", color=colour,
                           markerfacecolor="white", markersize=5, clip_on=False, zorder=3)  # fmt: skip
        for panel in (a, b):
            panel.axvline(flutter_psf, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
            panel.set(xlabel="dynamic pressure, psf", xlim=(studies.LINE_PSF[0], studies.LINE_PSF[-1]))
        a.set(ylim=(0, 0.037), ylabel="pitch amplitude, deg", title=f"Limit cycle with {studies.GAP_DEG:g} deg of backlash")
        a.annotate("flutter of\nthe wing alone", (flutter_psf + 2, 0.001), color=GREY, fontsize=SMALL)
        a.annotate("lines: describing function (dotted: edge\nbelow which it dies out); points: FMU", (0.03, 0.97),
                   xycoords="axes fraction", va="top", fontsize=SMALL, color=GREY, bbox=PATCH)  # fmt: skip
        b.set(ylabel="frequency, Hz", title="Its frequency")
        b.legend(loc="upper left", fontsize=SMALL)
        c.plot(without.time, without.pitch, color=GREY, linewidth=1.0, label="no backlash")
        c.plot(with_play.time, with_play.pitch, color=COLOURS[200.0], linewidth=1.0, label=f"{studies.GAP_DEG:g} deg of backlash")
        c.set(xlabel="time, s", ylabel="pitch, deg", title="200 psf, te-early-loaded", xlim=(0, with_play.time[-1]))
        c.set_ylim(1.35 * min(with_play.pitch.min(), without.pitch.min()), 1.35 * max(with_play.pitch.max(), without.pitch.max()))
        c.legend(loc="upper right", fontsize=SMALL)
        return saved(figure, path)


def pair_picture(found, path):
    """`studies.TwoUnits`."""
    hosts, steps_ms = found.hosts, 1e3 * np.array(studies.COUPLING_STEPS_S)
    with plt.rc_context(pictures.STYLE):
        figure, (a, b, c) = plt.subplots(1, 3, figsize=(13.0, 4.4), constrained_layout=True)
        looks = ((GREY, "-", 3.0), (COLOURS[200.0], "-", 1.2), (COLOURS[225.0], (0, (4, 2)), 1.2))
        for (label, run), (colour, style, width) in zip(found.runs.items(), looks):
            a.plot(run.time, run.pitch, color=colour, linestyle=style, linewidth=width, label=label)
        a.set(xlabel="time, s", ylabel="pitch, deg", title="225 psf, extra delay 4 ms", xlim=(0, 1.5))
        a.legend(loc="upper right", fontsize=SMALL)
        for (label, (time, difference)), colour in zip(hosts.items(), COLOURS.values()):
            words = f"{label}: {difference.max():.0e} at most" if difference.max() > 0.0 else f"{label}: none, bit for bit"
            b.semilogy(time, np.maximum(difference, 1e-18), color=colour, linewidth=1.0, label=words)
        b.set(xlabel="time, s", ylabel="difference of pitch over its peak", title="Hosts against the scripted pair",
              ylim=(1e-18, 1e-6), xlim=(0, max(time[-1] for time, _ in hosts.values()) if hosts else 1.0))  # fmt: skip
        b.axhline(1e-9, color="black", linewidth=0.8)
        b.annotate("allowed", (0.02, 1.5e-9), fontsize=SMALL)
        b.legend(loc="upper right", fontsize=SMALL)
        for (label, margins), colour, marker in zip(found.coupling.items(), COLOURS.values(), "os^"):
            c.plot(steps_ms, 1e3 * np.array(margins), marker=marker, color=colour, markersize=5, linewidth=1.2, label=label)
        c.axhline(1e3 * linear.delay_margin(225.0, studies.REFERENCE)[0], color="black", linewidth=0.8, linestyle=(0, (2, 2)))
        c.set(xlabel="communication step, ms", ylabel="extra delay until unstable, ms", title="Cost of coupling, 225 psf",
              ylim=(0, 10), xlim=(0, None))  # fmt: skip
        c.legend(loc="lower left", fontsize=SMALL)
        return saved(figure, path)


def measured_picture(points, modelled, path):
    """Flutter points of the sister wing against Mach number; `modelled` [(psf, Hz)] at the same speeds."""
    with plt.rc_context(pictures.STYLE):
        figure, panels = plt.subplots(1, 2, figsize=(9.6, 4.0), constrained_layout=True)
        for panel, column, index, label in zip(
            panels, ("q_flutter_psf", "freq_flutter_Hz"), (0, 1), ("dynamic pressure at flutter, psf", "frequency at flutter, Hz")
        ):
            panel.plot(points["Mach"], points[column], "o", color=COLOURS[160.0], markersize=5, label="measured, sister wing")
            panel.plot(points["Mach"], [m[index] for m in modelled], "-", color=COLOURS[200.0], label="model, same speeds")
            panel.margins(y=0.16)
            panel.set(xlabel="Mach number", ylabel=label)
            panel.legend(fontsize=SMALL, loc="upper left" if index == 0 else "upper right")
        return saved(figure, path)
