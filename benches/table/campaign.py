"""A test as long as the report's, in full: 2300 points of 5 minutes, files to report, with time and memory."""

import json
import re
import resource
import shutil
import time as clock

from . import scipy_fit
from .measure import Line, Spread, memory_and_processor, processor_s
from .responses import peer as response

POINTS, DURATION_S = 2300, 300.0
PEER_POINTS = 34
START = [(1.0, 150.0, 0.7)]


def generated(context, points):
    """A folder with records and one manifest: generated campaigns of 34 records each, with different seeds, in one."""
    folder = context.folder / f"campaign-{points}"
    manifest, parts = folder / "manifest.toml", ['[campaign]\nname = "2300 points of 5 minutes"\n']
    records = seed = 0
    while records < points:
        seed += 1
        part = folder / f"{seed}"
        if not (part / "manifest.toml").exists():
            context.actuator("generate-campaign", "-o", part, "--duration", DURATION_S, "--seed", seed, "--force")
        text = (part / "manifest.toml").read_text()
        for table in text.split("[[record]]")[1:]:
            if records == points:
                break
            table = re.sub(r'^name = "(.*)"', rf'name = "\1-{seed}"', table, flags=re.MULTILINE)
            parts.append("[[record]]" + table.replace('file = "records', f'file = "{seed}/records'))
            records += 1
    manifest.write_text("\n".join(parts))
    return manifest


def measure(context):
    points = 34 if context.quick else POINTS
    manifest = generated(context, points)
    results = context.folder / "campaign-results"
    shutil.rmtree(results, ignore_errors=True)
    start = clock.perf_counter()
    peak, processor = memory_and_processor([str(context.program), "campaign", str(manifest), "-o", str(results)])
    elapsed = clock.perf_counter() - start
    summary = json.loads((results / "campaign.json").read_text())
    paths = sorted((manifest.parent / "1" / "records").glob("*.csv"))[:PEER_POINTS]

    def by_hand():
        for path in paths:
            response(path)
            scipy_fit.least_squares(scipy_fit.read(path), START)

    theirs = processor_s(by_hand) / len(paths)
    size_gb = sum(path.stat().st_size for path in manifest.parent.glob("*/records/*.csv")) / 1e9
    what = f"{points} records of 60 000 samples, {size_gb:.1f} GB, processor time for each"
    said = f"{len(summary['records'])} records in the result"
    lines = [
        Line("campaign.each", what, "s", Spread.of([processor / points]), f"pandas, csd, welch, least_squares; of {len(paths)}",
             Spread.of([theirs]), said),
        Line("campaign.processor", "processor time of the run", "s", Spread.of([processor])),
        Line("campaign.clock", "time of the run by the clock", "s", Spread.of([elapsed])),
        Line("campaign.memory", "greatest memory", "MB", Spread.of([peak])),
        Line("campaign.peer_memory", "memory of this process, pandas and scipy included", "MB",
             Spread.of([resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0])),
    ]  # fmt: skip
    return lines, []
