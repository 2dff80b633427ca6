"""No mistake of a host crashes it: every mistake gets an FMI status, and a log line with the reason.

The mistakes are in `mistakes_*.py`; `hostile.py` makes each in a separate process, through bare C calls.
"""

import json
import re
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path
from types import SimpleNamespace

import pytest

import hostile  # noqa: F401  (fills the list)
from mistakes import MISTAKES, REFUSED, WRONG

SCRIPT = Path(__file__).with_name("hostile.py")


def plain(text):
    """`currentCommunicationPoint` and "the communication point" are the same words."""
    return re.sub(r"\s|(?<=[a-z])-(?=[a-z])", "", text.lower())


def commit(fmu, numbers, folder):
    """Each in a separate process: number -> how it ended and its output."""
    command = [sys.executable, "-B", SCRIPT, fmu, folder, *map(str, numbers)]
    codes = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return {
        number: SimpleNamespace(
            returncode=codes[str(number)], stdout=(folder / f"{number}.out").read_text(), stderr=(folder / f"{number}.err").read_text()
        )
        for number in numbers
    }


@pytest.fixture(scope="module")
def outcomes(package, tmp_path_factory):
    """All processes, as many at a time as there are processors; each test then evaluates its own."""
    folder, at_a_time = tmp_path_factory.mktemp("mistakes"), cpu_count()
    shares = [range(first, len(MISTAKES), at_a_time) for first in range(at_a_time)]
    with ThreadPoolExecutor(at_a_time) as pool:
        return dict(item for share in pool.map(lambda numbers: commit(package.directory, numbers, folder), shares) for item in share.items())


@pytest.mark.parametrize("number", range(len(MISTAKES)), ids=[m.what.replace("::", ":") for m in MISTAKES])
def test_a_mistake_gets_a_status_and_a_word(outcomes, number):
    mistake, outcome = MISTAKES[number], outcomes[number]
    assert outcome.returncode != -signal.SIGALRM, f"{mistake.what}: hangs"
    assert outcome.returncode == 0, f"{mistake.what}: process ended with {outcome.returncode}\n{outcome.stderr}"
    answer = json.loads(outcome.stdout.splitlines()[-1])
    messages = "\n".join(line[2] for line in answer["log"])
    assert answer["status"] in mistake.statuses, f"{mistake.what}: status {answer['status']}, log: {messages}"
    assert "UNESCAPED PERCENT SIGN" not in messages
    for alarm in ("panic", "internal error"):
        assert alarm not in (messages + outcome.stderr).lower(), f"{mistake.what}: {messages}{outcome.stderr}"
    for word in mistake.words:
        assert plain(word) in plain(messages), f"{mistake.what}: {word!r} is missing in the log: {messages!r}"


def test_every_refusal_is_explained():
    """A refusal without a message would not be understood: the list above requires words wherever there is a status."""
    assert not [m.what for m in MISTAKES if m.statuses in (REFUSED, WRONG) and not m.words]
