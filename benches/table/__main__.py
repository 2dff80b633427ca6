"""`./bench`: ours and theirs alternating; a table, and with --write-docs docs/benchmarks.md."""

import argparse
import sys
import time

from . import document, machine
from .context import Context
from .rows import ROWS, named

EPILOG = f"""rows: {", ".join(row.name for row in ROWS)}

Without --only all rows are run but {", ".join(row.name for row in ROWS if row.long)}, which takes long: --long. Nothing is written but below
target/, unless --write-docs is given: then docs/benchmarks.json gets the numbers, and docs/benchmarks.md and its pictures are made from that
file. A row that was not run keeps its numbers and their date. Run it on a computer that does nothing else."""


def parser():
    found = argparse.ArgumentParser(
        prog="./bench",
        description="Compares the product with its peers: the same work, in turn, in one run; prints medians, quartiles and ratios.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    found.add_argument("--only", nargs="+", metavar="NAME", help="run only these rows")
    found.add_argument("--long", action="store_true", help="run the rows that take long, too")
    found.add_argument("--quick", action="store_true", help="few rounds and short records: shows that it works, not how fast; excludes --write-docs")
    found.add_argument("--write-docs", action="store_true", help="write docs/benchmarks.json, docs/benchmarks.md and its pictures")
    found.add_argument("--list", action="store_true", help="print the rows and end")
    return found


def main():
    options = parser().parse_args()
    if options.list:
        for row in ROWS:
            print(f"{row.name:<18} {row.title}{' (--long)' if row.long else ''}")
        return 0
    if options.quick and options.write_docs:
        parser().error("--quick measures nothing that belongs into the docs: leave out --write-docs")
    chosen = named(options.only) if options.only else [row for row in ROWS if options.long or not row.long]
    context, failed = Context(options.quick), []
    for row in chosen:
        load, start = machine.load(), time.perf_counter()
        print(f"\n{row.title} ({row.name}, load {load})", flush=True)
        try:
            lines, pictures = row.measure(context)
        except Exception as error:  # noqa: BLE001  a row that cannot be measured does not affect the others
            failed.append(row.name)
            print(f"  failed: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
            continue
        for line in lines:
            print(f"  {document.plain(line)}")
        for words in map(document.exponents, pictures):
            print(f"  {words}")
        print(f"  {time.perf_counter() - start:.0f} s", flush=True)
        if options.write_docs:
            document.keep(row, lines, pictures, load)
    if options.write_docs:
        print("\nwritten:", *document.write(), sep="\n  ")
    if failed:
        print(f"\nfailed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
