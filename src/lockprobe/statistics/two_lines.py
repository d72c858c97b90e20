"""The two-lines test of a U shape or an inverted U shape.

It finds a shape in 2 to 4 % of studies of a success that is flat, or rises and levels off, with 30 trials at each of
seven p from 0 to 0.6; and in 27 % of studies of a success like the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import worst
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.hazards import excess, grid
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA

UShape = Literal["U", "inverted U"]

Array = NDArray[np.float64]


class Counts(NamedTuple):
    """Trials and successes per dose, each of shape (doses,), ascending."""

    dose: Array
    solved: Array
    n: Array

    def sides(self, at: int) -> tuple[Counts, Counts]:
        """The counts up to the break, and from it on."""
        return Counts(*(of[: at + 1] for of in self)), Counts(*(of[at:] for of in self))


class Line(NamedTuple):
    """The score of a slope in standard errors (Cochran-Armitage; of loop onset log-rank), and its two-sided P value."""

    z: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLines:
    """The two-lines test (Simonsohn 2018).

    Attributes:
        break_p: The break point: the p at which the lines meet; its trials belong to both lines.
        first: The line up to the break.
        second: The line from the break on.
        p_value: The larger of the two P values if the slopes have opposite signs, else 1; None if there is no test.
    """

    break_p: float | None = None
    first: Line | None = None
    second: Line | None = None
    p_value: float | None = None

    @property
    def direction(self) -> UShape | None:
        """The shape concluded at the 5 % level, if any."""
        if self.first is None or self.p_value is None or self.p_value > ALPHA:
            return None
        return "U" if self.first.z < 0 else "inverted U"


def rise_and_fall(outcomes: Outcomes, *, agents: int = 1) -> TwoLines:
    """The two-lines test of success, corrected for agents (Bonferroni); none at every look, since it holds for one."""

    def tested(some: Outcomes) -> TwoLines:
        found = two_lines(some.dose, some.solved, some.cluster if some.crossed else None)
        return found if found.p_value is None else replace(found, p_value=min(1.0, agents * found.p_value))

    return TwoLines() if outcomes.order is not None else _held(tested, outcomes)


def later_and_sooner(outcomes: Outcomes) -> TwoLines:
    """The two-lines test of first loops, which come later and then sooner again over p, or the reverse."""
    return _held(onset_lines, outcomes)


def _held(tested: Callable[[Outcomes], TwoLines], outcomes: Outcomes) -> TwoLines:
    """A shape that holds whatever became of broken trials.

    Those at the lowest dose were solved (and looped) in the step in which they broke and those at every other never,
    and the reverse; and so of those at the lowest and at the highest dose against all others.
    """
    begun, ends = outcomes.at_ended_doses, list[TwoLines]()
    if begun.broke.any():
        lowest = begun.dose == begun.dose.min()
        outer = lowest | (begun.dose == begun.dose.max())
        ends = [tested(begun.completed(soon)) for side in (lowest, outer) for soon in (side, ~side)]
    return worst(tested(begun.ended), *ends)


def two_lines(p: NDArray[np.float64], solved: NDArray[np.bool_], cluster: NDArray[np.int64] | None = None) -> TwoLines:
    """Two-lines test of a change of direction: a line on each side of a break, both significant, of opposite sign.

    The break is Simonsohn's Robin Hood choice among the inner values of p, from a cubic through empirical logits (his
    is a spline through many x); values of p count alike. Each slope is tested two-sided at 5 %, as his. That found a
    U in at most 5 % of studies of a success that is flat or levels off, with 10, 30 or 100 trials per p; one-sided
    tests at 5 % would find it in up to 7 %.

    With clusters, the variance of a slope is the larger of that between clusters and that of independent trials, with
    Student's t over clusters. Columns have the shape (trials,): dose, success, and cluster, without which trials are
    independent.
    """
    doses = np.unique(np.asarray(p, dtype=np.float64))
    if len(doses) < 3:
        return TwoLines()
    here = doses[:, None] == p
    counted = Counts(doses, (here & solved).sum(axis=1, dtype=np.float64), here.sum(axis=1, dtype=np.float64))
    at, lines = _robin_hood_break(counted), []
    for counts, side in zip(counted.sides(at), (p <= doses[at], p >= doses[at]), strict=True):
        z = _score(counts)
        alone = math.erfc(abs(z) / math.sqrt(2))
        lines.append(Line(z, alone if cluster is None else _clustered_p(p[side], solved[side], cluster[side])))
    return _two_lines_test(float(doses[at]), *lines)


def _two_lines_test(break_p: float, first: Line, second: Line) -> TwoLines:
    p_value = max(first.p_value, second.p_value) if first.z * second.z < 0 else 1.0
    return TwoLines(break_p=break_p, first=first, second=second, p_value=p_value)


def onset_lines(counted: Outcomes) -> TwoLines:
    """Two-lines test of loop onset: whether first loops come later and then sooner again over p, or the reverse.

    As :func:`two_lines`, with log-rank scores for trend (Tarone 1975): at each step, the trials that still run without
    a loop are compared over p. So trials of different length do not matter. The break is chosen from the first loops at
    each p, against those expected there if p had no influence. Standard errors are clustered.
    """
    levels = np.unique(counted.dose)
    if len(levels) < 3:
        return TwoLines()
    running, event = grid(counted.until_loop, counted.looped)
    here = (levels[:, None] == counted.dose).astype(np.float64)
    n, events, looped = running.sum(axis=0), event.sum(axis=0), here @ event.sum(axis=1)
    expected = here @ running @ (events / np.maximum(n, 1.0))
    steps = expected * n[events > 0].sum() / max(events.sum(), 1.0)  # as many as expect these first loops
    at = _robin_hood_break(Counts(levels, looped, np.maximum(np.maximum(looped, steps), 1.0)))
    lines = []
    for side in (counted.dose <= levels[at], counted.dose >= levels[at]):
        own = counted.at(side)
        found = excess(own.dose, own.until_loop, own.looped, own.cluster)
        z = round(found.total, 10) / found.error if found.error > 0 else 0.0
        lines.append(Line(z, 1.0 if found.p_value is None else found.p_value))
    return _two_lines_test(float(levels[at]), *lines)


def _score(counted: Counts) -> float:
    """The Cochran-Armitage score of a slope, in standard errors; 0 if nothing differs."""
    share = counted.solved.sum() / counted.n.sum()
    centred = counted.dose - np.average(counted.dose, weights=counted.n)
    variance = share * (1 - share) * np.sum(counted.n * centred**2)
    return float(counted.solved @ centred / math.sqrt(variance)) if variance > 0 else 0.0


def _clustered_p(p: Array, solved: NDArray[np.bool_], cluster: NDArray[np.int64]) -> float:
    """The two-sided P value of a slope's score where trials come in clusters."""
    order = np.lexsort((solved, p, cluster))  # so that sums do not hang on the order of trials
    centred, rest = (p - p.mean())[order], (solved - solved.mean())[order]
    sums = np.bincount(np.unique(cluster[order], return_inverse=True)[1], weights=centred * rest)
    k, independent = len(sums), float(solved.mean() * (1 - solved.mean()) * np.sum(centred**2))
    if k < 3 or not independent:
        return 1.0
    variance = max(independent, k / (k - 2) * float(np.sum(sums**2)))
    return float(student_tails(float(np.sum(sums)) / math.sqrt(variance), k - 2))


def _polynomial(counted: Counts, order: int) -> tuple[Array, Array, Array]:
    """A polynomial through empirical logits: coefficients, fitted logits, standard errors. It always exists."""
    yes, no = counted.solved + 0.5, counted.n - counted.solved + 0.5
    weight = 1 / (1 / yes + 1 / no)
    design = np.vander(counted.dose, order + 1, increasing=True)
    covariance = np.linalg.pinv(design.T @ (weight[:, None] * design))
    coefficients = covariance @ (design.T @ (weight * np.log(yes / no)))
    return coefficients, design @ coefficients, np.sqrt(np.einsum("ij,jk,ik->i", design, covariance, design))


def _robin_hood_break(counted: Counts) -> int:
    """The index of Simonsohn's Robin Hood break: in the flat region about the extremum, nearer to the clearer line.

    The flat region holds the inner values of p whose smooth fit lies within a standard error of the most extreme. The
    lines about its median have the strengths z1 and z2; the break is its quantile z2 / (z1 + z2).
    """
    bend = _polynomial(counted, 2)[0][2]
    _, fitted, error = _polynomial(counted, min(3, len(counted.dose) - 1))
    inner = np.sign(bend or 1.0) * fitted[1:-1]
    lowest = int(np.argmin(inner))
    flat = 1 + np.flatnonzero(inner <= inner[lowest] + error[1:-1][lowest])
    first, second = (abs(_score(side)) for side in counted.sides(int(flat[(len(flat) - 1) // 2])))
    quantile = second / (first + second) if first + second > 0 else 0.5
    return int(flat[max(0, math.ceil(quantile * len(flat) - 1e-9) - 1)])
