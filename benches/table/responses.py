"""Cost of a frequency response over the length of a record, against pandas and scipy.

The records are random commands of 0.5 to 12 Hz at 200 samples/s, held, to a second-order servo with noise of 2 %, of 1e4 to 1e7 samples.
The peer reads the file with `pandas.read_csv` and computes H1 and coherence with `scipy.signal.csd` and `welch` (blocks of 2048 samples, 75
% overlap); its imports are not counted, the start of the program is. The program reads the same file, checks and hashes it, and estimates
by local polynomials; writing the result file is included.
"""

import numpy as np
import pandas as pd
from scipy import signal

from .measure import Line, Spread, agree, in_turn, memory_and_processor

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


def file(context, samples):
    """A record of this length; kept, since the longest takes a minute to write."""
    path = context.folder / f"record-{samples}.csv"
    if not path.exists():
        time, command, position = record(samples)
        written = path.with_suffix(".part")
        pd.DataFrame({"time": time, "command": command, "position": position}).to_csv(written, index=False)
        written.rename(path)
    return path


def errors(frequency, response):
    """Maximum error of the magnitude between 1 and 11 Hz, relative to k."""
    inside = (frequency > 1.0) & (frequency < 11.0)
    return np.abs(np.abs(response[inside]) - np.abs(true_response(frequency[inside]))).max() / K


def measure(context):
    lines, output = [], context.folder / "frf.csv"
    for samples, rounds in list(ROUNDS.items())[: 1 if context.quick else None]:
        path = file(context, samples)
        command = ["frf", path, "-o", output, "--force"]
        own, theirs = in_turn(context.rounds(rounds), lambda: context.actuator(*command), lambda: peer(path))
        frf = pd.read_csv(output)
        frequency, response, _ = peer(path)
        off = errors(frf.frequency_hz.to_numpy(), frf.magnitude.to_numpy()), errors(frequency, response)
        # Two estimates with different variance: each is compared with the truth.
        said = f"error of the magnitude {off[0]:.1g}, theirs {off[1]:.1g}"
        agree("magnitude", max(off), 0.1)
        what = f"{samples:.0e} samples, {path.stat().st_size / 1e6:.1f} MB".replace("e+0", "e")
        lines.append(Line(f"frf.{samples:.0e}", what, "s", own, "pandas, csd, welch", theirs, said))
        peak, _ = memory_and_processor([str(context.program), *map(str, command)])
        lines.append(Line("frf.memory", f"memory for {samples:.0e} samples".replace("e+0", "e"), "MB", Spread.of([peak])))
    return lines, []
