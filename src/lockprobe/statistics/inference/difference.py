"""Differences in success between the lowest dose and every other, or a control and conditions, corrected together.

An estimate, its interval and its P value use the same sample. An agent's sample holds the trials that both have: trials
of equal repetition and trial share their luck, and an unfinished study has some of them under one condition only.
People meet no luck twice; their sample is all trials, clustered by person. What holds at every look uses the blocks
that both have in the order of the plan; people come as they please, so their trials have no order.
Several boxes are clusters, which count alike (:mod:`lockprobe.statistics.boxes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.boxes import difference_over_boxes, pairs_by_box
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.clustered import ClusteredDifference, clustered_difference, share_of
from lockprobe.statistics.outcomes import Outcomes, boxes_of_blocks, joined, solved_in_pairs
from lockprobe.statistics.proportions import Paired, Proportion, between, paired, proportion
from lockprobe.statistics.sequential.contrasts import AtEveryLook, Numbers, at_every_look, held_at_both_ends
from lockprobe.statistics.sequential.shares import share_at_every_look

PERMUTATIONS = 2000

_PER_AGENT = 400
"""Permutations for each of the agents that are judged together: the smallest P value is a twentieth of the level."""

Array = NDArray[np.float64]
Groups = dict[tuple[int, ...], list[NDArray[np.bool_]]]

_TIE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferenceAt:
    """The difference in success between one p and the lowest p, in one sample of trials.

    Attributes:
        dose: Flip probability, [0, 1].
        first: Share of the compared trials solved at the lowest p.
        second: Share of the compared trials solved at this p.
        value: Success at this p minus success at the lowest p, [-1, 1], in trials that ended.
        low, high: Ends of the interval of ``value``; its level is 1 - 0.05 / (values of p compared with the lowest
            times agents judged together). If trials broke, it holds whatever became of them.
        pairs: The paired comparison of the trials that both p have; None for people.
        exchange: Permutation P value, corrected for all p (Westfall & Young's single-step maximum of differences in
            standard errors) and for the agents.
        p_value: The larger of ``exchange`` and the corrected P value of the interval, so that it is below 0.05 only if
            the interval excludes 0. If trials broke, the larger of both ends, and 1 if the signs differ.
        bounds: The least and the largest that the difference in all begun trials can be; None if no trial broke.
        course: The estimate after each block, if interval and P value hold at every look; None if at one alone.
    """

    dose: float
    first: Proportion
    second: Proportion
    value: float
    low: float
    high: float
    pairs: Paired | None
    exchange: float
    p_value: float
    bounds: tuple[float, float] | None = None
    course: AtEveryLook | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AnyDifference:
    """Whether success differs between values of p.

    Attributes:
        lowest: The reference p; None without trials.
        at: The other values of p that share trials with it, ascending.
        p_value: The smallest P value of ``at``, each corrected for all p and agents.
        agents: Agents that are judged together and for which ``at`` is corrected.
    """

    lowest: float | None
    at: tuple[DifferenceAt, ...]
    p_value: float | None
    agents: int = 1

    @property
    def clearest(self) -> DifferenceAt | None:
        """The difference with the smallest P value, and of equal ones the largest; None without one."""
        return min(self.at, key=lambda one: (one.p_value, -abs(one.value)), default=None)


def any_difference(
    outcomes: Outcomes, rng: np.random.Generator, permutations: int = PERMUTATIONS, *, agents: int = 1
) -> AnyDifference:
    """Test whether success depends on p, allowing for shared luck and for the choice of the best p.

    A finding must pass two tests. First a permutation of outcomes between the values of p of a cluster: its P value,
    ``(1 + those at least as extreme) / (1 + permutations)``, is exact for any shared luck if p changes nothing. But if
    p changes which trials are solved and not how many, it rejects in up to a third of studies. So, second, the interval
    of the difference (Bonferroni over all differences) must exclude 0.

    Several agents are one family: a sentence that says which of them change is false if one of its parts is. P values
    are multiplied by their number and intervals widened alike (Bonferroni; Hsu 1996, Multiple Comparisons, Ch. 1), so
    that a P value is below 0.05 only if its interval excludes 0. Holm's steps have no such intervals.

    Args:
        outcomes: The ended trials of one agent.
        rng: The stream of the permutations.
        permutations: Number of permutations; more are drawn for many agents, whose P values have to be smaller.
        agents: Number of agents that are judged together.
    """
    permutations = max(permutations, _PER_AGENT * agents)
    values, place = np.unique(outcomes.dose, return_inverse=True)
    lowest = float(values[0]) if len(values) else None
    if outcomes.order is not None and not outcomes.crossed:
        made = _at_every_look([outcomes.at(outcomes.dose == dose) for dose in values], agents)
        at = tuple(replace(one, dose=float(values[i])) for i, one in made)
        return _any(lowest, at, agents)
    groups = _groups(outcomes, place)
    apart = not any(len(set(labels)) > 1 for labels in groups)
    if apart and not (outcomes.crossed and len(values) > 1):
        return _any(lowest, (), agents)
    n = np.bincount(place).astype(np.float64)
    if apart:
        solved, size = _permuted_whole_clusters(outcomes, place, permutations, rng)
        away = compared = error = np.empty(0)
    else:
        solved, away, compared, error = _permuted_within_clusters(groups, len(values), permutations, rng)
        size = np.broadcast_to(n, solved.shape)
    if outcomes.crossed:
        away, compared = solved / size - (solved / size)[:, :1], n
        error = _error_of_shares(float(outcomes.solved.mean()), n)
    tested = np.flatnonzero(compared[1:] > 0) + 1
    scaled = np.abs(away) / error
    largest = scaled[:, tested].max(axis=1, initial=0.0)
    exchanged = {i: _share(largest[1:], float(scaled[0, i])) for i in tested.tolist()}
    at = tuple(
        _at(outcomes, (float(values[0]), float(values[i])), min(1.0, agents * exchange), choices=agents * len(tested))
        for i, exchange in exchanged.items()
    )
    return _any(lowest, at, agents)


def _any(lowest: float | None, at: tuple[DifferenceAt, ...], agents: int) -> AnyDifference:
    p_value = min((one.p_value for one in at), default=None)
    return AnyDifference(lowest=lowest, at=at, p_value=p_value, agents=agents)


def bounded_differences(found: AnyDifference, low: AnyDifference, high: AnyDifference) -> AnyDifference:
    """The differences without the broken trials, with what holds at both ends of what these can have become."""
    ends = [{one.dose: one for one in end.at} for end in (low, high)]
    at = tuple(_bounded(one, *(end[one.dose] for end in ends)) for one in found.at)
    return replace(found, at=at, p_value=min((one.p_value for one in at), default=None))


def _bounded(found: DifferenceAt, low: DifferenceAt, high: DifferenceAt) -> DifferenceAt:
    made = bounded(found, low, high)
    return replace(
        made,
        first=between(found.first, high.first, low.first),
        second=between(found.second, low.second, high.second),
        pairs=found.pairs and low.pairs and high.pairs and bounded(found.pairs, low.pairs, high.pairs),
        course=found.course and low.course and high.course and held_at_both_ends(found.course, low.course, high.course),
        exchange=1.0 if made.p_value == 1 else max(low.exchange, high.exchange),
        bounds=(low.value, high.value),
    )


def each_difference(
    groups: Sequence[Outcomes], rng: np.random.Generator, *, broken: Sequence[Outcomes] = (), agents: int = 1
) -> tuple[tuple[int, DifferenceAt], ...]:
    """Each group of trials against the first one, in the pairs of trials that the two share.

    A comparison looks at its own two groups alone, so that a further group changes its P value only by the number that
    it is corrected for (Bonferroni, with the agents). The P value is the larger of two: McNemar's exact one and that of
    the interval. With people it is that of a permutation clustered by person in place of McNemar's.

    Args:
        groups: The ended trials of one agent by condition, the control first.
        rng: The stream of the permutations, which only people need.
        broken: The trials of each that broke; none if not given.
        agents: Number of agents that are judged together.

    Returns:
        The place of each group that shares a trial with the first one, and the difference; its dose is that place.
    """
    found = _each_difference(groups, rng, agents)
    if not any(map(len, broken)):
        return found
    # a condition without an ended trial is in no comparison
    begun = [one if len(group) else one.at(np.zeros(len(one), bool)) for one, group in zip(broken, groups, strict=True)]
    gains = [i > 0 for i in range(len(groups))]
    ends = [dict(end) for end in opposed(lambda of: _each_difference(of, rng, agents), groups, begun, gains)]
    return tuple((i, _bounded(one, *(end[i] for end in ends))) for i, one in found)


def _each_difference(
    groups: Sequence[Outcomes], rng: np.random.Generator, agents: int
) -> tuple[tuple[int, DifferenceAt], ...]:
    pairs = {i: joined([groups[0], one]) for i, one in enumerate(groups) if i and len(one) and len(groups[0])}
    if any(together.crossed for together in pairs.values()):
        found = {i: any_difference(together, rng, agents=agents * len(pairs)) for i, together in pairs.items()}
        return tuple((i, replace(one, dose=float(i))) for i, tested in found.items() for one in tested.at)
    if groups[0].order is not None:
        return _at_every_look(groups, agents)
    shared = {i: together for i, together in pairs.items() if len(solved_in_pairs(groups[0], groups[i]))}
    made = {i: _at(together, (0.0, 1.0), choices=agents * len(shared)) for i, together in shared.items()}
    return tuple((i, replace(one, dose=float(i))) for i, one in made.items())


def _at_every_look(groups: Sequence[Outcomes], agents: int) -> tuple[tuple[int, DifferenceAt], ...]:
    """The same as :func:`each_difference` without broken trials, as it holds at every look."""
    if not groups or (order := groups[0].order) is None:
        return ()
    first, *others = (
        dict(zip(order.rank(one.repetition, one.trial).tolist(), one.solved.tolist(), strict=True)) for one in groups
    )
    blocks = {i: sorted(first.keys() & own.keys()) for i, own in enumerate(others, 1)}
    solved = {
        i: np.array([[own[block] for own in (first, others[i - 1])] for block in both], dtype=np.bool_)
        for i, both in blocks.items()
        if both
    }
    family = [
        Numbers(values=own[:, 1].astype(np.float64) - own[:, 0], block=np.array(blocks[i], dtype=np.int64))
        for i, own in solved.items()
    ]
    courses = at_every_look(family, agents=agents, margin=order.margin) if family else ()
    found = []
    for (i, own), course in zip(solved.items(), courses, strict=True):
        pairs = replace(paired(own[:, 0], own[:, 1]), low=course.low, high=course.high, p_value=course.p_value)
        before, after = (share_at_every_look(column) for column in own.T)
        found.append((i, _of_pairs(float(i), pairs, before, after, pairs.p_value, pairs.p_value, course)))
    return tuple(found)


def _of_pairs(
    dose: float,
    found: Paired | ClusteredDifference,
    first: Proportion,
    second: Proportion,
    exchange: float,
    p_value: float,
    course: AtEveryLook | None = None,
) -> DifferenceAt:
    return DifferenceAt(
        dose=dose, first=first, second=second, value=found.value, low=found.low, high=found.high,
        pairs=found if isinstance(found, Paired) else None, exchange=exchange, p_value=p_value, course=course,
    )  # fmt: skip


def _at(outcomes: Outcomes, both: tuple[float, float], exchange: float | None = None, *, choices: int) -> DifferenceAt:
    """The difference between two doses, from the trials that can be compared; McNemar's test without a permutation."""
    together = outcomes.at(np.isin(outcomes.dose, both))
    later = together.dose == both[1]
    if outcomes.crossed:
        found: Paired | ClusteredDifference = clustered_difference(
            together.solved, later, together.player, together.luck, choices=choices
        )
        shares = [together.solved[~later], together.solved[later]]
    else:
        groups = together.at(~later), together.at(later)
        solved, box = solved_in_pairs(*groups), boxes_of_blocks(*groups)
        shares = list(solved.T)
        found = paired(shares[0], shares[1], choices=choices)
        if len(box):
            return _over_boxes(float(both[1]), found, solved, box, exchange, choices)
    first, second = (proportion(int(one.sum()), len(one)) for one in shares)
    if exchange is None:
        assert isinstance(found, Paired), "people are compared by a permutation"
        exchange = min(1.0, choices * found.p_value)
    return _of_pairs(
        float(both[1]), found, first, second, exchange, max(exchange, min(1.0, choices * found.interval_p))
    )


def _over_boxes(
    dose: float,
    found: Paired,
    solved: NDArray[np.bool_],
    box: NDArray[np.str_],
    exchange: float | None,
    choices: int,
) -> DifferenceAt:
    """The difference with boxes as clusters (:mod:`lockprobe.statistics.boxes`)."""
    over = difference_over_boxes(pairs_by_box(solved, box), choices=choices)
    tested = min(1.0, choices * found.p_value) if exchange is None else exchange
    first, second = (share_of(column, (), (), box) for column in solved.T)
    pairs = replace(found, value=over.value, low=over.low, high=over.high)
    return _of_pairs(dose, pairs, first, second, tested, max(tested, min(1.0, choices * over.interval_p)))


def _groups(outcomes: Outcomes, place: NDArray[np.intp]) -> Groups:
    """Clusters grouped by the values of p at which they have trials: one array of outcomes per cluster."""
    clusters = outcomes.cluster
    order = np.lexsort((place, clusters))
    groups: Groups = {}
    for rows in np.split(order, np.flatnonzero(np.diff(clusters[order])) + 1):
        groups.setdefault(tuple(place[rows].tolist()), []).append(outcomes.solved[rows])
    return groups


def _permuted_within_clusters(
    groups: Groups, places: int, permutations: int, rng: np.random.Generator
) -> tuple[Array, Array, Array, Array]:
    """Outcomes permuted within clusters; the first row is as observed.

    Returns:
        Solved trials per p, shape (1 + permutations, values); share solved at each p minus that at the first p, over
        the clusters that have both, of the same shape; number of such clusters, shape (values,); standard error of
        these differences, with one more cluster that differs, of the same shape.
    """
    solved, away = np.zeros((2, 1 + permutations, places))
    both, variance = np.zeros((2, places))
    for labels, rows in groups.items():
        members, at = np.array(rows), list(labels)
        found = np.vstack([members.sum(axis=0), _permuted(members, permutations, rng)])
        solved += found @ np.eye(places)[at]
        if len(at) > 1 and at[0] == 0:
            away += (found - found[:, :1]) @ np.eye(places)[at]
            both[at] += len(members)
            count = members.sum(axis=1)
            variance[at] += float(np.sum(2 * count * (len(at) - count))) / (len(at) * (len(at) - 1))
    most = np.maximum(both, 1)
    return solved, away / most, both, np.sqrt(variance + 1) / most


def _error_of_shares(share: float, n: Array) -> Array:
    """The standard error of the difference of each share from the first, with one more trial that differs at either.

    Without that trial a p with few trials, whose differences are large by chance, would hide every effect beside it.
    """
    error: Array = np.sqrt(share * (1 - share) * (1 / n + 1 / n[0]) + 1 / n**2 + 1 / n[0] ** 2)
    return error


def _permuted(members: NDArray[np.bool_], permutations: int, rng: np.random.Generator) -> Array:
    """Solved trials per p, shape (permutations, values), after shuffling each cluster of (clusters, values)."""
    varied = members[members.any(axis=1) & ~members.all(axis=1)].astype(np.uint8)
    shuffled: NDArray[np.uint8] = rng.permuted(np.broadcast_to(varied, (permutations, *varied.shape)), axis=2)
    totals: Array = shuffled.sum(axis=1, dtype=np.float64)
    return totals + np.count_nonzero(members.all(axis=1))


def _permuted_whole_clusters(
    outcomes: Outcomes, place: NDArray[np.intp], permutations: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Solved trials and trials per p, after shuffling whole clusters among the values of p.

    Both have the shape (1 + permutations, values); the first row is as observed.
    """
    clusters = outcomes.cluster
    _, first, sizes = np.unique(clusters, return_index=True, return_counts=True)
    labels = place[first]
    shuffled = np.vstack([labels, rng.permuted(np.broadcast_to(labels, (permutations, len(labels))), axis=1)])
    member = (shuffled[..., None] == np.arange(int(place.max()) + 1)).swapaxes(1, 2)
    return member @ np.bincount(clusters, weights=outcomes.solved), member @ (1.0 * sizes)


def _share(drawn: Array, observed: float) -> float:
    return float((1 + np.count_nonzero(drawn >= observed - _TIE)) / (1 + len(drawn)))
