"""The program `actuator`: location of it and its FMU, calls, and conversion of its refusals to exceptions."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from threading import Thread
from typing import Any, List, Optional, Sequence

DISTRIBUTION = "actuator-fmu"
FMU = "BactActuator.fmu"
SHOWN_AFTER_S = 1.0  # shorter work shows no progress
PROGRESS = '"progress":'  # in the program's lines of progress, which are objects
PATIENCE_S = 5.0


class ActuatorError(ValueError):
    """Bad usage or input, in the words of the program: what was found, what is allowed, what to do."""


def version() -> str:
    """Version of this package, the same as that of the program."""
    return metadata.version(DISTRIBUTION)


@lru_cache(maxsize=None)
def _installed(name: str) -> str:
    for file in metadata.files(DISTRIBUTION) or []:
        if file.name == name:
            return str(Path(file.locate()).resolve())
    raise ActuatorError(f"{name}: not among the files of the installed package {DISTRIBUTION}; install its wheel again")


def program_path() -> str:
    """The program `actuator` of this package."""
    return _installed("actuator.exe" if os.name == "nt" else "actuator")


def fmu_path() -> str:
    """`BactActuator.fmu`, the 17 tabulated actuators as an FMI 2.0 unit for co-simulation and model exchange."""
    return _installed(FMU)


def run(arguments: Sequence[Any], folder: Optional[Path] = None, words: str = "") -> str:
    """The program's output; its refusal as an exception. Work of more than a second shows `words`, the elapsed time and the program's
    estimate of the remaining time, if `tqdm` is installed and standard error is a terminal or a notebook."""
    command = [program_path(), *(str(argument) for argument in arguments)]
    bar = _progress(words)
    environment = {"ACTUATOR_FMU": fmu_path(), **os.environ, **({} if bar is None else {"ACTUATOR_PROGRESS": "lines"})}
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, encoding="utf-8",
    )  # fmt: skip
    refusal: List[str] = []
    reader = Thread(target=_read_words, args=(process.stderr, bar, refusal), daemon=True)
    try:
        reader.start()
        assert process.stdout is not None  # it is a pipe
        said = process.stdout.read()
        process.wait()
    except BaseException:
        # It finishes the file being written, and removes temporary ones.
        process.terminate()
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        raise
    finally:
        reader.join(PATIENCE_S)
        if bar is not None:
            bar.close()
        if process.stdout is not None:
            process.stdout.close()
    refused = "".join(refusal)
    if process.returncode == 2:
        raise ActuatorError(refused.strip().removeprefix("actuator: "))
    if process.returncode != 0:
        raise RuntimeError(f"actuator ended with {process.returncode}: {refused.strip()}")
    return said


def _read_words(lines: Any, bar: Any, refusal: List[str]) -> None:
    """Lines of progress go to the bar, all others are kept."""
    for line in lines:
        if bar is None or not (line.startswith("{") and PROGRESS in line):
            refusal.append(line)
            continue
        now = json.loads(line)
        left = now["left_s"]
        bar.n = 0.0 if left is None else round(now["elapsed_s"] / (now["elapsed_s"] + left), 3)
        bar.set_description_str(now["progress"], refresh=False)
        bar.set_postfix_str("" if left is None else f"about {left:.0f} s left", refresh=False)
        bar.refresh()


def run_json(arguments: Sequence[Any], folder: Optional[Path] = None, words: str = "") -> Any:
    """As `run`, with `--json`."""
    return json.loads(run([*arguments, "--json"], folder, words))


def _progress(words: str) -> Any:
    """A bar of the completed work and the remaining time; None if nobody would see it."""
    seen = sys.stderr is not None and sys.stderr.isatty() or "ipykernel" in sys.modules
    if not (words and seen):
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(desc=words, total=1.0, bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}{postfix}", delay=SHOWN_AFTER_S, leave=False)
