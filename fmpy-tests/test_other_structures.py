"""Actuators whose linear structure is not that of their model, simulated by scipy: verdicts of `actuator diagnose` on a delay and a drift in them,
and on a model whose poles are real and far apart.

A speed loop with a lag, integral action and a position loop around it, and a filter in front of the recorder: of fifth order. The model has three
poles, by least squares on a healthy record.
"""

import numpy as np
import pytest
from scipy import optimize, signal

from hidden import product

pytestmark = product.needs_program()

RATE_HZ, DURATION_S, NOISE = 250.0, 16.0, 0.004
AMPLITUDE = 4.0  # deg


def servo():
    """Position by command: a position loop of 14 1/s around a speed loop with a lag of 4 ms and integral action."""
    speed = signal.TransferFunction([70.0, 700.0], [0.004, 1.0, 70.0, 700.0])
    numerator, denominator = 14.0 * speed.num, np.polymul(speed.den, [1.0, 0.0])
    loop = signal.TransferFunction(numerator, np.polyadd(denominator, numerator))
    return signal.TransferFunction(loop.num, np.polymul(loop.den, [1.0 / 400.0, 1.0]))


def commands():
    """Steps, band-limited noise, a sweep: the recorded columns, by name."""
    random = np.random.default_rng(3)
    time = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    steps = np.repeat(random.uniform(-1.0, 1.0, int(DURATION_S)), int(RATE_HZ))
    band = signal.butter(4, (0.2, 5.0), "bandpass", fs=RATE_HZ, output="sos")
    noise = signal.sosfilt(band, random.standard_normal(len(time)))
    sweep = np.sin(2.0 * np.pi * (0.1 * time + 0.5 * 5.0 / DURATION_S * time**2))
    quiet = time < 0.5
    return time, {
        name: np.where(quiet, 0.0, AMPLITUDE * values / np.abs(values).max())
        for name, values in {"steps": steps, "noise": noise, "sweep": sweep}.items()
    }


def response(plant, time, command, delay_s=0.0):
    """Response to a held command: exact on a grid fine enough to contain the delay."""
    fine = 8
    shift = round(delay_s * RATE_HZ * fine)
    held = np.concatenate([np.zeros(shift), np.repeat(command, fine)])[: len(command) * fine]
    sampled = plant.to_ss().to_discrete(1.0 / (RATE_HZ * fine), method="zoh")
    return signal.dlsim(sampled, held)[1][::fine, 0]


def fitted(command, position):
    """k, omega, zeta, p by least squares."""

    def residual(x):
        k, omega, zeta, p = np.exp(x)
        plant = signal.TransferFunction([k], np.polymul([1.0 / omega**2, 2.0 * zeta / omega, 1.0], [1.0 / p, 1.0]))
        sampled = plant.to_ss().to_discrete(1.0 / RATE_HZ, method="zoh")
        return signal.dlsim(sampled, command)[1][:, 0] - position

    return np.exp(optimize.least_squares(residual, np.log([1.0, 20.0, 0.8, 60.0])).x)


def write(folder, k, omega, zeta, p):
    (folder / "model.toml").write_text(
        f'[model]\nname = "servo"\n[base]\norder = 3\nk = {{ value = {k}, unit = "deg/deg" }}\np = {{ value = {p}, unit = "1/s" }}\n'
        f'omega = {{ value = {omega}, unit = "rad/s" }}\nzeta = {{ value = {zeta}, unit = "1" }}\n'
    )


def record(folder, name, time, command, position):
    random = np.random.default_rng(len(name))
    columns = np.column_stack([time, command, position + NOISE * random.standard_normal(len(time))])
    np.savetxt(folder / f"{name}.csv", columns, "%.6f", ",", header="time,command,position", comments="")


def diagnosed(folder):
    arguments = ("--model", "model.toml", "--fit", "steps.csv", "noise.csv", "--check", "sweep.csv")
    return product.diagnose(product.program(), folder, arguments=arguments)[0]


def only(diagnosis):
    (effect,) = (effect for effect in diagnosis["effects"] if effect["name"] != "sensor_bias")
    return effect


@pytest.fixture(scope="module")
def healthy():
    time, driven = commands()
    return time, driven, {name: response(servo(), time, command) for name, command in driven.items()}


@pytest.mark.slow
def test_a_healthy_actuator_of_another_structure_gets_no_name(healthy, tmp_path):
    time, driven, positions = healthy
    write(tmp_path, *fitted(driven["noise"], positions["noise"]))
    for name, command in driven.items():
        record(tmp_path, name, time, command, positions[name])
    assert diagnosed(tmp_path)["verdict"] in ("unexplained", "nothing_missing")


@pytest.mark.slow
def test_a_delay_leads(healthy, tmp_path):
    time, driven, positions = healthy
    delay_s = 0.024
    write(tmp_path, *fitted(driven["noise"], positions["noise"]))
    for name, command in driven.items():
        record(tmp_path, name, time, command, response(servo(), time, command, delay_s))
    diagnosis = diagnosed(tmp_path)
    assert diagnosis["verdict"] in ("leading", "named") and only(diagnosis)["name"] == "delay"
    assert only(diagnosis)["parameters"]["time"]["value"] == pytest.approx(delay_s, rel=0.2)
    assert diagnosis["gap"]["after"]["check_rms"] < 0.5 * diagnosis["gap"]["before"]["check_rms"]


@pytest.mark.slow
def test_a_drift_is_told_on_stretches_of_long_records(healthy, tmp_path):
    """Records of so many samples that the search uses a stretch of each, which keeps its start time within the record."""
    time, driven, positions = healthy
    rate = -0.008
    write(tmp_path, *fitted(driven["noise"], positions["noise"]))
    fine = np.arange(0.0, time[-1], 1.0 / (3.0 * RATE_HZ))
    for name, command in driven.items():
        position = positions[name] * (1.0 + rate * time)
        held = command[np.minimum((fine * RATE_HZ).astype(int), len(command) - 1)]
        record(tmp_path, name, fine, held, np.interp(fine, time, position))
    diagnosis = diagnosed(tmp_path)
    assert diagnosis["verdict"] in ("leading", "named") and only(diagnosis)["name"] == "gain_drift"
    assert only(diagnosis)["parameters"]["rate"]["value"] == pytest.approx(rate, rel=0.2)


@pytest.mark.slow
def test_the_order_of_real_poles_in_a_model_does_not_matter(healthy, tmp_path):
    """A fit to an actuator of first order may end with a pole a thousand times as fast as the others, in the pair or as p."""
    time, driven, positions = healthy
    slow, middle, fast = 15.0, 60.0, 30_000.0

    def found(pair, alone):
        folder, omega = tmp_path / str(alone), np.sqrt(pair[0] * pair[1])
        folder.mkdir()
        write(folder, 1.0, omega, 0.5 * sum(pair) / omega, alone)
        for name, command in driven.items():
            record(folder, name, time, command, positions[name] * (1.0 - 0.006 * time))
        return diagnosed(folder)

    one, other = found((slow, middle), fast), found((slow, fast), middle)
    assert one["verdict"] == other["verdict"]
    assert [effect["name"] for effect in one["effects"]] == [effect["name"] for effect in other["effects"]]
    for key in ("before", "after"):
        assert one["gap"][key]["check_rms"] == pytest.approx(other["gap"][key]["check_rms"], rel=0.02)
