"""Sensors, loggers and commands of the eight drives behave as named."""

from dataclasses import replace

import numpy as np
import pytest

from . import drive_cases, drive_commands, drive_sensors
from .drive_rigs import STEP_S
from .drive_sensors import Sensor

RATE_HZ = 250
PLAIN = Sensor("encoder", RATE_HZ, 0.0, {"kind": "white"}, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0, 1.0, 0.0, 0.0, 0.0, 10)


def ramp(seconds=8.0):
    """A degree per second, at the ends of the steps."""
    return STEP_S * np.arange(1, round(seconds / STEP_S) + 1)


def sensed(rng, seen, effect=None, **changes):
    count = round(len(seen) * STEP_S * RATE_HZ)
    return drive_sensors.record(rng, replace(PLAIN, **changes), np.arange(count, dtype=float), seen, STEP_S, effect)


def test_a_plain_sensor_shows_what_is_there(rng):
    columns = sensed(rng, ramp())
    assert columns["position"] == pytest.approx(columns["time"], abs=1e-9) and list(columns["command"]) == list(range(2000))


@pytest.mark.parametrize("kind, order", [("potentiometer", 1), ("lvdt", 2), ("capacitive", 1)])
def test_a_filter_is_late_by_the_group_delay_of_its_order(kind, order, rng):
    """Butterworth at low frequencies: 1/w for order 1, sqrt(2)/w for order 2."""
    columns = sensed(rng, ramp(), kind=kind, filter_hz=30.0)
    late = (columns["time"] - columns["position"])[1000:]
    assert late == pytest.approx(np.sqrt(order) / (2.0 * np.pi * 30.0), rel=0.02)


@pytest.mark.parametrize("per_turn", [1.0, 2.0])
def test_the_error_of_a_resolver_comes_once_or_twice_a_turn(per_turn, rng):
    seen = 90.0 * ramp()  # two turns
    columns = sensed(rng, seen, error=0.1, error_per_deg=per_turn * np.pi / 180.0)
    error = columns["position"] - 90.0 * columns["time"]
    lines = np.abs(np.fft.rfft(error - error.mean()))
    assert np.argmax(lines) == 2.0 * per_turn and np.ptp(error) == pytest.approx(0.2, rel=0.01)


def test_a_wiper_is_noisier_while_it_moves(rng):
    seen = np.where(ramp() < 4.0, 0.0, ramp() - 4.0)
    position = sensed(rng, seen, kind="potentiometer", noise_rms=0.01)["position"]
    noise = position - np.interp(np.arange(2000) / RATE_HZ, ramp(), seen, left=0.0)
    assert noise[1050:].std() / noise[:950].std() == pytest.approx(drive_sensors.WIPER, rel=0.15)


def test_a_clock_of_its_own_jitters_as_written_and_loses_rows(rng):
    columns = sensed(rng, ramp(), clock=1.0003, start_s=30.5, jitter=0.05, lost=0.02)
    own = (columns["time"] - 30.5) / 1.0003
    assert columns["position"] == pytest.approx(own, abs=1e-6) and 1920 < len(own) < 1990
    off = RATE_HZ * own - np.round(RATE_HZ * own)
    assert off.std() == pytest.approx(0.05, rel=0.1)
    assert np.abs(columns["command"] - RATE_HZ * own).max() < 1.3


def test_lost_rows_are_made_up_from_their_neighbours(rng):
    sensor = replace(PLAIN, lost=0.05)
    even = drive_cases.evenly(drive_sensors.record(rng, sensor, np.arange(2000.0), ramp(), STEP_S), sensor)
    assert len(even["time"]) == 2000 and even["position"] == pytest.approx(even["time"], abs=1e-9)
    assert np.mean(even["command"] == np.arange(2000.0)) == pytest.approx(0.95, abs=0.02) and np.abs(even["command"] - np.arange(2000.0)).max() < 5


@pytest.mark.parametrize("late, first", [(0, [0.0, 1.0]), (1, [0.0, 0.0]), (-1, [1.0, 2.0])])
def test_a_command_is_logged_ahead_of_the_bus_or_behind_it(late, first, rng):
    assert list(sensed(rng, ramp(), logged_late=late)["command"][:2]) == first


def test_sessions_differ_in_offset_and_gain(rng):
    ends = [sensed(rng, ramp(), session_gain=0.01, session_offset=0.2)["position"][[0, -1]] for _ in range(200)]
    assert np.std([first for first, _ in ends]) == pytest.approx(0.2, rel=0.2)
    assert np.std([last - first for first, last in ends]) == pytest.approx(0.01 * 8.0, rel=0.2)


def test_effects_of_the_sensor(rng):
    for effect, expected in (
        (("gain_drift", {"rate": 0.02}), lambda t: t * (1.0 + 0.02 * t)), (("sensor_bias", {"drift": -0.3}), lambda t: 0.7 * t),
        (("sensor_lag", {"time": 0.1}), lambda t: t - 0.1 * (1.0 - np.exp(-t / 0.1))), (("quantisation", {"step": 0.5}), lambda t: 0.5 * np.round(t / 0.5)),
    ):  # fmt: skip
        columns = sensed(rng, ramp() + 1e-5, effect)
        assert columns["position"][1:] == pytest.approx(expected(columns["time"][1:] + 1e-5), abs=2e-4), effect


def test_what_a_sensor_has_is_inherent():
    assert drive_sensors.inherent(PLAIN, False) == () and drive_sensors.inherent(PLAIN, True) == ("delay",)
    spoilt = replace(PLAIN, step=0.1, session_offset=0.1, filter_hz=50.0)
    assert set(drive_sensors.inherent(spoilt, False)) == {"quantisation", "sensor_bias", "sensor_lag", "delay"}
    assert drive_sensors.inherent(replace(PLAIN, logged_late=-1), False) == ("delay",)


@pytest.mark.parametrize("kind", drive_commands.COMMANDS)
def test_commands_begin_at_rest_and_are_of_size_one(kind, rng):
    for rate, bandwidth in ((50, 1.2), (1000, 9.0)):
        wave = drive_commands.command(rng, kind, np.arange(12 * rate) / rate, bandwidth)
        assert wave[0] == 0.0 and np.abs(wave).max() == pytest.approx(1.0)
        slow = np.abs(np.fft.rfft(wave - wave.mean()))[: int(12 * 4.0 * bandwidth)] ** 2
        assert slow.sum() > 0.9 * (np.abs(np.fft.rfft(wave - wave.mean())) ** 2).sum()
