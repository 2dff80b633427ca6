"""The BACT wing on its pitch-and-plunge mount, in quasi-steady flow, and the published control law.

Plunge h [ft] is positive down, pitch theta [rad] positive nose up, both at the elastic axis; deflection d [rad] positive
trailing edge down; a gust w [ft/s] positive up; a disturbing force F [lb] positive down. With q the dynamic pressure [psf]
and U the speed [ft/s]::

    m h'' + S_ht theta'' + D_h h' + K_h h         = -q S C_L + F
    S_ht h'' + I theta'' + D_t theta' + K_t theta =  q S c C_m
    C_L = C_La (alpha + w/U) + c/(2U) (C_La' alpha' + C_Lq theta') + C_Ld d,      alpha = theta + h'/U,     C_m alike

The gust acts through the angle of attack alone, not through its rate.

Control law, command [deg] from pitch [rad]::

    command = C(s) (0 - theta),    C(s) = -(b0 s^2 + b1 s + b2) / (s^2 + a1 s)

with states x' = e, e' = theta - a1 e:  command = b0 theta + (b1 - a1 b0) e + b2 x.

Sources: numbers, equations and control law from the MathWorks flutter-suppression example for the BACT; the wing agrees with
Waszak, NASA/TP-1998-206270. The sign of S_ht is not confirmed there.
"""

import functools
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

MASS_SLUG, INERTIA_SLUG_FT2 = 6.08, 2.80
COUPLING_SLUG_FT = -0.0142  # S_ht = m x_cg
PLUNGE_STIFFNESS_LB_FT, PITCH_STIFFNESS_FT_LB_RAD = 2686.0, 3000.0
PLUNGE_DAMPING = 2.0 * 0.0014 * MASS_SLUG * 21.01  # lb s/ft: damping ratio 0.0014 at 21.01 rad/s
PITCH_DAMPING = 2.0 * 0.0010 * INERTIA_SLUG_FT2 * 32.71  # ft lb s/rad
AREA_FT2, CHORD_FT = 3.55, 1.33
SPEED_FT_S = 385.0


@dataclass(frozen=True)
class Coefficients:
    """Derivatives of one aerodynamic coefficient [1/rad]; the rates are multiplied by c/(2U)."""

    attack: float
    attack_rate: float
    pitch_rate: float
    deflection: float


LIFT = Coefficients(4.584, -3.1064, 2.5625, 0.63)
MOMENT = Coefficients(1.490, -2.6505, -0.4035, -0.0246)  # about the elastic axis

B0, B1, B2, A1 = 10393.798954, 80183.687475, 565082.359817, 100.0  # deg/rad and powers of 1/s

PLUNGE, PITCH, PLUNGE_RATE, PITCH_RATE, INTEGRAL, FILTERED = range(6)
DEFLECTION, GUST, FORCE = range(3)
STATES, INPUTS = 6, 3


@functools.lru_cache(maxsize=1024)
def wing(pressure_psf, speed_ft_s=SPEED_FT_S):
    """(A, B) of z' = A z + B u, z = (h, theta, h', theta'), u = (d [rad], w, F)."""
    force = pressure_psf * AREA_FT2 * np.array([-1.0, CHORD_FT])

    def derivative(name):
        return force * np.array([getattr(LIFT, name), getattr(MOMENT, name)])

    half_chord_time = CHORD_FT / (2.0 * speed_ft_s)
    mass = np.array([[MASS_SLUG, COUPLING_SLUG_FT], [COUPLING_SLUG_FT, INERTIA_SLUG_FT2]])
    damping = np.diag([PLUNGE_DAMPING, PITCH_DAMPING])
    stiffness = np.diag([PLUNGE_STIFFNESS_LB_FT, PITCH_STIFFNESS_FT_LB_RAD])
    # alpha = theta + h'/U and alpha' = theta' + h''/U, collected by state
    mass[:, 0] -= derivative("attack_rate") * half_chord_time / speed_ft_s
    damping[:, 0] -= derivative("attack") / speed_ft_s
    damping[:, 1] -= (derivative("attack_rate") + derivative("pitch_rate")) * half_chord_time
    stiffness[:, 1] -= derivative("attack")
    inputs = np.column_stack([derivative("deflection"), derivative("attack") / speed_ft_s, [1.0, 0.0]])
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    return a, np.vstack([np.zeros((2, INPUTS)), np.linalg.solve(mass, inputs)])


@functools.lru_cache(maxsize=1024)
def wing_with_control(pressure_psf, speed_ft_s=SPEED_FT_S, gain=1.0):
    """(A, B, row of the command [deg]); z = (h, theta, h', theta', x, e), u = (deflection [deg], w, F)."""
    a, b = np.zeros((STATES, STATES)), np.zeros((STATES, INPUTS))
    a[:4, :4], b[:4] = wing(pressure_psf, speed_ft_s)
    b[:, DEFLECTION] *= np.pi / 180.0
    a[INTEGRAL, FILTERED] = 1.0
    a[FILTERED, PITCH], a[FILTERED, FILTERED] = 1.0, -A1
    command = np.zeros(STATES)
    command[[PITCH, FILTERED, INTEGRAL]] = gain * B0, gain * (B1 - A1 * B0), gain * B2
    return a, b, command


@functools.lru_cache(maxsize=4096)
def transition(pressure_psf, speed_ft_s, step_s):
    """(Phi, G0, G1): z+ = Phi z + G0 u + G1 u', exactly, for an input that is linear within the step.

    One matrix exponential of the system with u and u' as further states. Nothing is stiff here: |A| step < 1.
    """
    a, b, _ = wing_with_control(pressure_psf, speed_ft_s)
    whole = np.zeros((STATES + 2 * INPUTS,) * 2)
    whole[:STATES, :STATES], whole[:STATES, STATES : STATES + INPUTS] = a, b
    whole[STATES : STATES + INPUTS, STATES + INPUTS :] = np.eye(INPUTS)
    moved = expm(step_s * whole)[:STATES]
    return moved[:, :STATES], moved[:, STATES : STATES + INPUTS], moved[:, STATES + INPUTS :]


def modes(matrix):
    """(frequency [Hz], damping ratio) of the oscillating modes of a matrix, by rising frequency."""
    roots = np.linalg.eigvals(matrix)
    roots = roots[roots.imag > 1e-9]
    return sorted((abs(root) / (2.0 * np.pi), -root.real / abs(root)) for root in roots)
