"""Rates with their uncertainty: Wilson's score interval, which is valid for few cases and for rates near 0 and 1.

    centre = (p + q/2n) / (1 + q/n),   half width = z sqrt(p (1 - p)/n + q/4n^2) / (1 + q/n),   p = k/n,  q = z^2
"""

from math import sqrt

Z_95 = 1.959963984540054  # standard normal quantile of 0.975


def wilson(count, total, z=Z_95):
    """The 95 % interval of the rate estimated by `count` of `total`; (0, 1) if `total` is 0."""
    if total == 0:
        return 0.0, 1.0
    p, q = count / total, z * z / total
    centre = (p + 0.5 * q) / (1.0 + q)
    half = z * sqrt(p * (1.0 - p) / total + 0.25 * q / total) / (1.0 + q)
    return max(0.0, centre - half), min(1.0, centre + half)


def rate(count, total):
    """`12 of 600: 2.0 % (1.1 to 3.5)`"""
    if total == 0:
        return "0 of 0"
    low, high = wilson(count, total)
    return f"{count} of {total}: {100.0 * count / total:.1f} % ({100.0 * low:.1f} to {100.0 * high:.1f})"
