"""One effect of the library in one of the six rigs: `rig_effects` where it has the same place in the hardware, and here

    backlash          play in the coupling to the load, which has inertia
    coulomb_friction  at the load
    asymmetric_gain   in the reference          amplitude_gain   a stiffening flexure             gain_drift   in the sensor

Values for a model of the library are in degrees of the sensor. Friction has a level in degrees where the drive pushes back like a spring.
An acceleration limit acts on the torque in the rigs, a play with a load that coasts is no play operator, a valve's speed depends on the
load where its flow does: their strengths are not scored, nor is that of a delay in addition to another one in the rig, its logger or the model.
"""

from dataclasses import replace

import numpy as np

from . import rig_effects
from .rig_effects import Effect

IN_ANY_RIG = ("command_limit", "command_rate_limit", "command_dead_zone", "command_backlash", "asymmetric_gain", "delay", "gain_drift")
SPRING = ("rc_servo", "voice_coil")


def name(drawn, seed, rigs, later):
    """In two rounds of three an effect of this hardware, otherwise one that any rig may have; `later` ones of these if it was too weak."""
    number = seed // rigs
    if number % 3 == 2:
        return IN_ANY_RIG[(number // 3 * rigs + seed % rigs + later) % len(IN_ANY_RIG)]
    return drawn.effects[(number - number // 3 + later) % len(drawn.effects)]


def draw(rng, name, drawn, model_is_late):
    sign = rng.choice([-1.0, 1.0])
    if name == "asymmetric_gain":
        return Effect(name, lambda s: {"ratio": (1.0 - s) ** sign}, 0.02, 0.25)
    if name == "gain_drift":
        return Effect(name, lambda s: {"rate": sign * s}, 0.001, 0.01)
    if name == "amplitude_gain":
        return Effect(name, lambda s: {"cubic": s / drawn.amplitude_deg**2}, 0.03, 0.5)
    is_late = model_is_late or drawn.latency_s or drawn.sensor.logged_late
    scored = {"coulomb_friction": drawn.name in SPRING, "backlash": not drawn.coasts, "delay": not is_late,
              "rate_limit": "square_root_flow" not in drawn.outside}  # fmt: skip
    effect = rig_effects.draw(rng, name, drawn)
    return replace(effect, scored=scored.get(name, effect.scored))


def in_reference(name, values, reference, h):
    if name == "asymmetric_gain":
        return np.where(reference < 0.0, reference * values["ratio"], reference)
    return rig_effects.in_reference(name, values, reference, h)


def in_rig(name, values, drawn):
    """The plant with an effect in its equations."""
    plant = drawn.plant
    if name == "backlash":
        return plant._replace(gap=values["gap"])
    if name == "amplitude_gain":
        return plant._replace(cubic=values["cubic"] / flexure_share(drawn))
    return rig_effects.in_rig(name, values, plant)


def stated(name, values, drawn):
    """The values in terms of the sensor output."""
    gain, plant = drawn.sensor.gain, drawn.plant
    if name == "position_limit":
        return {side: gain * value + drawn.sensor.offset for side, value in values.items()}
    if name in ("backlash", "rate_limit"):
        return {key: gain * value for key, value in values.items()}
    if name == "coulomb_friction" and drawn.name in SPRING:
        return {"level": values["acceleration"] / stiffness(drawn)}
    return values


def stiffness(drawn):
    """Restoring stiffness per unit error, per second squared."""
    plant = drawn.plant
    return plant.kp / plant.motor_lag if drawn.name == "rc_servo" else plant.coil * plant.feedback + plant.w**2


def flexure_share(drawn):
    return drawn.plant.w**2 / stiffness(drawn)
