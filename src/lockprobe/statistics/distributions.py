"""Quantiles and tails of distributions, tests of means and of small counts, and Holm's correction.

``scipy.stats`` has all of these. To import it takes half a second, which is longer than the numbers of most studies
take. What is here calls the functions of ``scipy.special`` on which those of ``scipy.stats`` rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_CLOSE = 1e-13
"""How far the ends about a root may lie apart, as a part of it, or as it is below 1."""

_TIE = 1e-7
"""Relative difference up to which two tables are equally likely, as in R."""


def normal_quantile(probability: float) -> float:
    """The quantile of the standard normal distribution."""
    from scipy.special import ndtri

    return float(ndtri(probability))


def student_quantile(probability: float, freedom: float) -> float:
    """The quantile of Student's distribution with these degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, probability))


def student_tails(value: ArrayLike, freedom: float) -> Any:
    """The probability of Student's distribution at or beyond a value on both sides; an array for an array."""
    from scipy.special import stdtr

    found = 2 * stdtr(freedom, -np.abs(value))
    return found if np.ndim(value) else float(found)


def root(of: Callable[[float], float], low: float, high: float) -> float:
    """Where a continuous function that has two signs at the ends is 0, by Chandrupatla's method (1997).

    ``scipy.optimize.brentq`` gives the same; to import it takes a second.

    >>> round(root(lambda x: x**3 - 2, 0, 2) ** 3, 12)
    2.0
    """
    b, a = low, high
    at_b, at_a = of(b), of(a)
    c, at_c, part = b, at_b, 0.5
    while at_a and at_b:
        x = a + part * (b - a)
        if ((at_x := of(x)) > 0) == (at_a > 0):
            c, at_c = a, at_a
        else:
            c, at_c, b, at_b = b, at_b, a, at_a
        a, at_a = x, at_x
        near = _CLOSE * max(1.0, abs(a)) / abs(b - c)
        if near > 0.5:
            break
        xi, phi = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
        part = 0.5
        if phi**2 < xi and (1 - phi) ** 2 < 1 - xi:  # inverse quadratic interpolation stays between the ends
            part = at_a / (at_b - at_a) * at_c / (at_b - at_c)
            part += (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
        part = min(1 - near, max(near, part))
    return a if abs(at_a) < abs(at_b) else b


def student_mean(values: NDArray[np.float64], level: float) -> tuple[float, float, float]:
    """Student's interval of a mean, and its two-sided P value; shape (n,), two at least."""
    k, mean = len(values), float(values.mean())
    error = float(values.std(ddof=1)) / math.sqrt(k)
    half = student_quantile((1 + level) / 2, k - 1) * error
    p_value = float(student_tails(mean / error, k - 1)) if error else float(mean == 0)
    return mean - half, mean + half, p_value


def welch_test(first: tuple[float, float, int], second: tuple[float, float, int]) -> float | None:
    """Welch's two-sided test that two means are equal; None if both samples have no spread.

    A sample is its mean, its standard deviation and its size, at least 2.
    """
    (one, spread, n), (two, wide, m) = first, second
    a, b = spread**2 / n, wide**2 / m
    if a + b == 0:
        return None
    return float(student_tails((one - two) / math.sqrt(a + b), (a + b) ** 2 / (a**2 / (n - 1) + b**2 / (m - 1))))


def binomial_interval(count: int, n: int, level: float) -> tuple[float, float]:
    """The ends of Clopper and Pearson's exact interval of a share (1934); ``n`` is at least 1."""
    from scipy.special import betaincinv

    tail = (1 - level) / 2
    low = float(betaincinv(count, n - count + 1, tail)) if count else 0.0
    high = float(betaincinv(count + 1, n - count, 1 - tail)) if count < n else 1.0
    return low, high


def sign_test(first: int, second: int) -> float:
    """The two-sided P value that of so many events as many are of the first kind as of the second; 1 without events."""
    from scipy.special import bdtr

    return min(1.0, 2 * float(bdtr(min(first, second), first + second, 0.5))) if first + second else 1.0


def fisher_exact(table: ArrayLike) -> float:
    """Fisher's exact test of counts of shape (2, 2), two-sided: of all tables with these margins, those no likelier."""
    from scipy.special import gammaln

    (a, b), (c, d) = np.asarray(table, dtype=np.float64)
    top, left, all_ = a + b, a + c, a + b + c + d
    first = np.arange(max(0.0, top + left - all_), min(top, left) + 1)
    cells = np.array([first, top - first, left - first, all_ - top - left + first])
    likely = -gammaln(cells + 1).sum(axis=0)
    likely = np.exp(likely - likely.max())
    here = likely[int(a - first[0])]
    return min(1.0, float(likely[likely <= here * (1 + _TIE)].sum() / likely.sum()))


def holm(values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number (Holm 1979); None where there is no test."""
    adjusted, largest = list(values), 0.0
    tested = sorted((value, i) for i, value in enumerate(values) if value is not None)
    for smaller, (value, i) in enumerate(tested):
        largest = max(largest, min(1.0, (len(tested) - smaller) * value))
        adjusted[i] = largest
    return adjusted


def holm_by_family(families: Sequence[Hashable], values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number in each family, which has an entry of its own for each of them."""
    adjusted: list[float | None] = [None] * len(values)
    for family in dict.fromkeys(families):
        places = [i for i, other in enumerate(families) if other == family]
        for i, value in zip(places, holm([values[i] for i in places]), strict=True):
            adjusted[i] = value
    return adjusted
