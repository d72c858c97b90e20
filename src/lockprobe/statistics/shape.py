"""The shape over doses: the paper's trends (Figs. 4 and 5b), its correlation, and a test of a rise and a fall.

The unit of the paper is one repetition of one condition: a :class:`Point`. Its fits are least squares on shares. That a
parabola fits best is *not* evidence of a decline: of 2000 simulated studies in which success only levels off, AIC and
cross-validation both chose it in 53 %, with a maximum inside the range of p in 52 %. So no order is chosen.

Intervals are those of a cluster bootstrap: the trials of equal luck over all doses are a cluster, drawn within their
repetition, or all trials of one player.

The two-lines test finds a shape in 2 to 4 % of studies of a success that is flat, or rises and levels off, with 30
trials at each of seven p from 0 to 0.6; and in 27 % of studies of a success like the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import worst
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.how_soon import excess, grid
from lockprobe.statistics.outcomes import Outcomes, Point
from lockprobe.statistics.proportions import ALPHA, Difference

RESAMPLES = 2000

_AT_ONCE = 4_000_000
"""Numbers that are drawn at once, 32 MB."""

_CONSTANT = 1e-12
"""Sum of squares below which a quantity is constant."""

_GRID = 61
Array = NDArray[np.float64]

Quantity = Literal["success", "loop_rate"]


def trend(points: Sequence[Point], quantity: Quantity, draws: Array) -> dict[str, Any] | None:
    """Fit a parabola over doses as the paper does (Sec. 3.2); None with fewer than three doses.

    ``draws`` are the quantity at the points in bootstrap resamples, shape (resamples, points).

    Returns:
        A curve: doses (``x``), the fit there (``value``), and 2.5th and 97.5th percentiles over resamples (``low``,
        ``high``), empty without any.
    """
    x = np.array([point.dose for point in points], dtype=np.float64)
    y = np.array([getattr(point, quantity) for point in points], dtype=np.float64)
    if len(set(x.tolist())) < 3:
        return None
    at, fit = np.linspace(x.min(), x.max(), _GRID), np.linalg.pinv(np.vander(x, 3, increasing=True))
    basis = np.vander(at, 3, increasing=True)
    low, high = np.percentile(draws @ fit.T @ basis.T, [2.5, 97.5], axis=0) if len(draws) else ((), ())
    lines = {"x": at, "value": basis @ (fit @ y), "low": low, "high": high}
    return {name: tuple(map(float, line)) for name, line in lines.items()}


FEWEST_DOTS = 4
"""Points of which a correlation is given: of three, r is near -1 or 1 by chance, and its P value only rounding."""


def correlation(x: Array, y: Array, drawn: tuple[Array, Array]) -> Difference | None:
    """Pearson's r over points (Fig. 5a) with its 95 % interval and P value; None of a constant or few points.

    The ends are percentiles over resamples of both, shape (resamples, points), None without any. The P value is from
    Student's t, as if points were independent and trials of equal length.
    """
    r = float(_pearson(x[None], y[None])[0]) if len(x) >= FEWEST_DOTS else math.nan
    if not math.isfinite(r):
        return None
    free = len(x) - 2
    p_value = student_tails(r * math.sqrt(free / (1 - r * r)), free) if abs(r) < 1 else 0.0
    draws = _pearson(*drawn)
    finite = draws[np.isfinite(draws)]
    low, high = np.percentile(finite, [2.5, 97.5]).tolist() if len(finite) else (None, None)
    return Difference(value=r, low=low, high=high, p_value=p_value, n=len(x))


def _pearson(x: Array, y: Array) -> Array:
    """Correlations over the points of (samples, points); NaN if either is constant."""
    x, y = (one - one.mean(axis=1, keepdims=True) for one in (x, y))
    squares = np.sum(x**2, axis=1), np.sum(y**2, axis=1)
    constant = np.minimum(*squares) < _CONSTANT
    scale = np.where(constant, 1.0, np.sqrt(squares[0] * squares[1]))
    return np.where(constant, math.nan, np.clip(np.sum(x * y, axis=1) / scale, -1.0, 1.0))


def resample(counted: Outcomes, rng: np.random.Generator) -> dict[Quantity, Array]:
    """Draw the clusters of one agent's trials with replacement, within every repetition; people from all.

    The shares of resampled points (:func:`lockprobe.statistics.outcomes.points`) have the shape (resamples, points), of
    zero rows if a repetition has a single cluster.

    Where nothing of a point was drawn, its observed share stands. Some resamples are drawn at a time, since how often
    each cluster is drawn would take gigabytes for all; the counts are whole numbers, so that no sum depends on it.
    """
    kinds, point = np.unique(np.column_stack([counted.dose, counted.repetition]), axis=0, return_inverse=True)
    cluster, repetition = counted.cluster, np.zeros_like(counted.repetition) if counted.crossed else counted.repetition
    strata = [np.unique(cluster[repetition == number]) for number in np.unique(repetition)]
    if any(len(members) < 2 for members in strata):
        return {"success": np.empty((0, len(kinds))), "loop_rate": np.empty((0, len(kinds)))}
    tables, drawn = np.zeros((3, int(cluster.max(initial=-1)) + 1, len(kinds))), np.zeros((3, RESAMPLES, len(kinds)))
    for table, event in zip(tables, (np.ones(len(counted)), counted.solved, counted.looped), strict=True):
        np.add.at(table, (cluster, point.reshape(-1)), event)
    for members in strata:
        own, even, rows = tables[:, members], np.full(len(members), 1 / len(members)), max(1, _AT_ONCE // len(members))
        for first in range(0, RESAMPLES, rows):
            size = min(rows, RESAMPLES - first)
            times = rng.multinomial(len(members), even, size=size).astype(np.float64)
            drawn[:, first : first + size] += times @ own
    (n, *happened), (all_, *observed) = drawn, tables.sum(axis=1)
    success, loop_rate = (
        np.where(n > 0, many / np.maximum(n, 1), total / all_) for many, total in zip(happened, observed, strict=True)
    )
    return {"success": success, "loop_rate": loop_rate}


class Counts(NamedTuple):
    """Trials and those with the event per dose, each of shape (doses,), ascending."""

    dose: Array
    events: Array
    n: Array


class Line(NamedTuple):
    """The score of a slope in standard errors (Cochran-Armitage; of loop onset log-rank), and its two-sided P value."""

    z: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLines:
    """The two-lines test (Simonsohn 2018).

    Attributes:
        value: The break point: the dose at which the lines meet; its trials belong to both lines.
        first: The line up to the break.
        second: The line from the break on.
        p_value: The larger of the two P values if the slopes have opposite signs, else 1; None if there is no test.
    """

    value: float | None = None
    first: Line | None = None
    second: Line | None = None
    p_value: float | None = None

    @property
    def direction(self) -> Literal["U", "inverted U"] | None:
        """The shape concluded at the 5 % level, if any."""
        if self.first is None or self.p_value is None or self.p_value > ALPHA:
            return None
        return "U" if self.first.z < 0 else "inverted U"


Turning = Literal["success", "first loops"]


def two_lines(outcomes: Outcomes, of: Turning = "success", *, agents: int = 1) -> TwoLines:
    """Two-lines test of a change of direction: a line on each side of a break, both significant, of opposite sign.

    The break is Simonsohn's Robin Hood choice among the inner values of p, from a cubic through empirical logits (his
    is a spline through many x); values of p count alike. Each slope is tested two-sided at 5 %, as his. That found a
    U in at most 5 % of studies of a success that is flat or levels off, with 10, 30 or 100 trials per p; one-sided
    tests at 5 % would find it in up to 7 %. It is corrected for agents (Bonferroni), and holds for one look.

    Of first loops it is whether these come later and then sooner again over p, or the reverse, with log-rank scores for
    trend (Tarone 1975): at each step, the trials that still run without a loop are compared over p. So trials of
    different length do not matter. Standard errors are clustered; of success only for people.

    A shape holds whatever became of broken trials. Those at the lowest dose were solved (and looped) in the step in
    which they broke and those at every other never, and the reverse; and so of those at the lowest and at the highest
    dose against all others.
    """
    begun = outcomes.at_ended_doses
    every = [begun.ended]
    if begun.broke.any():
        lowest = begun.dose == begun.dose.min()
        outer = lowest | (begun.dose == begun.dose.max())
        every += [begun.completed(soon) for side in (lowest, outer) for soon in (side, ~side)]
    found = worst(*(_two_lines(one, of) for one in every))
    return found if found.p_value is None else replace(found, p_value=min(1.0, agents * found.p_value))


def _two_lines(outcomes: Outcomes, of: Turning) -> TwoLines:
    counted, line = (_counted(outcomes), _slope) if of == "success" else (_first_loops(outcomes), _slope_of_loops)
    if len(counted.dose) < 3:
        return TwoLines()
    at = _robin_hood_break(counted)
    sides = outcomes.dose <= counted.dose[at], outcomes.dose >= counted.dose[at]
    first, second = (line(outcomes.at(side)) for side in sides)
    p_value = max(first.p_value, second.p_value) if first.z * second.z < 0 else 1.0
    return TwoLines(value=float(counted.dose[at]), first=first, second=second, p_value=p_value)


def _first_loops(outcomes: Outcomes) -> Counts:
    """The first loops at each p, of as many as would be expected there if p had no influence."""
    levels = np.unique(outcomes.dose)
    running, event = grid(outcomes.until_loop, outcomes.looped)
    here = (levels[:, None] == outcomes.dose).astype(np.float64)
    n, events, looped = running.sum(axis=0), event.sum(axis=0), here @ event.sum(axis=1)
    expected = here @ running @ (events / np.maximum(n, 1.0))
    steps = expected * n[events > 0].sum() / max(events.sum(), 1.0)  # as many as expect these first loops
    return Counts(levels, looped, np.maximum(np.maximum(looped, steps), 1.0))


def _slope_of_loops(outcomes: Outcomes) -> Line:
    found = excess(outcomes.dose, outcomes.until_loop, outcomes.looped, outcomes.cluster)
    z = round(found.total, 10) / found.error if found.error > 0 else 0.0
    return Line(z, 1.0 if found.p_value is None else found.p_value)


def _counted(outcomes: Outcomes) -> Counts:
    doses = np.unique(outcomes.dose)
    here = doses[:, None] == outcomes.dose
    return Counts(doses, (here & outcomes.solved).sum(axis=1, dtype=np.float64), here.sum(axis=1, dtype=np.float64))


def _score(counted: Counts) -> float:
    """The Cochran-Armitage score of a slope, in standard errors; 0 if nothing differs."""
    share = counted.events.sum() / counted.n.sum()
    centred = counted.dose - np.average(counted.dose, weights=counted.n)
    variance = share * (1 - share) * np.sum(counted.n * centred**2)
    return float(counted.events @ centred / math.sqrt(variance)) if variance > 0 else 0.0


def _slope(outcomes: Outcomes) -> Line:
    """The line of success.

    Of people the variance is the larger of that between clusters and that of independent trials, with Student's t over
    clusters.
    """
    z = _score(_counted(outcomes))
    if not outcomes.crossed:
        return Line(z, math.erfc(abs(z) / math.sqrt(2)))
    order = np.lexsort((outcomes.solved, outcomes.dose, outcomes.cluster))  # sums do not hang on the order of trials
    p, solved, cluster = outcomes.dose[order], outcomes.solved[order], outcomes.cluster[order]
    centred, share = p - p.mean(), solved.mean()
    sums = np.bincount(np.unique(cluster, return_inverse=True)[1], weights=centred * (solved - share))
    k, independent = len(sums), float(share * (1 - share) * np.sum(centred**2))
    if k < 3 or not independent:
        return Line(z, 1.0)
    variance = max(independent, k / (k - 2) * float(np.sum(sums**2)))
    return Line(z, float(student_tails(float(np.sum(sums)) / math.sqrt(variance), k - 2)))


def _robin_hood_break(counted: Counts) -> int:
    """The index of Simonsohn's Robin Hood break: in the flat region about the extremum, nearer to the clearer line.

    The flat region holds the inner values of p whose smooth fit lies within a standard error of the most extreme. The
    lines about its median have the strengths z1 and z2; the break is its quantile z2 / (z1 + z2). The fits are
    polynomials through empirical logits.
    """
    yes, no = counted.events + 0.5, counted.n - counted.events + 0.5
    weight, logits = 1 / (1 / yes + 1 / no), np.log(yes / no)

    def polynomial(order: int) -> tuple[Array, Array, Array]:
        design = np.vander(counted.dose, order + 1, increasing=True)
        covariance = np.linalg.pinv(design.T @ (weight[:, None] * design))
        coefficients = covariance @ (design.T @ (weight * logits))
        return coefficients, design @ coefficients, np.sqrt(np.einsum("ij,jk,ik->i", design, covariance, design))

    bend = polynomial(2)[0][2]
    _, fitted, error = polynomial(min(3, len(counted.dose) - 1))
    inner = np.sign(bend or 1.0) * fitted[1:-1]
    lowest = int(np.argmin(inner))
    flat = 1 + np.flatnonzero(inner <= inner[lowest] + error[1:-1][lowest])
    middle = int(flat[(len(flat) - 1) // 2])
    sides = slice(middle + 1), slice(middle, None)
    first, second = (abs(_score(Counts(*(of[side] for of in counted)))) for side in sides)
    quantile = second / (first + second) if first + second > 0 else 0.5
    return int(flat[max(0, math.ceil(quantile * len(flat) - 1e-9) - 1)])
