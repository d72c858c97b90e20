"""Quantiles and tails of distributions, and tests of means and of small counts.

``scipy`` has all of these. To import its part with Student's distribution takes a third of a second of a processor,
which is longer than the numbers of most studies take.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import count, pairwise

import numpy as np
from numpy.typing import ArrayLike

_CLOSE = 1e-13
"""How far two steps towards a root may lie apart, as a part of it, or as it is below 1."""

_TIE = 1e-7
"""Relative difference up to which two tables are equally likely, as in R."""


def _beta(a: float, b: float, x: float, rest: float) -> float:
    """The regularized incomplete beta function at x, [0, 1], with ``rest`` 1 - x: Lentz's method on DLMF 8.17.22."""
    if not x or not rest:
        return float(not rest)
    if x > (a + 1) / (a + b + 2):  # where the fraction converges slowly
        return 1 - _beta(b, a, rest, x)
    upper, lower = 1.0, 1 / (1 - (a + b) * x / (a + 1))
    found = lower
    for m in count(1):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        for term in (even, odd):
            lower, upper = 1 / (1 + term * lower), 1 + term / upper
            found *= lower * upper
        if abs(lower * upper - 1) < 1e-15:
            break
    scale = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log(rest)
    return math.exp(scale) * found / a


@lru_cache(maxsize=4096)
def student_quantile(probability: float, freedom: float) -> float:
    """The quantile of Student's distribution with these degrees of freedom, at a probability in (0, 1)."""
    if probability < 0.5:
        return -student_quantile(1 - probability, freedom)
    tails, far = 2 * (1 - probability), 1.0
    while student_tails(far, freedom) > tails:
        far *= 2
    return root(lambda value: math.log(student_tails(value, freedom) / tails), 0.0, far) if tails < 1 else 0.0


def student_tails(value: float, freedom: float) -> float:
    """The probability of Student's distribution at or beyond a value on both sides."""
    if not math.isfinite(value):
        return 0.0 if math.isinf(value) else math.nan
    whole = freedom + value * value
    return _beta(freedom / 2, 0.5, freedom / whole, value * value / whole)


def root(of: Callable[[float], float], low: float, high: float) -> float:
    """Where a continuous function that has two signs at the ends is 0, by Ridders' method (1979).

    ``scipy.optimize.brentq`` gives the same.

    >>> round(root(lambda x: x**3 - 2, 0, 2) ** 3, 12)
    2.0
    """
    ends, last = [(low, of(low)), (high, of(high))], math.inf
    for x, value in ends:
        if value == 0:
            return x
    while True:
        (a, at_a), (b, at_b) = ends
        middle = (a + b) / 2
        at_middle = of(middle)
        x = middle + math.copysign(
            (middle - a) * at_middle / math.sqrt(at_middle**2 - at_a * at_b), (at_a - at_b) * at_middle
        )
        if (value := of(x)) == 0 or abs(x - last) <= _CLOSE * max(1.0, abs(x)):
            return x
        known = sorted([(a, at_a), (middle, at_middle), (x, value), (b, at_b)])
        ends, last = next([*two] for two in pairwise(known) if two[0][1] * two[1][1] <= 0), x


def welch_test(first: tuple[float, float, int], second: tuple[float, float, int]) -> float | None:
    """Welch's two-sided test that two means are equal; None if both samples have no spread.

    A sample is its mean, its standard deviation and its size, at least 2.
    """
    (one, spread, n), (two, wide, m) = first, second
    a, b = spread**2 / n, wide**2 / m
    if a + b == 0:
        return None
    return student_tails((one - two) / math.sqrt(a + b), (a + b) ** 2 / (a**2 / (n - 1) + b**2 / (m - 1)))


def sign_test(first: int, second: int) -> float:
    """The two-sided P value that of so many events as many are of the first kind as of the second; 1 without events."""
    few, many = sorted((first, second))
    return min(1.0, 2 * _beta(many, few + 1, 0.5, 0.5)) if many else 1.0


def fisher_exact(table: ArrayLike) -> float:
    """Fisher's exact test of counts of shape (2, 2), two-sided: of all tables with these margins, those no likelier."""
    (a, b), (c, d) = np.asarray(table, dtype=np.float64)
    top, left, rest = a + b, a + c, d - a
    first = np.arange(max(0.0, -rest), min(top, left) + 1)
    one, next_ = first[:-1], first[1:]  # of each table the next one, and how much likelier it is
    ratio = np.log((top - one) * (left - one)) - np.log(next_ * (rest + next_))
    likely = np.append(0.0, ratio).cumsum()
    likely = np.exp(likely - likely.max())
    here = likely[int(a - first[0])]
    return min(1.0, float(likely[likely <= here * (1 + _TIE)].sum() / likely.sum()))
