"""Runs the hidden-effect suite: draws cases, lets `actuator diagnose` look at their records, scores what it names.

    python fmpy-tests/hidden/run.py --kind single --n 100 --seed 1          # seeds 1 to 100
    python fmpy-tests/hidden/run.py --n 100 --write-docs                    # all kinds; rewrites docs/hidden-effects.md
    python fmpy-tests/hidden/run.py --kind single --seed 17 --n 1 --keep /tmp/case   # one case again, its files kept
    python fmpy-tests/hidden/run.py --n 20 --only-write /tmp/cases          # files alone, without the product
"""

import argparse
import multiprocessing
import sys
import tempfile
import time as clock
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from hidden import cases, files  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog=__doc__.split("\n", 1)[1],
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("--kind", choices=(*cases.KINDS, "all"), default="all")
    parser.add_argument("--n", type=int, default=20, help="cases of each kind (20)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first case; the others follow (1)")
    parser.add_argument("--only-write", type=Path, metavar="DIR", help="write the files of the cases and do not run the product")
    return parser.parse_args()


def write_one(job):
    kind, seed, folder = job
    case = cases.draw(seed, kind)
    files.write(case, folder / f"{kind}-{seed}")
    return f"{kind}-{seed}: {', '.join(f'{name} ENR {enr:.2g}' for name, enr in case.enr_of.items()) or 'nothing'}"


def main():
    asked = arguments()
    kinds = cases.KINDS if asked.kind == "all" else (asked.kind,)
    jobs = [(kind, seed, asked.only_write) for kind in kinds for seed in range(asked.seed, asked.seed + asked.n)]
    for job in jobs:
        print(write_one(job), flush=True)


if __name__ == "__main__":
    main()
