"""Wilson's interval against published numbers and against its own definition."""

from math import sqrt

import pytest

from .intervals import Z_95, rate, wilson


@pytest.mark.parametrize("count, total, low, high", [
    (0, 10, 0.0, 0.2775),  # Brown, Cai and DasGupta 2001: q/(1 + q) with q = z^2/n
    (10, 10, 0.7225, 1.0),
    (81, 263, 0.2553, 0.3662),  # Newcombe 1998, table I
    (15, 148, 0.0624, 0.1605),
    (0, 20, 0.0, 0.1611),
    (1, 29, 0.0061, 0.1718),
])  # fmt: skip
def test_published_intervals(count, total, low, high):
    assert wilson(count, total) == pytest.approx((low, high), abs=1e-4)


@pytest.mark.parametrize("count, total", [(1, 7), (5, 12), (200, 600)])
def test_its_ends_lie_z_standard_deviations_of_their_own_from_the_rate(count, total):
    for end in wilson(count, total):
        assert abs(count / total - end) == pytest.approx(Z_95 * sqrt(end * (1.0 - end) / total))


def test_of_nothing_everything_is_possible():
    assert wilson(0, 0) == (0.0, 1.0) and rate(0, 0) == "0 of 0"
    assert rate(12, 600) == "12 of 600: 2.0 % (1.1 to 3.5)"
