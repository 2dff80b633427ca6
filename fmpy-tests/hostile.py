"""A host that makes mistakes: `python hostile.py UNPACKED_FMU NUMBER` makes one of them and prints the result as JSON.

One process per mistake, so that a crash is detected. `test_robustness.py` runs them all: after the FMU and a folder, any number of mistakes may be
given, and each is made in a process forked from this one, which loads no FMU itself; starting Python for each would take longer than all the
mistakes. Each mistake specifies the correct statuses and the words that the log line must contain, so that its reader knows what was wrong.
"""

import faulthandler
import json
import os
import signal
import sys
from pathlib import Path

import mistakes_at_random  # noqa: F401  (fills the list)
import mistakes_in_calls  # noqa: F401
import mistakes_in_exchange  # noqa: F401
import mistakes_with_effects  # noqa: F401
import mistakes_with_objects  # noqa: F401
from hostile_host import Host
from mistakes import MISTAKES

PATIENCE_S = 30  # a hang is also a failure; SIGALRM ends it


def commit(fmu, number):
    faulthandler.enable()
    host = Host(fmu)
    status = MISTAKES[number].make(host)
    print(json.dumps({"status": status, "log": host.log}), flush=True)


def commit_apart(fmu, number, folder):
    """Runs in a separate process, whose output goes to files in the folder; returns its exit code, negative for a signal."""
    child = os.fork()
    if child == 0:
        for stream, name in ((sys.stdout, "out"), (sys.stderr, "err")):
            os.dup2(os.open(folder / f"{number}.{name}", os.O_WRONLY | os.O_CREAT), stream.fileno())
        signal.alarm(PATIENCE_S)
        commit(fmu, number)
        sys.exit()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


if __name__ == "__main__":
    fmu, *folder_and_numbers = sys.argv[1:]
    if len(folder_and_numbers) == 1:
        commit(fmu, int(folder_and_numbers[0]))
    else:
        folder, *numbers = folder_and_numbers
        print(json.dumps({number: commit_apart(fmu, int(number), Path(folder)) for number in numbers}))
