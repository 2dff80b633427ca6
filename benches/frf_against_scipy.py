"""What a frequency response costs over the length of a record, as a ratio to pandas and scipy measured in the same run.

    .venv/bin/python benches/frf_against_scipy.py [SAMPLES...]   # needs pandas and `cargo build --release`; another binary: ACTUATOR_PROGRAM

The records are random commands of 0.5 to 12 Hz at 200 samples/s, held, to a second-order servo with noise of 2 %, of 1e4 to 1e7 samples.
The peer reads the file with `pandas.read_csv` and takes H1 and coherence from `scipy.signal.csd` and `welch` (blocks of 2048 samples, 75 %
overlap); its imports are not counted, the start of the program is. The program reads the same file, checks and hashes it, and estimates by
local polynomials; the file it writes is in its time. Time is by the clock, the least of some rounds, in turn.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time as clock
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import signal

PROGRAM = os.environ.get("ACTUATOR_PROGRAM", Path(__file__).resolve().parent.parent / "target/release/actuator")
RATE_HZ = 200.0
BAND_HZ = (0.5, 12.0)
K, OMEGA, ZETA = 1.02, 165.0, 0.56
NOISE = 0.02
ROUNDS = {10_000: 7, 100_000: 5, 1_000_000: 3, 10_000_000: 2}


def record(samples, seed=1):
    """Time, command, position."""
    random = np.random.default_rng(seed)
    band = signal.butter(6, BAND_HZ, "bandpass", fs=RATE_HZ, output="sos")
    command = signal.sosfilt(band, random.standard_normal(samples)) * 6.0
    servo = signal.cont2discrete(([K * OMEGA**2], [1.0, 2.0 * ZETA * OMEGA, OMEGA**2]), 1.0 / RATE_HZ, "zoh")
    position = signal.lfilter(servo[0].ravel(), servo[1], command)
    position += NOISE * position.std() * random.standard_normal(samples)
    return np.arange(samples) / RATE_HZ, command, position


def true_response(frequency_hz):
    s = 2j * np.pi * frequency_hz
    return K * OMEGA**2 / (s * s + 2.0 * ZETA * OMEGA * s + OMEGA**2)


def peer(path):
    frame = pd.read_csv(path)
    command, position = frame["command"].to_numpy(), frame["position"].to_numpy()
    blocks = {"fs": RATE_HZ, "nperseg": 2048, "noverlap": 1536}
    frequency, cross = signal.csd(command, position, **blocks)
    _, command_power = signal.welch(command, **blocks)
    _, position_power = signal.welch(position, **blocks)
    return frequency, cross / command_power, np.abs(cross) ** 2 / (command_power * position_power)


def product(path, output):
    return [str(PROGRAM), "frf", str(path), "-o", str(output), "--force"]


def run(command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


# A process counts the memory of the one that starts it, so that a small one has to.
MEMORY = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def memory_mb(command):
    """Greatest memory of a program [MB]."""
    answer = subprocess.run([sys.executable, "-c", MEMORY, *command], check=True, capture_output=True, text=True)
    return int(answer.stdout) / 1024.0


def least(rounds, *runs):
    """Least time [s] of each, in turn."""
    times = [[] for _ in runs]
    for _ in range(rounds):
        for each, run in zip(times, runs, strict=True):
            start = clock.perf_counter()
            run()
            each.append(clock.perf_counter() - start)
    return [min(each) for each in times]


def main():
    lengths = [int(float(text)) for text in sys.argv[1:]] or list(ROUNDS)
    print("samples    file, MB  actuator, s  per decade  pandas + scipy, s  ratio  memory, MB  lines  greatest error / its std")
    before = None
    with tempfile.TemporaryDirectory() as folder:
        path, output = Path(folder) / "record.csv", Path(folder) / "frf.csv"
        for samples in lengths:
            time, command, position = record(samples)
            pd.DataFrame({"time": time, "command": command, "position": position}).to_csv(path, index=False)
            del time, command, position
            command = product(path, output)
            memory = memory_mb(command)
            own, other = least(ROUNDS.get(samples, 1), lambda: run(command), lambda: peer(path))
            decade = "" if before is None else f"{own / before:.1f}"
            before = own
            frf = pd.read_csv(output)
            frf = frf[(frf.frequency_hz > 1.0) & (frf.frequency_hz < 11.0)]
            off = np.abs(frf.magnitude - np.abs(true_response(frf.frequency_hz.to_numpy())))
            print(
                f"{samples:<10} {path.stat().st_size / 1e6:8.1f}  {own:11.3f}  {decade:>10}  {other:17.3f}  {own / other:5.2f}  {memory:10.0f}"
                f"  {len(frf):5}  {off.max():.5f} / {frf.magnitude_std_error.mean():.5f}"
            )
            sys.stdout.flush()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"memory of this script, pandas and scipy included: {peak:.0f} MB")


if __name__ == "__main__":
    main()
