"""Which p is best, how sure that is, and whether p matters at all once one has looked for the best.

Trials of equal repetition and trial share their luck over p: a cluster. The bootstrap draws clusters within their
repetition; the permutation test exchanges values of p inside clusters only. Of people a cluster is one person; where
everybody plays at one p, whole people are exchanged between the values of p.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.outcomes import Outcomes
from lockprobe.analysis.resample import RESAMPLES, drawn_shares, times_drawn

__all__ = ["AnyDifference", "Candidate", "DifferenceAt", "Peak", "any_difference", "peak"]

PERMUTATIONS = 2000

Array = NDArray[np.float64]
Clusters = NDArray[np.int64]

_TIE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One value of p as the place of the highest success.

    Attributes:
        p: Flip probability, [0, 1].
        n: Trials.
        success: Share solved, [0, 1].
        share: Share of resamples in which it is the best, ties split, [0, 1]; None without resamples.
        in_set: Whether it belongs to the 95 % set of the best.
    """

    p: float
    n: int
    success: float
    share: float | None
    in_set: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Peak:
    """Where success is highest.

    Attributes:
        candidates: Every value of p, rising.
        best: The value with the highest share solved, the lowest of them in a tie; None without trials.
        success: Share solved there, [0, 1]. The best of several is seen too high: the winner's curse.
        curse: By how much, on average over resamples: the best share of a resample less the observed share there.
        honest: ``success - curse``. In simulations of 30 trials at each of seven p, none far above the rest, the
            best was seen 0.04 to 0.12 too high and this lay 0.01 to 0.05 too high. It errs less than choosing on one
            half of the trials and looking at the other.
        turning: Where the parabola through the shares is highest within the range of p.
        turning_low: 2.5th percentile over resamples.
        turning_high: 97.5th percentile.
        note: Why something is missing, in words.
    """

    candidates: tuple[Candidate, ...]
    best: float | None
    success: float | None
    curse: float | None
    honest: float | None
    turning: float | None
    turning_low: float | None
    turning_high: float | None
    note: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferenceAt:
    """Success at one p against the lowest p.

    Attributes:
        p: Flip probability, [0, 1].
        value: Success there less success at the lowest p, [-1, 1].
        p_value: Adjusted for having looked at every p (Westfall & Young's single-step maximum).
    """

    p: float
    value: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AnyDifference:
    """Whether success differs between values of p.

    Attributes:
        lowest: The p that the others are compared with; None without trials.
        at: The other values, rising.
        p_value: Of the largest difference from the lowest p, in either direction: the smallest of the adjusted ones.
        omnibus: p-value of ``sum n_p (success_p - success)^2``, which looks at every pair of values.
        permutations: How many were drawn.
        note: Why there is no test, in words.
    """

    lowest: float | None
    at: tuple[DifferenceAt, ...]
    p_value: float | None
    omnibus: float | None
    permutations: int
    note: str


def any_difference(outcomes: Outcomes, rng: np.random.Generator, permutations: int = PERMUTATIONS) -> AnyDifference:
    """Test whether false reports change success, whatever luck the trials share and whichever p turned out best.

    Under the null hypothesis the outcomes of a cluster could be exchanged between its values of p. They are, at
    random, and ``(1 + those at least as extreme) / (1 + permutations)`` is the p-value. That is exact whether the luck
    decides all, some or nothing. If p changes which trials are solved, but not how many, the hypothesis is false
    too, and the test may say so: it then rejects in 4 to 14 % of studies.

    Args:
        outcomes: The ended trials of one agent.
        rng: The stream of the permutations.
        permutations: How many to draw.
    """
    values, place = np.unique(outcomes.p, return_inverse=True)
    lowest = float(values[0]) if len(values) else None
    clusters = outcomes.cluster
    order = np.lexsort((place, clusters))
    groups: dict[tuple[int, ...], list[NDArray[np.bool_]]] = {}
    for rows in np.split(order, np.flatnonzero(np.diff(clusters[order])) + 1):
        groups.setdefault(tuple(place[rows].tolist()), []).append(outcomes.solved[rows])
    apart = not any(len(set(labels)) > 1 for labels in groups)
    if apart and not (outcomes.of_people and len(values) > 1):
        note = "No test: no two values of p were met by the same trial."
        return AnyDifference(lowest=lowest, at=(), p_value=None, omnibus=None, permutations=0, note=note)
    n = np.bincount(place).astype(np.float64)
    observed = np.bincount(place, weights=outcomes.solved)
    if apart:
        drawn, sizes = _whole(place, clusters, outcomes.solved, permutations, rng)
    else:
        drawn, sizes = np.zeros((permutations, len(values))), n
        for labels, members in groups.items():
            drawn += _permuted(np.array(members), permutations, rng) @ np.eye(len(values))[list(labels)]
    success = np.vstack([observed / n, drawn / sizes])
    away = success[:, 1:] - success[:, :1]
    largest = np.abs(away).max(axis=1)
    spread = (n * (success - observed.sum() / n.sum()) ** 2).sum(axis=1)
    at = tuple(
        DifferenceAt(p=float(p), value=float(value), p_value=_share(largest[1:], abs(value)))
        for p, value in zip(values[1:], away[0], strict=True)
    )
    return AnyDifference(
        lowest=lowest,
        at=at,
        p_value=min(difference.p_value for difference in at),
        omnibus=_share(spread[1:], spread[0]),
        permutations=permutations,
        note="",
    )


def peak(outcomes: Outcomes, rng: np.random.Generator, resamples: int = RESAMPLES) -> Peak:
    """Find where success is highest, and how sure that is.

    A value of p leaves the 95 % set when the best of the others lies further above it than in 95 % of resamples whose
    differences are centred (Hsu's comparison with the best, by bootstrap). It held the true best in 95 to 100 % of
    simulated studies; the fewest values whose shares of resamples make up 95 % held it in 60 to 100 %.

    Args:
        outcomes: The ended trials of one agent.
        rng: The stream of the bootstrap.
        resamples: How many to draw.
    """
    values, place = np.unique(outcomes.p, return_inverse=True)
    if not len(values):
        return _peak(values, np.empty(0), np.empty(0), np.empty((0, 0)), "No peak: there are no trials.")
    n = np.bincount(place).astype(np.float64)
    success = np.bincount(place, weights=outcomes.solved) / n
    times = times_drawn(outcomes, rng, resamples)
    if times is None:
        note = "No resamples: trials are drawn within their repetition, and one has a single trial."
        return _peak(values, n, success, np.empty((0, len(values))), note)
    return _peak(values, n, success, drawn_shares(times, outcomes.cluster, place, outcomes.solved), "")


def _permuted(members: NDArray[np.bool_], permutations: int, rng: np.random.Generator) -> Array:
    """Solved trials per place, shape (permutations, places), each cluster of (clusters, places) shuffled by itself."""
    varied = members[members.any(axis=1) & ~members.all(axis=1)].astype(np.uint8)
    shuffled: NDArray[np.uint8] = rng.permuted(np.broadcast_to(varied, (permutations, *varied.shape)), axis=2)
    totals: Array = shuffled.sum(axis=1, dtype=np.float64)
    return totals + np.count_nonzero(members.all(axis=1))


def _whole(
    place: NDArray[np.intp], clusters: Clusters, solved: NDArray[np.bool_], permutations: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Solved trials and trials per place, both (permutations, places), whole clusters shuffled among the places."""
    _, first, sizes = np.unique(clusters, return_index=True, return_counts=True)
    labels = np.broadcast_to(place[first], (permutations, len(first)))
    shuffled = rng.permuted(labels, axis=1)[..., None] == np.arange(int(place.max()) + 1)
    return shuffled.swapaxes(1, 2) @ np.bincount(clusters, weights=solved), shuffled.swapaxes(1, 2) @ (1.0 * sizes)


def _share(drawn: Array, observed: float) -> float:
    return float((1 + np.count_nonzero(drawn >= observed - _TIE)) / (1 + len(drawn)))


def _peak(values: Array, n: Array, success: Array, drawn: Array, note: str) -> Peak:
    best = int(np.argmax(success)) if len(values) else None
    share, in_set, curse, low, high = None, None, None, None, None
    if len(drawn):
        leads = drawn >= drawn.max(axis=1, keepdims=True) - _TIE
        leads = leads / leads.sum(axis=1, keepdims=True)
        centred = drawn - success
        share, curse = leads.mean(axis=0), float(np.mean(np.sum(leads * centred, axis=1)))
        needed = np.percentile(centred.max(axis=1, keepdims=True) - centred, 95, axis=0)
        in_set = success.max() - success <= needed + _TIE
    turning = float(_highest(values, success[None])[0]) if len(values) >= 3 else None
    if len(drawn) and turning is not None:
        low, high = np.percentile(_highest(values, drawn), [2.5, 97.5]).tolist()
    return Peak(
        candidates=tuple(
            Candidate(
                p=float(p),
                n=int(n[i]),
                success=float(success[i]),
                share=None if share is None else float(share[i]),
                in_set=None if in_set is None else bool(in_set[i]),
            )
            for i, p in enumerate(values)
        ),
        best=None if best is None else float(values[best]),
        success=None if best is None else float(success[best]),
        curse=curse,
        honest=None if best is None or curse is None else float(success[best]) - curse,
        turning=turning,
        turning_low=low,
        turning_high=high,
        note=note,
    )


def _highest(values: Array, shares: Array) -> Array:
    """Where least-squares parabolas through rows of shares are highest within the range of p; the lower end if flat."""
    _, slope, bend = (shares @ np.linalg.pinv(np.vander(values, 3, increasing=True)).T).T
    low, high = values[0], values[-1]
    ends = np.where(slope * (high - low) + bend * (high**2 - low**2) > _TIE, high, low)
    inner: Array = np.clip(-slope / np.where(bend < -_TIE, 2 * bend, 1.0), low, high)
    return np.where(bend < -_TIE, inner, ends)
