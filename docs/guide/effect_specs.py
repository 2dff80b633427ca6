"""What the picture of each effect shows: two strengths, the signals that bring it out, and what its gap depends on."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Spec:
    """Left: `characteristic`, `step` or `long`; middle: a sine; right: what the effect adds to a record, over time or another quantity."""

    weak: dict  # parameter: value
    strong: dict
    left: str = "characteristic"
    left_size_deg: float = 2.0
    sine_hz: float = 4.0
    sine_deg: float = 2.0
    over: str = "time"  # the axis of the gap: time, command, position, rate, acceleration
    left_span_s: float = 0.12  # of a step


def limits(size):
    return {"min": -size, "max": size}


def rates(size):
    return {"up": size, "down": size}


SPECS = {
    "delay": Spec({"time": 0.005}, {"time": 0.02}, left="step", over="rate"),
    "command_limit": Spec(limits(1.6), {"min": -1.0, "max": 0.6}, over="command"),
    "command_rate_limit": Spec(rates(40.0), rates(20.0), left="step", over="rate", left_span_s=0.2),
    "command_dead_zone": Spec({"half_width": 0.1}, {"half_width": 0.4}, left_size_deg=1.0, over="command"),
    "command_backlash": Spec({"gap": 0.2}, {"gap": 0.8}, left_size_deg=1.0),
    "asymmetric_gain": Spec({"ratio": 0.9}, {"ratio": 0.6}, over="command"),
    "gain_drift": Spec({"rate": 0.05}, {"rate": 0.3}, left="long", over="time"),
    "dead_zone": Spec({"half_width": 0.1}, {"half_width": 0.4}, left_size_deg=1.0),
    "amplitude_gain": Spec({"cubic": 0.02}, {"cubic": 0.2}, over="position"),
    "hinge_load": Spec({"stiffness": 0.1}, {"stiffness": 0.1, "bias": 0.5}, over="position"),
    "coulomb_friction": Spec({"level": 0.1}, {"level": 0.4}, left_size_deg=1.0, over="rate"),
    "acceleration_limit": Spec({"value": 10000.0}, {"value": 5000.0}, left="step", over="acceleration"),
    "rate_limit": Spec(rates(40.0), rates(20.0), left="step", over="rate", left_span_s=0.2),
    "position_limit": Spec(limits(1.6), {"min": -1.0, "max": 0.6}, over="position"),
    "backlash": Spec({"gap": 0.2}, {"gap": 0.8}, left_size_deg=1.0),
    "structural_mode": Spec({"gain": 0.05}, {"gain": 0.3}, left="step", left_span_s=0.4, sine_hz=10.0, over="acceleration"),
    "sensor_lag": Spec({"time": 0.003}, {"time": 0.02}, left="step", over="rate"),
    "sensor_bias": Spec({"offset": 0.1}, {"offset": 0.2, "drift": 0.1}, left="long", over="time"),
    "chatter": Spec({"amplitude": 0.03}, {"amplitude": 0.15}, left="long", over="time"),
    "quantisation": Spec({"step": 0.05}, {"step": 0.3}, left_size_deg=1.0, over="position"),
}
