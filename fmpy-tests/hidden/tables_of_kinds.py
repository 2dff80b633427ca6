"""Tables of the wider kinds: rigs with the agreement of their divisions, nuisances and garbage by name."""

from collections import Counter

from . import drive_rigs, independent_rigs, rigs
from .intervals import rate
from .scoring_rigs import FAMILY, NAMING, WITH_EFFECT, WITHOUT_EFFECT

RIGS = (*rigs.RIGS, *independent_rigs.RIGS, *drive_rigs.RIGS)
TITLES = {"rig_healthy": "Healthy rigs", "independent": "Independent rigs, healthy", "rig_effect": "Rigs with one dominant effect",
          "rig_sensor": "Rigs with one dominant effect of the sensor",
          "independent_effect": "Independent rigs with one effect", "drive": "Drives of eight technologies, healthy",
          "drive_effect": "Drives of eight technologies with one effect"}  # fmt: skip
WITHOUT_NAME = ("nothing_missing", "unexplained")


def all_tables(by_kind):
    parts = []
    for kinds, table in ((WITHOUT_EFFECT, healthy), (WITH_EFFECT, with_effect)):
        parts += [table(by_kind[kind], TITLES[kind]) for kind in kinds if by_kind[kind]]
    if by_kind["nuisance"]:
        parts.append(grouped("Nuisances: with an effect, and without", by_kind["nuisance"], nuisance))
    if by_kind["garbage"]:
        parts.append(grouped("Garbage, by kind", by_kind["garbage"], lambda row: row["truth"]["garbage"]))
    if by_kind["check_only"]:
        parts.append(grouped("Met in the check record alone", by_kind["check_only"], lambda row: row["truth"]["truth"][0]))
    return parts


def label(truth):
    """What a case is about beside its effects."""
    return truth.get("rig") or truth.get("nuisance") or truth.get("garbage") or ""


def nuisance(row):
    return f"{row['truth']['nuisance']}, {'effect' if row['truth']['truth'] else 'none'}"


def healthy(rows, title):
    named = [row for row in rows if row["outcome"] not in (*WITHOUT_NAME, "failed")]
    said = Counter("+".join(sorted(row["named"])) for row in named)
    rates = [f"Any name: {rate(len(named), len(rows))}; without those that truly act in the rig: "
             f"{rate(sum(row['outcome'] in NAMING for row in rows), len(rows))}. `named` or `ambiguous`, no lead: "
             f"{rate(sum(row['verdict'] in ('named', 'ambiguous') for row in named), len(rows))}.", agreement(rows),
             f"Said: {', '.join(f'`{what}` {count}' for what, count in said.most_common())}." if said else ""]  # fmt: skip
    return "\n".join([grouped(title, rows, lambda row: row["truth"]["rig"]), "", " ".join(filter(None, rates))])


def with_effect(rows, title):
    strengths = [row["strength_right"] for row in rows if row.get("strength_right") is not None]
    rates = [f"Right family: {rate(sum(row['outcome'] in FAMILY.values() for row in rows), len(rows))}; wrong or spurious: "
             f"{rate(sum(row['outcome'] in ('wrong', 'spurious') for row in rows), len(rows))}; strength within 20 % where it has a counterpart: "
             f"{rate(sum(strengths), len(strengths))}.", agreement(rows)]  # fmt: skip
    return "\n".join([
        grouped(f"{title}, by effect", rows, lambda row: row["truth"]["truth"][0]), "",
        grouped(f"{title}, by rig", rows, lambda row: row["truth"]["rig"]), "", " ".join(filter(None, rates)),
    ])  # fmt: skip


def agreement(rows):
    """Rigs all of whose divisions were run and say the same: verdict and names; draws that say what most of their rig do. Of rigs that are not
    divided, nothing."""
    divided = {}
    for row in rows:
        divided.setdefault(row["truth"]["number"], []).append((row.get("verdict", "failed"), tuple(sorted(row["named"]))))
    several = [said for said in divided.values() if len(said) > 1]
    if not several:
        return ""
    same_verdict = sum(len({verdict for verdict, _ in said}) == 1 for said in several)
    as_most = sum(Counter(verdict for verdict, _ in said).most_common(1)[0][1] for said in several)
    same_names = sum(len({names for _, names in said}) == 1 for said in several)
    return (f"Divisions of a rig agree in the verdict: {rate(same_verdict, len(several))}; in the names: {rate(same_names, len(several))}. "
            f"Draws with the verdict of most of their rig: {rate(as_most, sum(map(len, several)))}.")  # fmt: skip


def grouped(title, rows, key):
    """Counts of outcomes by a key, and what was named."""
    outcomes = [name for name, _ in Counter(row["outcome"] for row in rows).most_common()]
    lines = [f"## {title}", "", f"| | cases | {' | '.join(name.replace('_', ' ') for name in outcomes)} | said |",
             "| --- |" + " ---: |" * (len(outcomes) + 1) + " --- |"]  # fmt: skip
    for name in sorted({key(row) for row in rows}, key=order):
        mine = [row for row in rows if key(row) == name]
        counts = Counter(row["outcome"] for row in mine)
        said = Counter("+".join(row["named"]) for row in mine if row["named"])
        lines.append(f"| {name.replace('_', ' ')} | {len(mine)} | " + " | ".join(str(counts[o]) for o in outcomes)
                     + f" | {', '.join(f'`{what}` {count}' for what, count in said.most_common())} |")  # fmt: skip
    return "\n".join(lines)


def order(name):
    return (RIGS.index(name), "") if name in RIGS else (len(RIGS), name)
