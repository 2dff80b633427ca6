"""The program `actuator`: where it and its FMU lie, how it is called, what its refusals become."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import nullcontext
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any, Optional, Sequence

DISTRIBUTION = "actuator-fmu"
FMU = "BactActuator.fmu"
SHOWN_AFTER_S = 1.0  # work that is over sooner shows no progress
INTERVAL_S = 0.1
PATIENCE_S = 5.0


class ActuatorError(ValueError):
    """Bad usage or input, in the words of the program: what was found, what is allowed, what to do."""


def version() -> str:
    """Version of this package, which is that of the program."""
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
    """What the program prints; its refusal as an exception. Work of more than a second shows `words` and the time it has taken, where
    `tqdm` is installed and standard error is a terminal or a notebook."""
    command = [program_path(), *(str(argument) for argument in arguments)]
    environment = {"ACTUATOR_FMU": fmu_path(), **os.environ}
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, encoding="utf-8",
    )  # fmt: skip
    try:
        with _progress(words) as bar:
            while True:
                try:
                    said, refused = process.communicate(timeout=INTERVAL_S if bar else None)
                    break
                except subprocess.TimeoutExpired:
                    bar.refresh()
    except BaseException:
        # It finishes the file that it is writing, and clears away what it does not need any more.
        process.terminate()
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        raise
    if process.returncode == 2:
        raise ActuatorError(refused.strip().removeprefix("actuator: "))
    if process.returncode != 0:
        raise RuntimeError(f"actuator ended with {process.returncode}: {refused.strip()}")
    return said


def run_json(arguments: Sequence[Any], folder: Optional[Path] = None, words: str = "") -> Any:
    """As `run`, with `--json`."""
    return json.loads(run([*arguments, "--json"], folder, words))


def _progress(words: str) -> Any:
    """A bar of elapsed time, or nothing."""
    seen = sys.stderr is not None and sys.stderr.isatty() or "ipykernel" in sys.modules
    if not (words and seen):
        return nullcontext()
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return nullcontext()
    return tqdm(desc=words, bar_format="{desc}, {elapsed}", delay=SHOWN_AFTER_S, leave=False)
