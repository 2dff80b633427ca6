"""Results as tables in Markdown: outcomes, confusion, detectability, closing of the gap, parameters, seconds, seeds to look at."""

from collections import Counter

import numpy as np

from . import tables_of_kinds
from .intervals import rate, wilson
from .kinds import KINDS
from .scoring import FALSE_NAMES, GOOD, OUTCOMES, kind_of
from .scoring_rigs import WITH_EFFECT
from .strengths import FAMILIES, OUTSIDE_FAMILIES

ENR_EDGES = (0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0, np.inf)
LEAST_ENR_OF_CHECK = 0.3
STATED = ("right", "first", "leading", "listed")
ONE_EFFECT = ("single", "wide")


def all_tables(rows):
    """Tables of whatever kinds there are; every rate of the first with its 95 % interval (Wilson)."""
    by_kind = {kind: [row for row in rows if row["truth"]["kind"] == kind] for kind in KINDS}
    parts = [outcomes(rows)]
    for kind in ONE_EFFECT:
        if by_kind[kind]:
            parts += [confusion(by_kind[kind], kind), detectability(by_kind[kind], kind)]
    for kind in ("outside", "wide_outside"):
        if by_kind[kind]:
            names = (*OUTSIDE_FAMILIES, "unsigned_sensor")
            parts.append(by_name(f"Outside the library ({kind}), by what acts", by_kind[kind], names, OUTCOMES[kind]))
    parts += tables_of_kinds.all_tables(by_kind)
    found = [row for kind in ("single", "pair", "wide", "wide_pair", "triple") for row in by_kind[kind] if row["outcome"] in ("right", "first", "leading")]
    if found:
        parts += [closing(found), parameters(found)]
    return "\n\n".join([*parts, violations(rows), seconds(rows), to_look_at(rows)]) + "\n"


def outcomes(rows):
    """One line per kind, with the shares that matter."""
    groups = {}
    for row in rows:
        groups.setdefault(kind_of(row["truth"]), []).append(row)
    lines = ["## Outcomes", "", "95 % intervals by Wilson's score.", ""]
    for kind in sorted(groups, key=list(OUTCOMES).index):
        mine = groups[kind]
        counts = Counter(row["outcome"] for row in mine)
        lines.append(f"- **{kind}**, {len(mine)} cases: "
                     + ", ".join(f"{name.replace('_', ' ')} {with_interval(counts[name], mine)}" for name in OUTCOMES[kind]))  # fmt: skip
        if "right" in OUTCOMES[kind]:
            lines.append(f"  - right or stated {rate(sum(counts[name] for name in STATED), len(mine))}; wrong or spurious "
                         f"{rate(counts['wrong'] + counts['spurious'], len(mine))}; family right {rate(sum(bool(row.get('family_right')) for row in mine), len(mine))}")  # fmt: skip
        elif "named" in OUTCOMES[kind] and kind not in (*WITH_EFFECT, "garbage"):
            lines.append(f"  - false names {rate(sum(counts[name] for name in FALSE_NAMES), len(mine))}"
                         + "".join(f"; {label} {counts_of_names(part)}" for label, part in noise_parts(mine) if part and kind == "clean"))  # fmt: skip
    return "\n".join(lines)


def with_interval(count, rows):
    """`158 (94.0 %, 89.4 to 96.7)`; a count of nothing stands alone."""
    low, high = wilson(count, len(rows))
    return f"{count} ({share(count, rows)}, {100.0 * low:.1f} to {100.0 * high:.1f})" if count else "0"


def violations(rows):
    """A gap on the check record that the explanation made wider: no verdict may."""
    stated = [row for row in rows if row.get("widened") is not None]
    wider = [row for row in stated if row["widened"]]
    listed = "".join(f"\n- {row['truth']['kind']} {row['truth']['seed']}: {row['verdict']}, {'+'.join(row['named']) or 'no name'}" for row in wider)
    return f"## Check records whose gap grew\n\n{rate(len(wider), len(stated))}.{listed}"


def noise_parts(rows):
    parts = (("white noise", True), ("coloured noise", False))
    return [(label, [row for row in rows if (row["truth"]["noise"]["kind"] == "white") is white]) for label, white in parts]


def counts_of_names(rows):
    return f"{sum(row['outcome'] in FALSE_NAMES for row in rows)} of {len(rows)}"


def confusion(rows, kind="single"):
    """Truth against what stands first; sparse, as most of it is the diagonal."""
    lines = [f"## {kind.capitalize()}: what is there, and what was said", "", "| truth | cases | right | first, leading or listed | abstained | wrong |", "| --- | ---: | ---: | ---: | ---: | --- |"]
    for name in FAMILIES:
        mine = [row for row in rows if row["truth"]["truth"] == [name]]
        if mine:
            counts = Counter(row["outcome"] for row in mine)
            wrong = Counter("+".join(row["named"]) for row in mine if row["outcome"] in ("wrong", "spurious"))
            wrong["failed"] = counts["failed"]
            said = ", ".join(f"`{what}` {count}" for what, count in wrong.most_common() if count)
            listed = Counter(row["named"][0] for row in mine if row["outcome"] == "listed")
            others = f" ({', '.join(f'`{what}` {count}' for what, count in listed.most_common())})" if listed else ""
            lines.append(f"| `{name}` | {len(mine)} | {counts['right']} | {counts['first'] + counts['leading'] + counts['listed']}{others} | {counts['abstained']} | {said} |")
    return "\n".join(lines)


def detectability(rows, kind="single"):
    """Outcomes against ENR. Shifted parameters count by the gap of the model as given."""
    names = OUTCOMES[kind]
    lines = [f"## {kind.capitalize()}: detectability", "", f"| ENR | cases | {' | '.join(names)} | right or stated, 95 % |",
             "| --- |" + " ---: |" * (len(names) + 2)]  # fmt: skip
    for low, high in zip(ENR_EDGES, ENR_EDGES[1:]):
        mine = [row for row in rows if low <= row["truth"]["enr"] < high]
        if mine:
            counts = Counter(row["outcome"] for row in mine)
            label = f"above {low:g}" if high == np.inf else f"{low:g} to {high:g}" if low else f"below {high:g}"
            stated = with_interval(sum(counts[name] for name in STATED), mine)
            lines.append(f"| {label} | {len(mine)} | " + " | ".join(share(counts[name], mine) for name in names) + f" | {stated} |")
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
            there = "+".join(f"{name} (ENR {enr:.2g})" for name, enr in truth["enr_of"].items()) or tables_of_kinds.label(truth) or "nothing"
            said = row.get("error") or "+".join(row["named"]) or row.get("verdict")
            lines.append(f"- {truth['kind']} {truth['seed']}: {row['outcome']}; {there}, {truth['noise']['kind']} noise; said {said}")
    return "\n".join(lines)


def share(count, rows):
    return f"{100.0 * count / len(rows):.1f} %"


def line(row):
    """One case for the progress."""
    truth = row["truth"]
    there = " ".join(filter(None, ["+".join(f"{name} {enr:.2g}" for name, enr in truth["enr_of"].items()), tables_of_kinds.label(truth)])) or "nothing"
    said = row.get("error") or "+".join(row["named"]) or row.get("verdict", "")
    also = f" or {', '.join(row['alternatives'])}" if row["alternatives"] else ""
    return f"{truth['kind']:12} {truth['seed']:6}  {row['outcome']:15} {there}: {said}{also}  {row.get('seconds', 0.0):.2f} s"
