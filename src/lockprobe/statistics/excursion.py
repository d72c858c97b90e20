"""The effect of one false report: causal excursion effects from the records of a flip study.

Every report of a flip study was inverted by a coin of known probability, so a study with 0 < p < 1 is a
micro-randomised trial (Klasnja et al. 2015; Boruvka, Almirall, Witkiewitz and Murphy 2018). A *decision point* is a
report after which the trial goes on. The effect of one lie there, with the other reports as they come in the study, is
estimated by least squares of an outcome on a few covariates and on the centred coin, flip - p. The covariates only make
it more precise: the estimate is right whatever they miss, since the coin depends on nothing. Standard errors are
clustered by luck, with residuals corrected for their leverage (Mancl and DeRouen 2001), and used with Student's t.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.rationality import judge, prior_for
from lockprobe.trial.record import Trial
from lockprobe.trial.told_outcome import false_reports

__all__ = [
    "FEWEST",
    "SOON",
    "Among",
    "DecisionPoints",
    "Excursion",
    "Excursions",
    "NotEstimated",
    "Outcome",
    "continuation",
    "decision_points",
    "excursion",
    "excursions",
]

Array = NDArray[np.float64]

Outcome = Literal["repeats", "new", "leaves", "optimal", "soon", "solved"]
"""The next action is that of this step; the next joint was not attempted in that state before; the next action is not
the one that continues the loop (in a loop alone); the next action is optimal for an ideal observer who was told the
same and believes it (:mod:`lockprobe.statistics.rationality`; boxes of at most six joints); the box is solved within
three steps; the box is solved at all."""

Among = Literal["all", "false moved", "false blocked", "in a loop", "elsewhere"]
"""Decision points: all; those at which the joint was truly blocked, or truly moved; in an action loop, or not."""

SOON = 3
"""Steps within which ``soon`` has to happen."""

_LOOP = 3
"""Actions that are in a loop if they have stood in this order before, without overlap."""

_AT_ONCE = 50_000
"""Rows of a design whose squares are held at once."""

FEWEST = 15
"""Trials that must hold the outcome, and as many that must miss it. With fewer than 15 unsolved trials intervals of
the strategy ``human-inspired`` cover the exact effect in 82 % of studies, with 15 or more in 92 to 95 %."""

_POWER = 0.8416
"""The normal quantile of a power of 80 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionPoints:
    """Decision points: the reports after which a trial went on, one row each; columns have the shape (points,).

    Attributes:
        flipped: Whether the report was false.
        p: The probability that it was false, (0, 1).
        step: From 1.
        moved: Whether the joint truly moved.
        looping: Whether the last three actions have stood in this order before.
        cluster: Trials that share their luck, or their player, from 0.
        outcomes: Outcome -> 1 if it happened, 0 if not, NaN if it does not apply.
    """

    flipped: NDArray[np.bool_]
    p: Array
    step: Array
    moved: NDArray[np.bool_]
    looping: NDArray[np.bool_]
    cluster: NDArray[np.int64]
    outcomes: dict[Outcome, Array]

    def __len__(self) -> int:
        return len(self.p)


@dataclass(frozen=True, slots=True, kw_only=True)
class Excursion:
    """The effect of one false report on an outcome, averaged over decision points.

    Attributes:
        outcome: The outcome.
        among: The subset of decision points.
        effect: Change of the probability of the outcome, [-1, 1].
        low: Lower end of its 95 % interval.
        high: Upper end.
        p_value: Student's t, two-sided; like the interval, corrected for the agents that are judged together
            (Bonferroni) and for nothing else.
        standard_error: Clustered by luck.
        points: Number of decision points.
        clusters: Number of clusters of luck.
        freedom: Degrees of freedom of Student's t.
        smallest: Minimum detectable effect: the effect that this standard error detects with a power of 80 %.
    """

    outcome: Outcome
    among: Among
    effect: float
    low: float
    high: float
    p_value: float
    standard_error: float
    points: int
    clusters: int
    freedom: int
    smallest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NotEstimated:
    """An effect that is left out.

    Attributes:
        outcome: The outcome.
        among: The subset of decision points.
        reason: Why, in words.
    """

    outcome: Outcome
    among: Among
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Excursions:
    """The effects of one false report.

    Attributes:
        points: The number of decision points.
        estimates: The effects.
        left_out: Those that cannot be estimated.
        agents: The number of agents that are judged together.
    """

    points: int
    estimates: tuple[Excursion, ...]
    left_out: tuple[NotEstimated, ...]
    agents: int = 1

    def corrected(self, agents: int) -> Excursions:
        """The same effects, judged together with those of other agents.

        Args:
            agents: The number of agents, this one among them.
        """
        estimates = tuple(
            replace(one, **_one_of(agents, one.effect, one.standard_error, one.freedom)) for one in self.estimates
        )
        return replace(self, agents=agents, estimates=estimates)


def decision_points(trials: Iterable[Trial]) -> DecisionPoints:
    """The decision points of trials whose reports were flipped with a probability above 0 and below 1.

    Trials that ended as error and withheld reports are left out.
    """
    rows, lucks, counts = array("d"), list[str](), list[int]()  # of a million trials, tuples would take a gigabyte
    for trial in trials:
        if trial.p is None or not 0 < trial.p < 1 or trial.ending == "error":
            continue
        told = [row for row, step in zip(_rows(trial), trial.steps, strict=False) if step.told_moved is not None]
        if told:
            rows.extend(number for row in told for number in (trial.p, *row))
            lucks.append(trial.player or f"{trial.repetition}/{trial.trial}")
            counts.append(len(told))
    table = np.array(rows).reshape(-1, 5 + len(get_args(Outcome)))
    cluster = np.repeat(np.unique(np.array(lucks, dtype=np.str_), return_inverse=True)[1].reshape(-1), counts)
    p, flipped, step, moved, looping, *happened = table.T
    return DecisionPoints(
        flipped=flipped > 0,
        p=p,
        step=step,
        moved=moved > 0,
        looping=looping > 0,
        cluster=cluster.astype(np.int64),
        outcomes=dict(zip(get_args(Outcome), happened, strict=True)),
    )


def _rows(trial: Trial) -> Iterable[tuple[float, ...]]:
    """Every report but the last: whether it was false, its step, the truth, the loop, and what came of it."""
    actions, steps = trial.actions, trial.steps
    tried = {(steps[0].state, steps[0].joint)} if steps else set()
    false, optimal = false_reports(trial), _optimal(trial)
    for i in range(len(steps) - 1):
        on = continuation(actions[: i + 1])
        after = steps[i + 1]
        place = after.state, after.joint
        end = i + 1 + SOON
        soon = float(trial.solved and len(steps) <= end) if end <= trial.budget else np.nan
        yield (
            float(false[i]),
            i + 1,
            float(steps[i].moved),
            float(on is not None),
            float(after.joint == steps[i].joint),
            float(place not in tried),
            np.nan if on is None else float(after.joint != on),
            optimal[i + 1],
            soon,
            float(trial.solved),
        )
        tried.add(place)


def _optimal(trial: Trial) -> list[float]:
    """Whether each action is optimal for an observer who believes every report; NaN if it cannot be judged."""
    prior = prior_for(len(trial.joints))
    if prior is None or not trial.steps or not trial.ordinary:
        return [np.nan] * len(trial.steps)
    return [float(step.optimal) for step in judge(trial, prior=prior).steps]


def continuation(actions: tuple[str, ...]) -> str | None:
    """The action that continues a loop: what followed the latest earlier copy of the last three; None without one."""
    last = actions[-_LOOP:]
    for start in range(len(actions) - 2 * _LOOP, -1, -1):
        if len(last) == _LOOP and actions[start : start + _LOOP] == last:
            return actions[start + _LOOP]
    return None


def excursions(points: DecisionPoints) -> Excursions:
    """The effect of one lie on every outcome: over all points, by kind of lie, and inside or outside loops.

    Effects that cannot be estimated are left out, each with its reason.
    """
    everywhere = np.ones(len(points), dtype=np.bool_)
    among: dict[Among, NDArray[np.bool_]] = {
        "all": everywhere,
        "false moved": ~points.moved,
        "false blocked": points.moved,
        "in a loop": points.looping,
        "elsewhere": ~points.looping,
    }
    found: list[Excursion | NotEstimated] = []
    for outcome in get_args(Outcome):
        for name, chosen in among.items():
            if outcome == "leaves" and name in ("in a loop", "elsewhere"):
                continue
            found.append(excursion(points, outcome, chosen, name))
    return Excursions(
        points=len(points),
        estimates=tuple(one for one in found if isinstance(one, Excursion)),
        left_out=tuple(one for one in found if isinstance(one, NotEstimated)),
    )


def excursion(
    points: DecisionPoints,
    outcome: Outcome,
    chosen: NDArray[np.bool_],
    among: Among = "all",
) -> Excursion | NotEstimated:
    """The effect of one lie on an outcome over a subset of decision points.

    Args:
        points: Decision points.
        outcome: The outcome.
        chosen: The subset, shape (points,), chosen by facts known before the coin toss.
        among: Name of the subset.

    Returns:
        Why there is no estimate: too few trials (:data:`FEWEST`), too few clusters, or a cluster that alone carries a
        covariate, so that its residuals say nothing of the error.
    """

    def without(reason: str) -> NotEstimated:
        return NotEstimated(outcome=outcome, among=among, reason=reason)

    y = points.outcomes[outcome]
    kept = chosen & ~np.isnan(y)
    y, p, step, cluster = y[kept], points.p[kept], points.step[kept], points.cluster[kept]
    doses, dose = np.unique(p, return_inverse=True)
    trial = cluster * len(doses) + dose
    if min(len(np.unique(trial[y == happened])) for happened in (0, 1)) < FEWEST:
        return without(f"fewer than {FEWEST} trials hold the outcome, or miss it")
    coin = points.flipped[kept] - p
    late = step / 10 - 1
    columns = [np.ones_like(y), late, late**2, p, points.moved[kept], points.looping[kept], coin]
    design = np.column_stack([column.astype(np.float64) for column in columns])
    design = design[:, [np.ptp(column) != 0 or i in (0, 6) for i, column in enumerate(design.T)]]
    clusters = len(np.unique(cluster))
    freedom = clusters - design.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(design) < design.shape[1]:
        return without("too few blocks for the covariates")
    if (found := _least_squares(design, y, cluster)) is None:
        return without("a covariate varies in one block alone")
    effect, error = found
    return Excursion(
        outcome=outcome,
        among=among,
        effect=effect,
        standard_error=error,
        points=len(y),
        clusters=clusters,
        freedom=freedom,
        **_one_of(1, effect, error, freedom),
    )


def _one_of(agents: int, effect: float, error: float, freedom: int) -> dict[str, Any]:
    """The interval, P value and detectable effect of one of so many agents, as fields of :class:`Excursion`."""
    reach = student_quantile(1 - ALPHA / 2 / agents, freedom)
    return {
        "low": max(-1.0, effect - reach * error),
        "high": min(1.0, effect + reach * error),
        "p_value": min(1.0, agents * student_tails(effect / error, freedom)) if error else 1.0,
        "smallest": (reach + _POWER) * error,
    }


def _moments_by_cluster(design: Array, first: NDArray[np.intp]) -> Iterator[Array]:
    """X_i' X_i of every cluster, shape (clusters, columns, columns), of some clusters at a time, which saves memory.

    Args:
        design: Rows by cluster, shape (points, columns).
        first: The first row of each cluster.
    """
    ends, many = np.append(first, len(design)), max(1, _AT_ONCE * len(first) // len(design))
    for i in range(0, len(first), many):
        begin, end = ends[i], ends[min(i + many, len(first))]
        rows = design[begin:end]
        yield np.add.reduceat(rows[:, :, None] * rows[:, None, :], first[i : i + many] - begin)


def _least_squares(design: Array, y: Array, cluster: NDArray[np.int64]) -> tuple[float, float] | None:
    """The last coefficient and its standard error, clustered, from residuals corrected for their leverage.

    None if the design loses rank without one of the clusters: that cluster is fitted exactly in some direction, and its
    residuals cannot be corrected.

    With X_i the rows of a cluster and e_i their residuals, its corrected score is X_i' (I - X_i M^-1 X_i')^-1 e_i. By
    Woodbury's identity that is M (M - X_i' X_i)^-1 X_i' e_i, with M = X'X: matrices as small as the design is wide.
    """
    order = np.argsort(cluster, kind="stable")
    first = np.flatnonzero(np.diff(cluster[order], prepend=cluster[order][0] - 1))
    design, y = design[order], y[order]
    moments = design.T @ design
    inverse = np.linalg.inv(moments)
    coefficients = inverse @ design.T @ y
    own = np.concatenate(list(_moments_by_cluster(design, first)))
    score = np.add.reduceat(design * (y - design @ coefficients)[:, None], first)
    if (np.linalg.matrix_rank(moments - own, hermitian=True) < design.shape[1]).any():
        return None
    corrected = np.linalg.solve(moments - own, score[:, :, None])[:, :, 0]  # inverse @ the corrected score
    return float(coefficients[-1]), float(np.sqrt(np.sum(corrected[:, -1] ** 2)))
