"""Results as tables in Markdown: outcomes, confusion, detectability, closing of the gap, parameters, seconds, seeds to look at."""

from collections import Counter

import numpy as np

from .cases import KINDS
from .scoring import GOOD, OUTCOMES
from .strengths import FAMILIES, OUTSIDE_FAMILIES

ENR_EDGES = (0.0, 0.5, 1.0, 2.0, 4.0, np.inf)
LEAST_ENR_OF_CHECK = 0.3
STATED = ("right", "first", "listed")


def all_tables(rows):
    by_kind = {kind: [row for row in rows if row["truth"]["kind"] == kind] for kind in KINDS}
    parts = [outcomes(by_kind)]
    if by_kind["single"]:
        parts += [confusion(by_kind["single"]), detectability(by_kind["single"])]
    if by_kind["outside"]:
        parts.append(by_name("Outside the library, by what acts", by_kind["outside"], OUTSIDE_FAMILIES, OUTCOMES["outside"]))
    found = [row for row in by_kind["single"] + by_kind["pair"] if row["outcome"] in ("right", "first")]
    if found:
        parts += [closing(found), parameters(found)]
    return "\n\n".join([*parts, seconds(rows), to_look_at(rows)]) + "\n"


def outcomes(by_kind):
    """One line per kind, with the shares that matter."""
    lines = ["## Outcomes", ""]
    for kind, rows in by_kind.items():
        if not rows:
            continue
        counts = Counter(row["outcome"] for row in rows)
        lines.append(f"- **{kind}**, {len(rows)} cases: "
                     + ", ".join(f"{name.replace('_', ' ')} {counts[name]} ({share(counts[name], rows)})" for name in OUTCOMES[kind]))  # fmt: skip
        if kind == "single":
            lines.append(f"  - right or stated {share(sum(counts[name] for name in STATED), rows)}, wrong or spurious "
                         f"{share(counts['wrong'] + counts['spurious'], rows)}, family right {share(sum(bool(row.get('family_right')) for row in rows), rows)}")  # fmt: skip
        if kind in ("clean", "outside"):
            lines.append(f"  - false names {share(counts['named'] + counts['ambiguous'], rows)}"
                         + "".join(f"; {label} {counts_of_names(part)}" for label, part in noise_parts(rows) if part and kind == "clean"))  # fmt: skip
    return "\n".join(lines)


def noise_parts(rows):
    parts = (("white noise", True), ("coloured noise", False))
    return [(label, [row for row in rows if (row["truth"]["noise"]["kind"] == "white") is white]) for label, white in parts]


def counts_of_names(rows):
    return f"{sum(row['outcome'] in ('named', 'ambiguous') for row in rows)} of {len(rows)}"


def confusion(rows):
    """Truth against what stands first; sparse, as most of it is the diagonal."""
    lines = ["## Singles: what is there, and what was said", "", "| truth | cases | right | first or listed | abstained | wrong |", "| --- | ---: | ---: | ---: | ---: | --- |"]
    for name in FAMILIES:
        mine = [row for row in rows if row["truth"]["truth"] == [name]]
        if mine:
            counts = Counter(row["outcome"] for row in mine)
            wrong = Counter("+".join(row["named"]) for row in mine if row["outcome"] in ("wrong", "spurious"))
            wrong["failed"] = counts["failed"]
            said = ", ".join(f"`{what}` {count}" for what, count in wrong.most_common() if count)
            listed = Counter(row["named"][0] for row in mine if row["outcome"] == "listed")
            others = f" ({', '.join(f'`{what}` {count}' for what, count in listed.most_common())})" if listed else ""
            lines.append(f"| `{name}` | {len(mine)} | {counts['right']} | {counts['first'] + counts['listed']}{others} | {counts['abstained']} | {said} |")
    return "\n".join(lines)


def detectability(rows):
    """Outcomes against ENR. Shifted parameters count by the gap of the model as given."""
    names = OUTCOMES["single"]
    lines = ["## Singles: detectability", "", f"| ENR | cases | {' | '.join(names)} |", "| --- |" + " ---: |" * (len(names) + 1)]
    for low, high in zip(ENR_EDGES, ENR_EDGES[1:]):
        mine = [row for row in rows if low <= row["truth"]["enr"] < high]
        if mine:
            counts = Counter(row["outcome"] for row in mine)
            label = f"above {low:g}" if high == np.inf else f"{low:g} to {high:g}" if low else f"below {high:g}"
            lines.append(f"| {label} | {len(mine)} | " + " | ".join(share(counts[name], mine) for name in names) + " |")
    return "\n".join(lines)


def by_name(title, rows, names, outcomes_shown):
    lines = [f"## {title}", "", f"| | cases | {' | '.join(name.replace('_', ' ') for name in outcomes_shown)} | named |",
             "| --- |" + " ---: |" * (len(outcomes_shown) + 1) + " --- |"]  # fmt: skip
    for name in names:
        mine = [row for row in rows if row["truth"]["truth"] == [name]]
        if mine:
            counts = Counter(row["outcome"] for row in mine)
            said = Counter("+".join(row["named"]) for row in mine if row["named"])
            lines.append(f"| {name.replace('_', ' ')} | {len(mine)} | " + " | ".join(str(counts[o]) for o in outcomes_shown)
                         + f" | {', '.join(f'`{what}` {count}' for what, count in said.most_common())} |")  # fmt: skip
    return "\n".join(lines)


def closing(rows):
    """`closed` compares squares less those of the noise: it says nothing where the check record shows next to nothing of the effect,
    nor for rounding, which adds to the noise what no model can take away."""
    telling = [row for row in rows if row["truth"]["enr_check"] >= LEAST_ENR_OF_CHECK and "quantisation" not in row["truth"]["truth"]]
    values = [row["closed"] for row in telling if row["closed"] is not None]
    stated = (f"Median {np.median(values):.4f}, 10th percentile {np.percentile(values, 10):.4f}, least {min(values):.3f}; {len(values)} cases."
              if values else "None stated.")  # fmt: skip
    return (f"## Gap closed on check records, where rightly named\n\n{stated} Left out: {len(rows) - len(telling)} with quantisation, "
            f"or whose check record shows the effect with an ENR below {LEAST_ENR_OF_CHECK}.")  # fmt: skip


def parameters(rows):
    """Errors of the parameters of what was rightly named."""
    errors = {}
    for row in rows:
        for label, error in row["parameter_errors"].items():
            errors.setdefault(label, []).append(error)
    lines = ["## Parameters, where rightly named", "", "| parameter | values | median error | 90th percentile |", "| --- | ---: | ---: | ---: |"]
    lines += [f"| `{label}` | {len(found)} | {100 * np.median(found):.2f} % | {100 * np.percentile(found, 90):.2f} % |" for label, found in sorted(errors.items())]
    everything = [error for found in errors.values() for error in found]
    if everything:
        lines.append(f"| all | {len(everything)} | {100 * np.median(everything):.2f} % | {100 * np.percentile(everything, 90):.2f} % |")
    return "\n".join(lines)


def seconds(rows):
    values = [row["seconds"] for row in rows if "seconds" in row]
    if not values:
        return "No case was diagnosed."
    return f"Seconds per case: median {np.median(values):.2f}, 90th percentile {np.percentile(values, 90):.2f}, longest {max(values):.2f}."


def to_look_at(rows):
    """What did not go well, so that it can be drawn again."""
    lines = ["## Cases to look at", "", "Each again, with its files kept: `run.py --kind KIND --seed SEED --n 1 --keep DIR`.", ""]
    for row in rows:
        if row["outcome"] not in GOOD:
            truth = row["truth"]
            there = "+".join(f"{name} (ENR {enr:.2g})" for name, enr in truth["enr_of"].items()) or "nothing"
            said = row.get("error") or "+".join(row["named"]) or row.get("verdict")
            lines.append(f"- {truth['kind']} {truth['seed']}: {row['outcome']}; {there}, {truth['noise']['kind']} noise; said {said}")
    return "\n".join(lines)


def share(count, rows):
    return f"{100.0 * count / len(rows):.1f} %"


def line(row):
    """One case for the progress."""
    truth = row["truth"]
    there = "+".join(f"{name} {enr:.2g}" for name, enr in truth["enr_of"].items()) or "nothing"
    said = row.get("error") or "+".join(row["named"]) or row.get("verdict", "")
    also = f" or {', '.join(row['alternatives'])}" if row["alternatives"] else ""
    return f"{truth['kind']:7} {truth['seed']:6}  {row['outcome']:15} {there}: {said}{also}  {row.get('seconds', 0.0):.2f} s"
