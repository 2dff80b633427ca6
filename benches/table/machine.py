"""Machine and date of a measurement."""

import datetime
import os
import pathlib
import platform
import subprocess


def _cpu():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def _said(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def describe():
    """In words; the load at the start of each row shows other processes."""
    return {
        "cpu": _cpu(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "rustc": _said("rustc", "--version"),
        "cc": _said("cc", "--version").splitlines()[0],
        "python": platform.python_version(),
    }


def today():
    return datetime.date.today().isoformat()


def load():
    """Runnable processes, mean of the last minute."""
    return round(os.getloadavg()[0], 2)
