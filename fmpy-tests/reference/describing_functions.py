"""Describing functions: the response of a nonlinearity to a sine, harmonic by harmonic, in closed form.

    input A sin(theta), output sum over n of Im(A N_n exp(i n theta)) + mean

N_1 is the describing function (complex gain), N_3 the third harmonic relative to the input amplitude; a negative
imaginary part of N_1 is a phase lag. Each function returns N_n for `harmonic` n (1 by default; odd unless noted).

Sources, by name below:
    Gelb     A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design,
             McGraw-Hill 1968, chapter 2 and appendix B (table of sinusoidal-input describing functions)
    Khalil   H. K. Khalil, Nonlinear Systems, 3rd ed., Prentice Hall 2002, section 7.2
    Slotine  J.-J. E. Slotine, W. Li, Applied Nonlinear Control, Prentice Hall 1991, section 5.2-5.3
    Duda     H. Duda, Effects of rate limiting elements in flight control systems - a new PIO criterion,
             AIAA-95-3204 (1995); Prediction of pilot-in-the-loop oscillations due to rate saturation,
             J. Guidance, Control and Dynamics 20(3), 581-587 (1997)

The higher harmonics follow from the same integral as the first. With y the output over one period,

    N_n = i / (pi A) int_0^{2 pi} y exp(-i n theta) dtheta = 1 / (n pi A) int_0^{2 pi} y' exp(-i n theta) dtheta
"""

import numpy as np
from scipy.optimize import brentq


def saturation_function(ratio):
    """f(r) = 2/pi (asin r + r sqrt(1 - r^2)) for |r| <= 1, sign(r) beyond.    Gelb, appendix B; Slotine 5.3"""
    r = np.clip(ratio, -1.0, 1.0)
    return 2.0 / np.pi * (np.arcsin(r) + r * np.sqrt(1.0 - r * r))


def saturation(amplitude, limit, harmonic=1):
    """clamp(x, -limit, limit).

    N_1 = f(r),  N_3 = 4/(3 pi) r (1 - r^2)^(3/2),  r = limit / A.    Gelb, appendix B; Khalil, example 7.7
    """
    r = min(1.0, limit / amplitude)
    if _checked(harmonic) == 1:
        return complex(saturation_function(r))
    return complex(4.0 / (3.0 * np.pi) * r * (1.0 - r * r) ** 1.5)


def dead_zone(amplitude, half_width, harmonic=1):
    """0 inside |x| <= w, x - sign(x) w outside; that is x minus the saturation at w.

    N_1 = 1 - f(w/A),  N_3 = -N_3 of the saturation.    Gelb, appendix B; Slotine 5.3
    """
    linear = 1.0 if _checked(harmonic) == 1 else 0.0
    return linear - saturation(amplitude, half_width, harmonic)


def play(amplitude, gap, harmonic=1):
    """Backlash with total gap g: |x - y| <= g/2, y moves only when pushed. No output for A <= g/2.

    y is carried, y' = A cos(theta), from alpha to pi/2 and half a period later;  alpha = -asin(c),  c = 1 - g/A

    N_1 = (1 + f(c)) / 2 - i (1 - c^2) / pi                                      Gelb, appendix B; Slotine 5.3
    N_n = (E_{n-1} + E_{n+1}) / (n pi),  E_m = int_alpha^{pi/2} exp(-i m theta) dtheta
    """
    if amplitude <= 0.5 * gap:
        return 0j
    c = 1.0 - gap / amplitude
    if _checked(harmonic) == 1:
        return complex(0.5 * (1.0 + saturation_function(c)), -(1.0 - c * c) / np.pi)
    return _carried(harmonic, -np.arcsin(c), 0.5 * np.pi) / (harmonic * np.pi)


def relay(amplitude, level, threshold=0.0, harmonic=1):
    """level sign(x) for |x| > threshold, 0 inside.

    N_n = 4 level / (n pi A) cos(n asin(threshold / A)),  0 for A <= threshold.    Gelb, appendix B; Khalil, ex. 7.6
    """
    if amplitude <= threshold:
        return 0j
    n = _checked(harmonic)
    return complex(4.0 * level / (n * np.pi * amplitude) * np.cos(n * np.arcsin(threshold / amplitude)))


def coulomb_friction(amplitude, level, harmonic=1):
    """level sign(x') with x = A sin(theta) the displacement: a relay on the rate, a quarter period ahead.

    N_1 = 4 i level / (pi A),  N_3 = -4 i level / (3 pi A).    Gelb, section 2.3 and appendix B
    """
    return 1j ** _checked(harmonic) * relay(amplitude, level, 0.0, harmonic)


def equivalent_damping_ratio(amplitude, frequency, level, omega):
    """Viscous damping with the same first harmonic as the friction force omega^2 level sign(v):

    2 zeta_e omega w A = 4 omega^2 level / pi  ->  zeta_e = 2 omega level / (pi w A),  w = 2 pi frequency [Hz]
    """
    return 2.0 * omega * level / (np.pi * 2.0 * np.pi * frequency * amplitude)


def quantiser(amplitude, step, harmonic=1):
    """Nearest multiple of the step (mid-tread): a sum of relays of level q at the thresholds (j - 1/2) q.

    N_n = 4 q / (n pi A) sum_j cos(n asin((j - 1/2) q / A)).    Gelb, appendix B (quantizer); Slotine 5.3
    """
    thresholds = step * (np.arange(1, int(np.floor(amplitude / step + 0.5)) + 1) - 0.5)
    return sum((relay(amplitude, step, threshold, harmonic) for threshold in thresholds), 0j)


def cubic(amplitude, coefficient, harmonic=1):
    """coefficient x^3:  N_1 = 3/4 coefficient A^2,  N_3 = -1/4 coefficient A^2.    Gelb, section 2.3; Khalil 7.2"""
    return complex((0.75 if _checked(harmonic) == 1 else -0.25) * coefficient * amplitude**2)


def asymmetric_gain(amplitude, ratio, harmonic=1):
    """x for x > 0, ratio x for x < 0: (1 + ratio)/2 x + (1 - ratio)/2 |x|. Harmonics 0 (the mean / A), 1, 2, ...

    |sin theta| = 2/pi - 4/pi sum_k cos(2 k theta) / (4 k^2 - 1), so with r = (1 - ratio)/2
    mean = 2 r A / pi,  N_1 = (1 + ratio)/2,  N_2k = -4 i r / (pi (4 k^2 - 1)),  no odd harmonics above the first.
    Gelb, section 2.2 (Fourier series of asymmetric characteristics)
    """
    r = 0.5 * (1.0 - ratio)
    if harmonic == 0:
        return complex(2.0 * r / np.pi)
    if harmonic == 1:
        return complex(0.5 * (1.0 + ratio))
    return complex(0.0, -4.0 * r / (np.pi * (harmonic**2 - 1.0))) if harmonic % 2 == 0 else 0j


def rate_limit_onset_frequency(amplitude, rate):
    """Frequency [Hz] from which a rate limit acts on A sin(2 pi f t): A 2 pi f = rate, f = rate/(2 pi A).    Duda"""
    return rate / (2.0 * np.pi * amplitude)


# Above this multiple of the onset frequency the output is a triangle: sqrt(1 + pi^2/4) = 1.862 (Duda 1997).
FULLY_LIMITED = np.sqrt(1.0 + 0.25 * np.pi**2)


def rate_limiter(amplitude, frequency, rate, harmonic=1):
    """y follows x with |y'| <= rate. With o = onset frequency / frequency = rate / (2 pi f A):

    o >= 1                 N_1 = 1, N_3 = 0
    o <= 1 / 1.862         triangle of amplitude pi o A / 2, lagging by phi = acos(pi o / 2):
                           N_1 = 4 o / pi exp(-i phi),  N_3 = -4 o / (9 pi) exp(-3 i phi)                     Duda
    between                y' = -o A from theta_d = acos(-o) until y meets x again at theta_m, then x' until
                           theta_d + pi (and the mirror image), with theta_m from the transcendental equation
                           sin(theta_d) - o (theta_m - theta_d) = sin(theta_m)
                           N_n = (E_{n-1} + E_{n+1} - 2 o E_n(ramp)) / (n pi)
    """
    n = _checked(harmonic)
    o = rate_limit_onset_frequency(amplitude, rate) / frequency
    if o >= 1.0:
        return 1.0 + 0j if n == 1 else 0j
    if o <= 1.0 / FULLY_LIMITED:
        phase = np.arccos(0.5 * np.pi * o)
        sign = 1.0 if n == 1 else -1.0
        return complex(sign * 4.0 * o / (n * n * np.pi) * np.exp(-1j * n * phase))
    departure = np.arccos(-o)
    meeting = brentq(lambda theta: np.sin(departure) - o * (theta - departure) - np.sin(theta),
                     2.0 * np.pi - departure, departure + np.pi, xtol=1e-15)
    ramp = -2.0 * o * _exponential_integral(n, departure, meeting)
    return complex((_carried(n, meeting, departure + np.pi) + ramp) / (n * np.pi))


def _exponential_integral(m, start, end):
    """E_m = int_start^end exp(-i m theta) dtheta."""
    return end - start if m == 0 else (np.exp(-1j * m * end) - np.exp(-1j * m * start)) / (-1j * m)


def _carried(n, start, end):
    """2 int_start^end cos(theta) exp(-i n theta) dtheta: the output moves with the sine in both half periods."""
    return complex(_exponential_integral(n - 1, start, end) + _exponential_integral(n + 1, start, end))


def _checked(harmonic):
    if harmonic not in (1, 3):
        raise ValueError(f"harmonic {harmonic}: 1 and 3 are given")
    return harmonic
