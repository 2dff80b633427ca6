"""Draws `src/pictures/EFFECT.svg` for the guide from the packaged FMU, stepped in fmpy: `python docs/guide/effect_pictures.py`.

Each picture: characteristic or response with the effect absent, weak and strong; a sine; what it adds to a record.
"""

import argparse
import io
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "fmpy-tests"))
sys.path.insert(0, str(HERE))

from actuator_fmu import DEFAULT_FMU, Actuator, unpacked  # noqa: E402
from effect_specs import SPECS  # noqa: E402

SET_NUMBER = 1  # te-early-unloaded
PERIOD_S = 0.005  # of the record, which is sampled as the report's
FINE_S = 0.001  # of the other panels
RECORD_S, LOWEST_HZ, HIGHEST_HZ, RECORD_PEAK_DEG, SEED = 1.5, 0.5, 12.0, 2.0, 208452
SLOW_PERIOD_S = 4.0  # of the triangle along which a characteristic is drawn: the servo follows to some 0.01 deg
LONG_S = 2.0
COLOURS = {"absent": "0.55", "weak": "#0072b2", "strong": "#d55e00"}  # Okabe and Ito: told apart with any colour vision
STYLE = {
    "font.size": 9, "axes.titlesize": 9.5, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e5e5e5", "grid.linewidth": 0.6, "axes.axisbelow": True, "legend.frameon": False, "legend.fontsize": 8,
    "svg.fonttype": "none", "svg.hashsalt": "guide", "font.family": "DejaVu Sans", "path.simplify": True,
}  # fmt: skip
UNITS = {"time": "s", "command": "deg", "position": "deg", "rate": "deg/s", "acceleration": "deg/s²"}


def draw(effect, actuator):
    """The picture, as SVG text."""
    spec = SPECS[effect]
    strengths = {"absent": {}, "weak": spec.weak, "strong": spec.strong}
    values = {name: {f"{effect}.{key}": value for key, value in strength.items()} for name, strength in strengths.items()}
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 3, figsize=(10.2, 3.0), constrained_layout=True)
        LEFT[spec.left](panels[0], actuator, spec, values)
        sine(panels[1], actuator, spec, values)
        record(panels[2], actuator, spec, values)
        panels[0].legend(handles=handles(strengths), loc="upper right" if spec.left == "long" else "best")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)
    return text.getvalue()


def handles(strengths):
    said = {name: ", ".join(f"{key} {value:g}" for key, value in strength.items()) or "absent" for name, strength in strengths.items()}
    return [plt.Line2D([], [], color=COLOURS[name], label=label) for name, label in said.items()]


def stepped(actuator, commands, period_s, values):
    """Positions at the sample times of a command that is held between them; the first before any step."""
    actuator.restart({"set_number": SET_NUMBER, "command": float(commands[0])} | values)
    return np.concatenate([[actuator["position"]], actuator.run(commands[:-1], period_s)])


def characteristic(panel, actuator, spec, values):
    """Position over command along a slow triangle, once round after the first quarter."""
    time = np.arange(0, 1.5 * SLOW_PERIOD_S, PERIOD_S)
    command = spec.left_size_deg * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * time / SLOW_PERIOD_S))
    once = time >= 0.25 * SLOW_PERIOD_S
    for name, own in values.items():
        panel.plot(command[once], stepped(actuator, command, PERIOD_S, own)[once], color=COLOURS[name], linewidth=1.3)
    panel.set(xlabel="command, deg", ylabel="position, deg", title="slow triangle")


def step(panel, actuator, spec, values):
    time = np.arange(0, spec.left_span_s, FINE_S)
    for name, own in values.items():
        positions = stepped(actuator, np.zeros(1), FINE_S, own)
        positions = np.concatenate([positions, actuator.run(np.full(len(time) - 1, spec.left_size_deg), FINE_S)])
        panel.plot(1e3 * time, positions, color=COLOURS[name], linewidth=1.3)
    panel.set(xlabel="time, ms", ylabel="position, deg", title=f"step of {spec.left_size_deg:g} deg")


def long(panel, actuator, spec, values):
    """Steps to and fro, for what changes with time."""
    time = np.arange(0, LONG_S, PERIOD_S)
    command = np.where((time % 1.0) < 0.5, 1.0, -1.0) * (time >= 0.1)
    for name, own in values.items():
        panel.plot(time, stepped(actuator, command, PERIOD_S, own), color=COLOURS[name], linewidth=1.1)
    panel.set(xlabel="time, s", ylabel="position, deg", title="steps of 1 deg", ylim=(-2.0, 3.2))  # room for the legend above


LEFT = {"characteristic": characteristic, "step": step, "long": long}


def sine(panel, actuator, spec, values):
    """The second and third period of a sine."""
    time = np.arange(0, 3 / spec.sine_hz, FINE_S)
    command = spec.sine_deg * np.sin(2 * np.pi * spec.sine_hz * time)
    shown = time >= 1 / spec.sine_hz
    for name, own in values.items():
        panel.plot(time[shown], stepped(actuator, command, FINE_S, own)[shown], color=COLOURS[name], linewidth=1.3)
    panel.set(xlabel="time, s", ylabel="position, deg", title=f"sine of {spec.sine_deg:g} deg, {spec.sine_hz:g} Hz")


def record(panel, actuator, spec, values):
    """The gap between a record with the effect and a model without, over what it depends on."""
    time, command = random_command()
    absent = stepped(actuator, command, PERIOD_S, values["absent"])
    rate = np.gradient(absent, PERIOD_S)
    axis = {"time": time, "command": command, "position": absent, "rate": rate, "acceleration": np.gradient(rate, PERIOD_S)}[spec.over]
    for name in ("strong", "weak"):
        gap = stepped(actuator, command, PERIOD_S, values[name]) - absent
        label = f"{name}: {np.sqrt(np.mean(gap**2)):.2g} deg rms"
        line = {"linewidth": 1.1} if spec.over == "time" else {"linestyle": "none", "marker": "o", "markersize": 1.6}
        panel.plot(axis, gap, color=COLOURS[name], label=label, **line)
    panel.set(xlabel=f"{spec.over}, {UNITS[spec.over]}", ylabel="gap, deg", title=f"record: gap over {spec.over}")
    low, high = panel.get_ylim()
    panel.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
    panel.legend(loc="upper right", markerscale=3)


def random_command():
    """0.5 to 12 Hz, peak 2 deg."""
    time = np.arange(0, RECORD_S, PERIOD_S)
    noise = np.random.default_rng(SEED)
    frequencies = np.arange(LOWEST_HZ, HIGHEST_HZ + 0.01, 1 / RECORD_S)
    phases = noise.uniform(0, 2 * np.pi, len(frequencies))
    command = np.sin(2 * np.pi * np.outer(time, frequencies) + phases).sum(axis=1)
    return time, RECORD_PEAK_DEG * command / np.abs(command).max()


def pictures(fmu):
    """{effect: SVG text}"""
    with unpacked(fmu) as package, Actuator(package) as actuator:
        return {effect: draw(effect, actuator) for effect in SPECS}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, default=DEFAULT_FMU)
    parser.add_argument("-o", "--output", type=Path, default=HERE / "src" / "pictures")
    options = parser.parse_args()
    if not options.fmu.is_file():
        print(f"No FMU at {options.fmu}. Build it with `cargo run -p fmu-build`, or name one: --fmu F.fmu", file=sys.stderr)
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    for effect, text in pictures(options.fmu).items():
        (options.output / f"{effect}.svg").write_text(text)
    print(f"{len(SPECS)} pictures in {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
