"""Reference simulator of a servo-actuator with nonlinear effects: the truth against which the product is tested.

It shares only the equations with the product. Three parts follow each other without feedback between them:

    command side  delay, clamp, rate limit, dead zone, play, gains      breakpoints in closed form  command_side.py
                  k, drift, pole p                                      x(t) in closed form         servo_target.py
    loop          limits, dead zone, stops, friction, cubic, hinge load collocation with events     loop.py
    output side   play, structural mode, lag                            exact play, collocation     output_side.py
                  bias, chatter, quantisation                           here

Accuracy: better than 1e-11 of the peak position against closed forms, 1e-13 where the closed form resolves it,
and 1e-13 between step sizes for random effects together. Effects that amplify errors in the plant do so here, too:
a lightly damped dead zone under a random command is chaotic, and then only its first part can be compared.
Cost: about 1 s for 1000 held samples; cubic or structural mode double it.

Where the equations leave a choice:
- Sample i is the state on arrival at time[i], before command[i] takes over; `rate_after` and `saturated_after` are
  those after it (they differ when a held command jumps with order 2, or when a failure begins). Before time[0]: rest.
- A linear command still jumps at time[0], from the rest command to command[0]; after the last sample it is held.
- The rest command is the one that gives initial_position / k behind the command side, so that the drive is at rest; if
  there is none, the case is refused.
- t in gain_drift, sensor_bias and chatter, and the delay's rest, count from time[0].
- load follows the command's hold or linear interpolation; failure is always held.
- initial_position outside the stops is moved to the stop; the servo target still starts at initial_position.
- At rest on a stop at the start, the stop is active; on a stop it stays active while |F| is within friction.
- Neutral limits of the loop (1e9) are taken literally, also as the target of a hardover without position_limit.
- Friction counts in the rate limit: v leaves `up` when F < omega^2 level.
- saturated: an acceleration limit counts when |omega^2 error| > value, also while friction holds the drive or a stop
  does; it does not count when passive. Nothing counts while stuck.
- command_rate_limit of 1e9 and more is no limit at all: a jump stays a jump.
"""

import numpy as np

from .command_side import holding, sampled, shape
from .loop import HARDOVER_NEGATIVE, HARDOVER_POSITIVE, Loop
from .output_side import OutputSide
from .servo_target import intervals

# A limit that acts for less than this is due to rounding of the instants of two events.
SHORTEST_S = 1e-13

FAILURES = ("none", "passive", "stuck", "hardover_positive", "hardover_negative")

# Neutral values of the contract, in the order of the chain.
NEUTRAL = {
    "delay": {"time": 0.0},
    "command_limit": {"min": -1e9, "max": 1e9},
    "command_rate_limit": {"up": 1e9, "down": 1e9},
    "command_dead_zone": {"half_width": 0.0},
    "command_backlash": {"gap": 0.0},
    "asymmetric_gain": {"ratio": 1.0},
    "gain_drift": {"rate": 0.0},
    "dead_zone": {"half_width": 0.0},
    "amplitude_gain": {"cubic": 0.0},
    "hinge_load": {"stiffness": 0.0, "bias": 0.0},
    "coulomb_friction": {"level": 0.0},
    "acceleration_limit": {"value": 1e9},
    "rate_limit": {"up": 1e9, "down": 1e9},
    "position_limit": {"min": -1e9, "max": 1e9},
    "backlash": {"gap": 0.0},
    "structural_mode": {"frequency": 20.0, "damping": 0.02, "gain": 0.0},
    "sensor_lag": {"time": 0.0},
    "sensor_bias": {"offset": 0.0, "drift": 0.0},
    "chatter": {"amplitude": 0.0, "frequency": 15.0, "phase": 0.0},
    "quantisation": {"step": 0.0},
}
NOT_NEGATIVE = {("delay", "time"), ("command_dead_zone", "half_width"), ("command_backlash", "gap"),
                ("dead_zone", "half_width"), ("coulomb_friction", "level"), ("backlash", "gap"),
                ("sensor_lag", "time"), ("quantisation", "step"), ("structural_mode", "damping")}
POSITIVE = {("command_rate_limit", "up"), ("command_rate_limit", "down"), ("acceleration_limit", "value"),
            ("rate_limit", "up"), ("rate_limit", "down"), ("structural_mode", "frequency")}


def simulate(base, effects, time, command, load=None, failure=None, hold=True, order=3, initial_position=0.0,
             refinement=1.0):
    """Simulate one record.

    base: (k, p, omega, zeta) or a dict of these; effects: {"rate_limit": {"up": 100.0}, ...}, others are
    neutral; time [s] strictly increasing; command, load [deg] at these times; failure: names or 0-4 at these times.
    `refinement` divides all step sizes, to check convergence.

    Returns arrays at `time`: position, deflection [deg], rate [deg/s], saturated; and for tests near switchings
    drive [deg] (d itself), unquantised [deg] (position before rounding), rate_after, saturated_after (see above);
    saturated_within: at any time since the sample before.
    """
    base = _checked_base(base)
    effects = complete(effects or {})
    time = np.asarray(time, float) - float(time[0])
    if len(time) < 2 or not np.all(np.diff(time) > 0.0):
        raise ValueError("time must be at least two strictly increasing instants")
    if order not in (2, 3):
        raise ValueError(f"order {order}: must be 2 or 3")
    command = _signal("command", command, time)
    load = _signal("load", np.zeros(len(time)) if load is None else load, time)
    failure = _failures(failure, len(time))

    # One additional step shows the state after the last sample.
    end = time[-1] + (time[-1] - time[-2])
    shaped = shape(sampled(time, command, hold, holding(initial_position / base[0], effects), end), effects)
    loads = sampled(time, load, hold, 0.0, end)
    drift = effects["gain_drift"]["rate"]
    scale = _scale(base, effects, shaped, load, failure, initial_position, drift)
    loop = Loop(base, effects, initial_position, scale, refinement)
    output = OutputSide(effects, loop.d, refinement)

    names = ("drive", "rate", "rate_after", "deflection", "unquantised")
    result = {name: np.zeros(len(time)) for name in names}
    result |= {name: np.zeros(len(time), bool) for name in ("saturated", "saturated_after", "saturated_within")}

    def record(i):
        result["drive"][i], result["rate"][i], result["saturated"][i] = loop.d, loop.v, loop.saturated
        result["deflection"][i], result["unquantised"][i] = output.deflection, output.measured
        result["saturated_within"][i] = within

    within = loop.saturated
    record(0)
    sample, within = 0, False
    for interval in intervals(shaped, loads, failure, time, base, order, drift, initial_position, scale):
        for stretch in loop.advance(interval):
            if sample >= 0:
                result["rate_after"][sample], result["saturated_after"][sample] = loop.v, loop.saturated
                if sample == len(time) - 1:
                    break
                sample = -1
            within |= loop.saturated and stretch.duration > SHORTEST_S
            output.advance(stretch)
        if sample == len(time) - 1:
            break
        sample = interval.sample
        if sample >= 0:
            record(sample)
            within = False
    _measure(result, effects, time)
    return result


def complete(effects):
    """All effects with all parameters, neutral unless given. Unknown names and invalid values are refused."""
    full = {name: dict(parameters) for name, parameters in NEUTRAL.items()}
    for name, parameters in effects.items():
        if name not in full:
            raise ValueError(f"no effect {name!r}; there are: {', '.join(full)}")
        for parameter, value in parameters.items():
            if parameter not in full[name]:
                raise ValueError(f"no parameter {name}.{parameter}; there are: {', '.join(full[name])}")
            if not np.isfinite(value):
                raise ValueError(f"{name}.{parameter} = {value}: must be finite")
            if value < 0.0 and (name, parameter) in NOT_NEGATIVE or value <= 0.0 and (name, parameter) in POSITIVE:
                raise ValueError(f"{name}.{parameter} = {value}: must be positive")
            full[name][parameter] = float(value)
    if full["position_limit"]["min"] > full["position_limit"]["max"]:
        raise ValueError("position_limit: min is above max")
    return full


def quantise(value, step):
    """Nearest multiple of step, ties away from zero; step 0 is the identity."""
    if step == 0.0:
        return value
    return np.copysign(np.floor(np.abs(value) / step + 0.5) * step, value)


def _measure(result, effects, time):
    """Sensor effects without memory, in place."""
    bias, chatter = effects["sensor_bias"], effects["chatter"]
    result["unquantised"] += bias["offset"] + bias["drift"] * time
    if chatter["amplitude"] != 0.0:
        result["unquantised"] += chatter["amplitude"] * np.sin(
            2.0 * np.pi * chatter["frequency"] * time + chatter["phase"])
    result["position"] = quantise(result["unquantised"].copy(), effects["quantisation"]["step"])


def _scale(base, effects, shaped, load, failure, initial_position, drift):
    """Size of the signals, to which tolerances are relative."""
    ends = shaped.value + shaped.slope * np.diff(shaped.start, append=shaped.end)
    peak = max(np.abs(shaped.value).max(), np.abs(ends).max()) * abs(base[0]) * (1.0 + abs(drift) * shaped.end)
    scale = max(peak, abs(initial_position), np.abs(load).max() + abs(effects["hinge_load"]["bias"]))
    if np.any(failure == HARDOVER_POSITIVE):
        scale = max(scale, abs(effects["position_limit"]["max"]))
    if np.any(failure == HARDOVER_NEGATIVE):
        scale = max(scale, abs(effects["position_limit"]["min"]))
    return scale if scale > 0.0 else 1.0


def _checked_base(base):
    if isinstance(base, dict):
        base = tuple(base[name] for name in ("k", "p", "omega", "zeta"))
    base = tuple(float(value) for value in base)
    if not (base[0] != 0.0 and base[1] > 0.0 and base[2] > 0.0 and base[3] >= 0.0 and np.all(np.isfinite(base))):
        raise ValueError(f"base (k, p, omega, zeta) = {base}: k not zero, p and omega > 0, zeta >= 0")
    return base


def _signal(name, values, time):
    values = np.asarray(values, float)
    if values.shape != time.shape or not np.all(np.isfinite(values)):
        raise ValueError(f"{name} must be finite, one value for each of the {len(time)} times")
    return values


def _failures(failure, count):
    if failure is None:
        return np.zeros(count, int)
    numbers = np.array([FAILURES.index(f) if isinstance(f, str) else int(f) for f in failure])
    if len(numbers) != count or numbers.min() < 0 or numbers.max() >= len(FAILURES):
        raise ValueError(f"failure must be one of {FAILURES} or 0-4 for each of the {count} times")
    return numbers
