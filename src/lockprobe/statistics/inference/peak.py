"""The p of highest success, and its uncertainty.

The bootstrap draws clusters within their repetition: trials of equal repetition and trial, or of one person.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import normal_quantile, student_quantile
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.resample import RESAMPLES, drawn_shares

__all__ = ["Candidate", "Peak", "peak"]

Array = NDArray[np.float64]

_TIE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One value of p as a candidate for the peak of success.

    Attributes:
        dose: Flip probability, [0, 1].
        n: Trials.
        success: Share solved, [0, 1].
        share: Share of resamples in which it is the best, ties split, [0, 1]; None without resamples.
        in_set: Whether it belongs to the 95 % confidence set of the best.
    """

    dose: float
    n: int
    success: float
    share: float | None
    in_set: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Peak:
    """The peak: the p of highest success, its bias and its uncertainty.

    Attributes:
        candidates: Every value of p, ascending.
        best: The value with the highest share solved, the lowest of them in a tie; None without trials.
        success: Share solved there, [0, 1]; too high on average, as the best of several (the winner's curse).
        curse: That bias: mean over resamples of the best share less the observed share there.
        honest: ``success - curse``. In simulations of 30 trials at each of seven p, none far above the rest, the best
            was seen 0.04 to 0.12 too high and this lay 0.01 to 0.05 too high.
        turning: The p at which a parabola through the shares is highest, within the range of p.
        turning_low, turning_high: 2.5th and 97.5th percentiles over resamples.
        note: Why something is missing, as a short code; empty if nothing is.
    """

    candidates: tuple[Candidate, ...] = ()
    best: float | None = None
    success: float | None = None
    curse: float | None = None
    honest: float | None = None
    turning: float | None = None
    turning_low: float | None = None
    turning_high: float | None = None
    note: str = ""


def peak(outcomes: Outcomes, rng: np.random.Generator, resamples: int = RESAMPLES) -> Peak:
    """Find the p of an agent's highest success, with its uncertainty from bootstrap resamples of its ended trials.

    A value of p leaves the 95 % set when another lies further above it, in standard errors, than in 95 % of resamples
    with centred differences (Hsu's comparison with the best, by bootstrap). The set held the true best in 92 to 100 %
    of simulated studies; the fewest values whose shares of resamples add up to 95 % held it in 60 to 100 %.
    """
    values, place = np.unique(outcomes.dose, return_inverse=True)
    if not len(values):
        return Peak(note="no trials")
    n = np.bincount(place).astype(np.float64)
    success = np.bincount(place, weights=outcomes.solved) / n
    found = drawn_shares(outcomes, place, outcomes.solved, rng=rng, resamples=resamples)
    if found is None:
        return _peak(values, n, success, np.empty((0, len(values))), "no resamples", 1.0)
    wider = _wider(int(outcomes.cluster.max()) + 1, len(np.unique(outcomes.stratum)))
    return _peak(values, n, success, found[0], "", wider)


def _wider(clusters: int, strata: int) -> float:
    """How much too narrow resamples of few clusters are: their variance, and Student's quantile over the normal one."""
    return float(
        np.sqrt(clusters / (clusters - strata)) * student_quantile(0.975, clusters - strata) / normal_quantile(0.975)
    )


def _peak(values: Array, n: Array, success: Array, drawn: Array, note: str, wider: float) -> Peak:
    best = int(np.argmax(success))
    share, in_set, curse, low, high = None, None, None, None, None
    if len(drawn):
        leads = drawn >= drawn.max(axis=1, keepdims=True) - _TIE
        leads = leads / leads.sum(axis=1, keepdims=True)
        centred = drawn - success
        share, curse = leads.mean(axis=0), float(np.mean(np.sum(leads * centred, axis=1)))
        in_set = [_may_be_best(i, success, wider * centred, n) for i in range(len(values))]
    turning = float(_highest(values, success[None])[0]) if len(values) >= 3 else None
    if len(drawn) and turning is not None:
        low, high = np.percentile(_highest(values, drawn), [2.5, 97.5]).tolist()
    return Peak(
        candidates=tuple(
            Candidate(
                dose=float(p),
                n=int(n[i]),
                success=float(success[i]),
                share=None if share is None else float(share[i]),
                in_set=None if in_set is None else bool(in_set[i]),
            )
            for i, p in enumerate(values)
        ),
        best=float(values[best]),
        success=float(success[best]),
        curse=curse,
        honest=None if curse is None else float(success[best]) - curse,
        turning=turning,
        turning_low=low,
        turning_high=high,
        note=note,
    )


def _may_be_best(place: int, success: Array, centred: Array, n: Array) -> bool:
    """Whether no value of p lies further above this one, in standard errors, than in 95 % of centred resamples.

    A standard error counts one more trial that differs at either p, so that a p with few trials neither leaves the set
    by chance nor keeps all others in it.
    """
    others = np.arange(len(n)) != place
    away = centred[:, others] - centred[:, [place]]
    error = np.sqrt(np.mean(away**2, axis=0) + 1 / n[others] ** 2 + 1 / n[place] ** 2)
    needed = np.percentile((away / error).max(axis=1, initial=0.0), 95)
    return bool(((success[others] - success[place]) / error).max(initial=0.0) <= needed + _TIE)


def _highest(values: Array, shares: Array) -> Array:
    """The p at which least-squares parabolas through rows of shares peak; the lowest p for a flat row."""
    _, slope, bend = (shares @ np.linalg.pinv(np.vander(values, 3, increasing=True)).T).T
    low, high = values[0], values[-1]
    ends = np.where(slope * (high - low) + bend * (high**2 - low**2) > _TIE, high, low)
    inner: Array = np.clip(-slope / np.where(bend < -_TIE, 2 * bend, 1.0), low, high)
    return np.where(bend < -_TIE, inner, ends)
