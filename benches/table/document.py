"""docs/benchmarks.json holds the numbers; docs/benchmarks.md and the charts are generated from it."""

import json
import math

from . import machine
from .context import ROOT
from .measure import Line, Picture
from .reasons import NOTES, REASONS
from .rows import ROWS

DOCS = ROOT / "docs"
NUMBERS = DOCS / "benchmarks.json"

HEAD = """# Benchmarks

`./bench` does the same work with the product and with what one would use otherwise, in turn, in one run; `./bench --write-docs` writes this page. Before
anything is timed, the outputs of both sides are compared; `agreement` is the largest difference by the size of the signal or the
number, and the tolerance beyond which the row would have failed. Numbers are medians, with the first and third quartile of the rounds in brackets; `ratio` is
ours by theirs: of times, less than 1 means that ours is faster. Ratios carry over to other computers, times do not.
"""


def number(value):
    """Three digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{digits}f}"


def spread(found, unit):
    if found is None:
        return ""
    if found.rounds == 1:
        return f"{number(found.median)} {unit}"
    return f"{number(found.median)} ({number(found.low)} to {number(found.high)}) {unit}"


def plain(line):
    ratio = "" if line.theirs is None else f"; {line.peer}: {spread(line.theirs, line.unit)}; ratio {number(line.ratio)}"
    agreement = f"; agreement {line.agreement}" if line.agreement else ""
    return f"{line.what}: {spread(line.ours, line.unit)}{ratio}{agreement}"


def exponent(curve):
    """Slope of log cost over log size, by least squares."""
    x, y = ([math.log(value) for value in values] for values in (curve.size, curve.cost))
    middle, level = sum(x) / len(x), sum(y) / len(y)
    return sum((a - middle) * (b - level) for a, b in zip(x, y)) / sum((a - middle) ** 2 for a in x)


def exponents(picture):
    fitted = (f"{curve.name} {exponent(curve):.2f}" for curve in picture.curves)
    return f"{picture.title}: exponent of {', '.join(fitted)}"


def _read():
    return json.loads(NUMBERS.read_text()) if NUMBERS.exists() else {}


def keep(row, lines, pictures, load):
    """Stores the measurements of a row in docs/benchmarks.json."""
    numbers = _read()
    numbers[row.name] = {
        "date": machine.today(), "load": load, "machine": machine.describe(),
        "lines": [line.to_json() for line in lines], "pictures": [picture.to_json() for picture in pictures],
    }  # fmt: skip
    NUMBERS.write_text(json.dumps(numbers, indent=1) + "\n")


def write():
    """Generates page and charts from the numbers; returns the files written."""
    numbers = _read()
    parts, written = [HEAD, _machines(numbers)], [NUMBERS, DOCS / "benchmarks.md"]
    for row in ROWS:
        if row.name not in numbers:
            parts.append(f"## {row.title}\n\nNot measured yet: `./bench --only {row.name} --write-docs`.\n")
            continue
        found = numbers[row.name]
        lines, pictures = [Line.from_json(line) for line in found["lines"]], [Picture.from_json(one) for one in found["pictures"]]
        parts.append(_section(row, found, lines, pictures))
        written += [_draw(picture) for picture in pictures]
    (DOCS / "benchmarks.md").write_text("\n".join(parts))
    return [path.relative_to(ROOT) for path in written]


def _machines(numbers):
    """Each machine with the rows measured on it."""
    by = {}
    for name, found in numbers.items():
        by.setdefault("; ".join(f"{key} {value}" for key, value in found["machine"].items()), []).append(name)
    if len(by) <= 1:
        return "".join(f"Measured on: {machine_}.\n" for machine_ in by)
    return "".join(f"- {', '.join(names)}: {machine_}\n" for machine_, names in by.items())


def _section(row, found, lines, pictures):
    parts = [f"## {row.title}\n", f"{found['date']}, load of the machine at its start {found['load']}. `./bench --only {row.name}`\n"]
    if row.name in NOTES:
        parts.append(NOTES[row.name] + "\n")
    if lines:
        parts.append("| what | ours | theirs | by | ratio | agreement |\n| --- | --- | --- | --- | --- | --- |")
        for line in lines:
            ratio = number(line.ratio) if line.theirs else ""
            parts.append(f"| {line.what} | {spread(line.ours, line.unit)} | {spread(line.theirs, line.unit)} | {line.peer} | {ratio} | {line.agreement} |")
        parts.append("")
    # One reason may explain several lines.
    reasons = dict.fromkeys(REASONS.get(line.key, f"{line.what}: behind {line.peer}; not profiled yet.") for line in lines if line.behind)
    if reasons:
        parts.append("Behind, by more than both scatter:\n\n" + "\n".join(f"- {reason}" for reason in reasons) + "\n")
    for picture in pictures:
        parts.append(f"{exponents(picture)}.\n\n![{picture.title}]({picture.file})\n")
    return "\n".join(parts)


def _draw(picture):
    """Logarithmic axes; each curve with its fitted exponent."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"svg.hashsalt": "benchmarks", "font.size": 9})
    figure, axes = plt.subplots(figsize=(5.2, 3.4), layout="constrained")
    for curve, mark in zip(picture.curves, "osd^vxP*"):
        slope, scatter = exponent(curve), len(set(curve.size)) < len(curve.size)
        axes.loglog(curve.size, curve.cost, mark if scatter else mark + "-", markersize=4, label=f"{curve.name}: exponent {slope:.2f}")
    axes.set(xlabel=picture.x, ylabel=picture.y, title=picture.title)
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    path = DOCS / picture.file
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    return path
