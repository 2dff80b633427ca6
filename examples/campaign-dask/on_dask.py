"""`actuator diagnose` for many jobs, or for one case under many noises, as tasks of a Dask cluster.

    python on_dask.py example -o data                                   # records with known truth, and their manifest
    python on_dask.py diagnose data/manifest.toml -o results            # a cluster of this machine's processors
    python on_dask.py diagnose data/manifest.toml -o results --scheduler tcp://head:8786
    python on_dask.py monte-carlo data/worn.toml --model te-early-unloaded --runs 40 -o spread

Exit code: 0 if every job is finished, 1 if some failed (the others are kept), 2 on bad usage or input.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cluster
import example
import manifest
import monte_carlo
import summary

HERE = Path(__file__).resolve().parent
BUILT = HERE.parents[1] / "target" / "release" / "actuator"


def arguments(given=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)

    one = commands.add_parser("example", help="write records with known truth and their manifest")
    one.add_argument("--duration", type=float, default=15.0, help="length of each record, s [%(default)s]")

    one = commands.add_parser("diagnose", help="diagnose every job of a manifest")
    one.add_argument("manifest", help="which jobs there are; see manifest.py")
    where(one)

    one = commands.add_parser("monte-carlo", help="diagnose one case under many noises: spread, and how often the name is right")
    one.add_argument("truth", type=Path, help="model file: what the actuator is, with the effects that are to be found")
    one.add_argument("--model", default="te-early-unloaded", help="model to be corrected: set name or file [%(default)s]")
    one.add_argument("--runs", type=int, default=40, help="noise sequences [%(default)s]")
    one.add_argument("--first-seed", type=int, default=1, help="of the noise; the others follow [%(default)s]")
    one.add_argument("--noise", type=float, default=0.02, metavar="DEG", help="rms of the noise, deg [%(default)s]")
    one.add_argument("--duration", type=float, default=15.0, help="length of each record, s [%(default)s]")
    where(one)

    for one in commands.choices.values():
        one.add_argument("-o", "--output", type=Path, required=True, help="folder for the results")
        one.add_argument("--program", default=default_program(), help="the binary, under a path that every worker has [%(default)s]")
    return parser.parse_args(given)


def where(parser):
    """Where the jobs run."""
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a cluster that is there, such as tcp://head:8786")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes, where there is no cluster [%(default)s]")
    parser.add_argument("--here", action="store_true", help="without Dask, one job after the other")
    parser.add_argument("--threads", type=int, default=1, help="of each job [%(default)s]")
    parser.add_argument("--fmu", help="take the FMU's binary from this file, under a path that every worker has")


def default_program():
    return os.environ.get("ACTUATOR_PROGRAM") or (str(BUILT) if BUILT.is_file() else shutil.which("actuator") or str(BUILT))


def main(given=None):
    options = arguments(given)
    try:
        return COMMANDS[options.command](checked(options))
    except (manifest.Mistake, cluster.NoWorkers, OSError, subprocess.CalledProcessError) as error:
        told = getattr(error, "stderr", None) or error
        print(f"error: {told}", file=sys.stderr)
        return 2


def checked(options):
    """Makes paths absolute, since jobs run elsewhere, and checks the numbers."""
    options.program = str(Path(options.program).resolve())
    if not os.access(options.program, os.X_OK):
        raise manifest.Mistake(f"program: {options.program} is not there; `cargo build --release`, or name it: --program")
    if getattr(options, "fmu", None):
        options.fmu = str(Path(options.fmu).resolve())
    for name in ("workers", "threads", "runs", "duration", "noise"):
        if getattr(options, name, 1) <= 0:
            raise manifest.Mistake(f"--{name}: {getattr(options, name)}; allowed: above 0")
    options.output = options.output.resolve()
    options.output.mkdir(parents=True, exist_ok=True)
    return options


def diagnose(options):
    jobs = manifest.read(options.manifest, options.output, options)
    return summary.tell(jobs, cluster.run_all(jobs, options), options.output)


def spread(options):
    jobs = monte_carlo.jobs(options)
    ended = summary.tell(jobs, cluster.run_all(jobs, options), options.output, listed=False)
    monte_carlo.tell(jobs, options)
    return ended


COMMANDS = {"example": example.write, "diagnose": diagnose, "monte-carlo": spread}

if __name__ == "__main__":
    sys.exit(main())
