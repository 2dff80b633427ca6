"""Nothing a host does wrong crashes it: every mistake gets an FMI status, and a log line that says what was wrong.

The mistakes are in `mistakes_*.py`; `hostile.py` makes each in a process of its own, through bare C calls.
"""

import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

import pytest

import hostile  # noqa: F401  (fills the list)
from mistakes import MISTAKES, REFUSED, WRONG

SCRIPT = Path(__file__).with_name("hostile.py")
PATIENCE_S = 30  # a hang is a failure as well


def plain(text):
    """`currentCommunicationPoint` and "the communication point" are the same words."""
    return re.sub(r"\s|(?<=[a-z])-(?=[a-z])", "", text.lower())


def commit(package, number):
    try:
        return subprocess.run(
            [sys.executable, "-B", str(SCRIPT), str(package.directory), str(number)],
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
    except subprocess.TimeoutExpired as hang:
        return hang


@pytest.fixture(scope="module")
def outcomes(package):
    """All processes, as many at a time as there are processors; each test then looks at its own."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        return list(pool.map(lambda number: commit(package, number), range(len(MISTAKES))))


@pytest.mark.parametrize("number", range(len(MISTAKES)), ids=[m.what.replace("::", ":") for m in MISTAKES])
def test_a_mistake_gets_a_status_and_a_word(outcomes, number):
    mistake, outcome = MISTAKES[number], outcomes[number]
    assert not isinstance(outcome, subprocess.TimeoutExpired), f"{mistake.what}: hangs"
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
    """A mistake that is refused without a word would be a riddle: the list above asks for words wherever there is a status."""
    assert not [m.what for m in MISTAKES if m.statuses in (REFUSED, WRONG) and not m.words]
