"""One effect of the library in one of the eight drives, at its place in the hardware.

    rate_limit          speed of the pump, the spool's stroke, current of the piezo amplifier, no-load speed or limit of the speed loop
    acceleration_limit  relief valve, or current           position_limit     stops; voltage of the piezo amplifier
    dead_zone           overlap of the spool, or in the controller              amplitude_gain     stiffening spring at the load
    backlash            play in the gear, cables without tension; rod end of a cylinder, with a load held by friction
    coulomb_friction    seals, bearings; higher near rest where the drive has Stribeck friction
    structural_mode     support of the sensor, light compared with the drive
    delay, asymmetric_gain, command_rate_limit, command_dead_zone     in the reference, ahead of the bus
    sensor_lag, sensor_bias (a drift), gain_drift, quantisation       in the sensor

Values are stated in terms of the sensor output. A linear spring at the load is no effect here: in a linear drive it changes k and omega.
Strengths without a counterpart in the library are not scored: a torque limit, friction behind a controller that is not a spring, a mode whose
gain and damping trade off, play with a load that coasts, anything within hysteresis, and a delay or lag in addition to another one.
"""

from dataclasses import replace

import numpy as np
from scipy import signal

from . import independent_effects, rig_effects
from .drive_dynamics import CABLE, EHA, HARMONIC, PIEZO, PWM, SPOOL
from .rig_effects import Effect, two_sides

IN_ANY = ("delay", "asymmetric_gain", "sensor_lag", "gain_drift", "command_rate_limit", "sensor_bias", "quantisation", "command_dead_zone")
OF_SENSOR = ("sensor_lag", "gain_drift", "sensor_bias", "quantisation")
MOST_SPEED_LOSS = 0.1  # largest loss by leakage and drag for which the strength of a rate limit is scored
NEVER_SCORED = ("acceleration_limit", "structural_mode", "amplitude_gain")


def name(drawn, seed, rigs, later):
    """In three rounds of five an effect of this hardware, otherwise one that any drive may have; `later` ones of these if it was too weak."""
    number = seed // rigs
    rounds, place = divmod(number, 5)
    if place in (1, 3):
        return IN_ANY[(2 * rounds + place // 2 + seed % rigs + later) % len(IN_ANY)]
    return drawn.effects[(3 * rounds + place // 2 + seed % rigs + later) % len(drawn.effects)]


def draw(rng, name, drawn, model_is_late):
    """Sizes relative to the amplitude and to the corresponding speed w amplitude and acceleration w^2 amplitude."""
    amplitude, w = drawn.amplitude_deg, 2.0 * np.pi * drawn.bandwidth_hz
    sign, (low, high) = rng.choice([-1.0, 1.0]), two_sides(rng)
    mode = {"frequency": drawn.bandwidth_hz * rng.uniform(1.3, 3.0), "damping": rng.uniform(0.02, 0.08)}
    effect = {
        "rate_limit": Effect(name, lambda s: {"up": amplitude * w / s, "down": amplitude * w / s}, 0.6, 8.0),
        "command_rate_limit": Effect(name, lambda s: {"up": amplitude * w / s, "down": amplitude * w / s}, 0.5, 8.0),
        "acceleration_limit": Effect(name, lambda s: {"value": amplitude * w**2 / s}, 0.3, 12.0),
        "position_limit": Effect(name, lambda s: {"min": -low * amplitude / s, "max": high * amplitude / s}, 1.02, 4.0),
        "dead_zone": Effect(name, lambda s: {"half_width": s * amplitude}, 0.01, 0.4),
        "command_dead_zone": Effect(name, lambda s: {"half_width": s * amplitude}, 0.01, 0.4),
        "backlash": Effect(name, lambda s: {"gap": s * amplitude}, 0.01, 0.6),
        "coulomb_friction": Effect(name, lambda s: {"acceleration": s * amplitude * w**2}, 0.03, 3.0),
        "amplitude_gain": Effect(name, lambda s: {"cubic": s / amplitude**2}, 0.03, 1.0),
        "structural_mode": Effect(name, lambda s: mode | {"gain": sign * s}, 0.02, 0.8),
        "delay": Effect(name, lambda s: {"time": s / w}, 0.03, 1.5),
        "asymmetric_gain": Effect(name, lambda s: {"ratio": (1.0 - s) ** sign}, 0.02, 0.35),
        "sensor_lag": Effect(name, lambda s: {"time": s / w}, 0.03, 1.5),
        "gain_drift": Effect(name, lambda s: {"rate": sign * s}, 0.001, 0.03),
        "sensor_bias": Effect(name, lambda s: {"drift": sign * s * amplitude}, 0.0005, 0.05),
        "quantisation": Effect(name, lambda s: {"step": s * amplitude}, 0.02, 1.0),
    }[name]  # fmt: skip
    return replace(effect, scored=is_scored(name, drawn, model_is_late))


def is_scored(name, drawn, model_is_late):
    piezo = drawn.plant.structure == PIEZO
    return {
        "rate_limit": not piezo and speed_loss(drawn.plant) < MOST_SPEED_LOSS, "position_limit": not piezo, "backlash": not drawn.coasts,
        "dead_zone": drawn.plant.structure in (PWM, SPOOL), "coulomb_friction": drawn.plant.structure == PWM,
        "delay": not model_is_late and "delay" not in drawn.inherent, "sensor_lag": not model_is_late and "sensor_lag" not in drawn.inherent,
    }.get(name, name not in NEVER_SCORED)  # fmt: skip


def speed_loss(plant):
    """Share of a demanded speed that is lost to leakage and drag, to first order."""
    if plant.structure in (EHA, SPOOL):
        return plant.leak * plant.viscous / plant.oil**2
    return plant.ratio * plant.drag * plant.lag if plant.kv == 0.0 else (plant.viscous + plant.ratio * plant.drag) / plant.kv


def in_reference(name, values, reference, h):
    return independent_effects.in_reference(name, values, reference, h)


def in_plant(name, values, plant):
    """The plant with an effect in its equations."""
    if name == "rate_limit":
        return plant._replace(rate=min(plant.rate, values["up"]))
    if name == "acceleration_limit":
        return plant._replace(relief=values["value"] / plant.oil) if plant.structure == EHA else plant._replace(acceleration=values["value"])
    if name == "position_limit":
        sides = ("lowest", "highest") if plant.structure == PIEZO else ("stop_low", "stop_high")
        return plant._replace(**dict(zip(sides, (values["min"], values["max"]))))
    if name == "dead_zone":
        wide = values["half_width"]
        return plant._replace(overlap=plant.kp * wide, underlap=0.0) if plant.structure == SPOOL else plant._replace(half_width=wide)
    if name == "backlash" and plant.structure >= HARMONIC:
        slack = {"pretension": 0.0} if plant.structure == CABLE and values["gap"] else {}
        return plant._replace(gap=values["gap"], **slack)
    if name == "coulomb_friction":
        return plant._replace(coulomb=plant.coulomb + values["acceleration"])
    if name == "amplitude_gain":
        return plant._replace(hardening=values["cubic"] * plant.shaft**2)
    return plant


def at_output(name, values, seen, plant, h):
    """The position at the sensor."""
    if name == "backlash" and plant.structure < HARMONIC:
        return rig_effects.at_output(name, values, seen)
    if name == "structural_mode":
        w = 2.0 * np.pi * values["frequency"]
        top, bottom, _ = signal.cont2discrete(([w**2], [1.0, 2.0 * values["damping"] * w, w**2]), h, "foh")
        return seen + values["gain"] * (signal.lfilter(np.ravel(top), bottom, seen) - seen)
    return seen


def stated(name, values, drawn):
    """The values in terms of the sensor output."""
    gain, plant = drawn.sensor.gain, drawn.plant
    if name == "position_limit":
        return {side: gain * value + drawn.sensor.offset for side, value in values.items()}
    if name == "rate_limit":
        return {side: gain * min(plant.rate, value) / (1.0 + speed_loss(plant)) for side, value in values.items()}
    if name == "backlash":
        return {"gap": gain * values["gap"]}
    if name == "acceleration_limit":
        return {"value": gain * values["value"] / (1.0 + plant.ratio)}
    if name == "quantisation":
        return {"step": max(values["step"], drawn.sensor.step)}
    if name == "coulomb_friction":
        total = plant.coulomb + values["acceleration"]
        return {"level": total * plant.lag / plant.kp} if plant.structure == PWM else {"acceleration": total}
    return values
