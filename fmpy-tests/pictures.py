"""Plots of the FMU in comparison with the report: stepped points on analytic curves, in the axes of the report's figures.

Magnitude 0 to 1.5 deg/deg over 0.5 to 12 Hz, as in NASA/TM-1998-208452; phase from 0 down to -50 deg there, here over the
range of the curves: the upper spoiler, late and loaded, passes -50 deg at 12 Hz.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

import bact
from frequency_sweep import FREQUENCIES_HZ

TITLES = {bact.TE: "Trailing-edge control", bact.US: "Upper spoiler", bact.LS: "Lower spoiler"}
STAGES = ("early", "middle", "late")
COLOURS = dict(zip(STAGES, ("#0072b2", "#d55e00", "#009e73")))  # Okabe and Ito: distinguishable with any colour vision
FINE_HZ = np.linspace(bact.LOWEST_HZ, bact.HIGHEST_HZ, 400)
STYLE = {
    "font.size": 10, "axes.titlesize": 11, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#e5e5e5", "grid.linewidth": 0.7, "axes.axisbelow": True, "legend.frameon": False,
}  # fmt: skip
TICKS_HZ = (0.5, 2, 4, 6, 8, 10, 12)
STEP_TIME_S = 0.12  # duration of the step responses shown: all sets have settled


def magnitude(response):
    return np.abs(response)


def phase_deg(response):
    return np.degrees(np.unwrap(np.angle(response)))


def frequency_response_picture(surface, measured, path, order=bact.THIRD):
    """One surface: `measured` maps a set's name to its stepped response at `FREQUENCIES_HZ`.

    In the report's axes the magnitudes of a surface coincide, so the empty part below shows them enlarged.
    """
    sets = [s for s in bact.SETS if s.surface == surface]
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(2, 1, figsize=(7.6, 8.6), sharex=True, constrained_layout=True)
        enlarged = panels[0].inset_axes([0.1, 0.07, 0.87, 0.5])
        for panel, quantity in ((panels[0], magnitude), (enlarged, magnitude), (panels[1], phase_deg)):
            for s in sets:
                curve_and_points(panel, s, quantity, measured[s.name], order)
            panel.set(xlim=(bact.LOWEST_HZ, bact.HIGHEST_HZ), xticks=TICKS_HZ, xticklabels=[f"{tick:g}" for tick in TICKS_HZ])
        panels[0].set(ylim=(0, 1.5), ylabel="magnitude, deg/deg", title=f"{TITLES[surface]}: position to command")
        enlarged.tick_params(labelsize=8)
        enlarged.set_title("the same, enlarged", fontsize=8.5, pad=3)
        lowest = min(phase_deg(bact.frequency_response(s, order, FINE_HZ)).min() for s in sets)
        panels[1].set(ylim=(min(-50, 10 * np.floor(lowest / 10)), 0), ylabel="phase, deg", xlabel="frequency, Hz")
        panels[1].legend(handles=legend(sets), loc="lower left", ncols=2, handlelength=3.2)
        figure.savefig(path, dpi=150)
        plt.close(figure)
    return path


def curve_and_points(panel, s, quantity, response, order):
    """The analytic curve, and every third stepped point, staggered between sets so that points do not hide each other."""
    turn = slice((STAGES.index(s.stage) + (s.load_case == "loaded")) % 3, None, 3)
    panel.plot(FINE_HZ, quantity(bact.frequency_response(s, order, FINE_HZ)), **look(s, marker=""))
    panel.plot(FREQUENCIES_HZ[turn], quantity(response)[turn], clip_on=False, zorder=3, **{**look(s), "linestyle": "none"})


def look(s, **changes):
    """Colour: stage. Open circles on full lines: unloaded; filled squares on dashed lines: loaded."""
    colour, loaded = COLOURS[s.stage], s.load_case == "loaded"
    return {
        "color": colour, "linestyle": (0, (5, 2)) if loaded else "-", "linewidth": 1.3, "marker": "s" if loaded else "o",
        "markerfacecolor": colour if loaded else "white", "markersize": 4.5, "markeredgewidth": 1.1, **changes,
    }  # fmt: skip


def legend(sets):
    """One entry per set, then the meaning of lines and points."""
    return [Line2D([], [], label=f"{s.stage}, {s.load_case}", **look(s)) for s in sets] + [
        Line2D([], [], color="0.3", linewidth=1.3, label="lines: analytic, equation (1)", linestyle="none"),
        Line2D([], [], color="0.3", linestyle="none", label="points: FMU, stepped every 5 ms"),
    ]


def step_response_picture(times, measured, path, order=bact.THIRD):
    """Unit steps: `measured` maps a set's name to its positions at `times` [s]; one panel per surface."""
    fine = np.linspace(0, times[-1], 600)
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 3, figsize=(11.5, 4.2), sharey=True, constrained_layout=True)
        for panel, surface in zip(panels, TITLES):
            sets = [s for s in bact.SETS if s.surface == surface]
            for s in sets:
                analytic = [bact.advance(s, order, bact.at_rest(0.0), 1.0, t)[1] for t in fine]
                panel.plot(1e3 * fine, analytic, **look(s, marker=""))
                panel.plot(1e3 * times, measured[s.name], **look(s, linestyle="none", markersize=3.6))
            panel.set(title=TITLES[surface], xlabel="time, ms", xlim=(0, 1e3 * times[-1]), ylim=(0, 1.5))
            panel.legend(handles=legend(sets)[:-2], loc="lower right", handlelength=3.2, fontsize=8.5)
        panels[0].set_ylabel("position after a 1 deg step, deg")
        figure.suptitle("Lines: analytic step response, equation (1); points: FMU, stepped every 5 ms", fontsize=11)
        figure.savefig(path, dpi=150)
        plt.close(figure)
    return path
