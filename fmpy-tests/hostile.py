"""A host that makes mistakes: `python hostile.py UNPACKED_FMU NUMBER` makes one of them and prints what came back, as JSON.

One process per mistake, so that a crash is seen as what it is. `test_robustness.py` runs them all. Each mistake says which
statuses are right and which words the log line must hold, so that its reader knows what was wrong.
"""

import faulthandler
import json
import sys

import mistakes_at_random  # noqa: F401  (fills the list)
import mistakes_in_calls  # noqa: F401
import mistakes_in_exchange  # noqa: F401
import mistakes_with_effects  # noqa: F401
import mistakes_with_objects  # noqa: F401
from hostile_host import Host
from mistakes import MISTAKES

if __name__ == "__main__":
    faulthandler.enable()
    host = Host(sys.argv[1])
    status = MISTAKES[int(sys.argv[2])].make(host)
    print(json.dumps({"status": status, "log": host.log}), flush=True)
