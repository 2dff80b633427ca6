"""Plot of a Monte-Carlo run: every estimate with its 95 % interval against the truth, and the verdicts of the diagnoses."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "0.75"  # Okabe and Ito: distinguishable with any colour vision
COVERING = 1.96  # half width of a 95 % interval in standard errors


def draw(truth, right, estimates, verdicts, path):
    figure, panels = plt.subplots(1, 1 + len(truth), figsize=(3.2 + 4.2 * len(truth), 4.0), constrained_layout=True, squeeze=False)
    for panel, (name, value) in zip(panels[0], truth.items()):
        found = sorted(estimates(right, name))
        for place, (estimate, error) in enumerate(found):
            half = COVERING * (error or 0.0)
            holds = abs(estimate - value) <= half
            panel.errorbar(estimate, place, xerr=half, fmt="o", markersize=3, linewidth=1, color=BLUE if holds else ORANGE)
        panel.axvline(value, color="black", linewidth=1)
        panel.set(xlabel=f"{name} (line: truth)", yticks=[], title=f"{len(found)} estimates, 95 % intervals", ylabel="runs, by estimate")
    panel = panels[0][-1]
    bars = panel.barh(list(verdicts), list(verdicts.values()), height=0.5, color=GREY)
    panel.bar_label(bars, padding=3)
    panel.xaxis.get_major_locator().set_params(integer=True)
    panel.set(xlabel="runs", title="verdict", xlim=(0, 1.15 * max(verdicts.values())), ylim=(-1, len(verdicts)))
    for panel in panels[0]:
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=150, metadata={"Software": None})
    plt.close(figure)
