"""The share of one difference in another: Fieller's interval against the test that it inverts, and its coverage."""

import math

import numpy as np
import pytest
from scipy.stats import t

from lockprobe.statistics.bridge.share import Share, share_of

LUCK = np.random.default_rng(1)
SECOND = LUCK.normal(3, 4, 60)
FIRST = 0.6 * SECOND + LUCK.normal(0, 2, 60)


def rejected(first, second, share):
    """Whether Student's test of the mean of first - share x second rejects 0, with one more block that differs."""
    away = first - share * second
    n = len(away)
    spread = float(np.sum((away - away.mean()) ** 2)) + float(np.mean(second**2))
    return abs(away.mean()) > t.ppf(0.975, n - 1) * math.sqrt(spread / (n - 1) / n)


def test_the_interval_holds_exactly_the_shares_that_the_test_does_not_reject():
    found = share_of(FIRST, SECOND)
    assert found.low < found.value == FIRST.mean() / SECOND.mean() < found.high
    for share in np.linspace(found.low - 1, found.high + 1, 400):
        assert rejected(FIRST, SECOND, share) == (not found.low <= share <= found.high)


def test_it_is_bounded_if_and_only_if_the_second_is_told_from_0():
    assert share_of(FIRST, SECOND - SECOND.mean() + 0.1).low is None
    assert share_of(FIRST, SECOND - SECOND.mean() + 0.1).verdict == "not decided"


def test_equal_differences_are_all_of_it_and_none_is_none():
    whole, none = share_of(SECOND, SECOND), share_of(np.zeros(60), SECOND)
    assert whole.value == 1
    assert whole.low < 1 < whole.high
    assert whole.verdict == "all"
    assert none.value == 0
    assert none.low == pytest.approx(-none.high)
    assert none.verdict == "none"


def test_nine_in_ten_intervals_hold_the_share_or_more():
    held = 0
    for _ in range(400):
        second = LUCK.exponential(2, 60)
        first = 0.3 * second + LUCK.exponential(1, 60) - 1
        found = share_of(first, second)
        held += found.low <= 0.3 <= found.high
    assert held / 400 > 0.95 - 3 * math.sqrt(0.05 * 0.95 / 400)


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (0.6, 1.2, "all"), (0.4, 1.2, "not decided"), (0.1, 0.4, "part"), (0.6, 0.9, "part"), (-0.2, 0.3, "none"),
        (-0.2, 0.6, "not decided"), (1.1, 2.0, "more"), (-2.0, -0.1, "opposite"), (None, None, "not decided"),
    ],
)  # fmt: skip
def test_what_an_interval_decides(low, high, verdict):
    assert Share(value=0.5, low=low, high=high).verdict == verdict
