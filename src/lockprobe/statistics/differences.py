"""Differences in success between the lowest dose and every other, or a control and conditions, corrected together.

An estimate, its interval and its P value use the same sample. An agent's sample holds the trials that both have: trials
of equal repetition and trial share their luck, and an unfinished study has some of them under one condition only.
People meet no luck twice; their sample is all trials, clustered by person, with Student's t and no permutation. What
holds at every look uses the blocks that both have in the order of the plan; people come as they please, so their trials
have no order.
Several boxes are clusters, which count alike (:mod:`lockprobe.statistics.pairs`). Where trials broke, everything holds
whatever became of them. Studies of one seed share their luck too; others are independent samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.blocks import blocks_of
from lockprobe.statistics.broken_trials import bounded, whatever_broke
from lockprobe.statistics.clustered import clustered_difference, share_of
from lockprobe.statistics.every_look import (
    E_PROCESS,
    AtEveryLook,
    Numbers,
    at_every_look,
    held_at_both_ends,
    share_at_every_look,
)
from lockprobe.statistics.outcomes import Outcomes, joined
from lockprobe.statistics.pairs import paired
from lockprobe.statistics.proportions import Difference, Proportion, between, difference, proportion

PERMUTATIONS = 2000

_PER_AGENT = 400
"""Permutations for each of the agents that are judged together: the smallest P value is a twentieth of the level."""

_AT_ONCE = 1 << 27
"""Outcomes that are permuted at once, a byte each."""

FEW_BROKE = 0.05
"""The share of the trials of a condition that may have broken by the step of an early comparison."""

PERMUTED = "permutation within blocks, and interval"
"""The test of success where outcomes are exchanged between doses; its interval has to exclude 0 too."""

CLUSTERED = "t, clustered by person and block"
"""The test beside people."""

_TIE = 1e-9

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferenceAt(Difference):
    """The difference in success between one dose and the lowest, or a condition and the control, in one sample.

    Attributes:
        dose: The dose, or the place of the condition.
        first, second: Shares of the compared trials solved at the lowest dose, and at this one.
        low, high: Ends of the interval of the second less the first in trials that ended; its level is 1 - 0.05 /
            (doses compared with the lowest times agents judged together). If trials broke, it holds whatever became of
            them.
        test: What the P value is of.
        p_value: The larger of two, so that it is below 0.05 only if the interval excludes 0: the corrected P value of
            the interval, and a permutation P value, corrected for all doses (Westfall & Young's single-step maximum of
            differences in standard errors) and for the agents; McNemar's if one condition is compared with another. If
            trials broke, the larger of both ends, and 1 if the signs differ.
        bounds: The least and the largest that the difference in all begun trials can be; None if no trial broke.
        course: The estimate after each block, if interval and P value hold at every look; None if at one alone.
    """

    dose: float
    first: Proportion
    second: Proportion
    p_value: float
    test: str
    bounds: tuple[float, float] | None = None
    course: AtEveryLook | None = None


Found = tuple[DifferenceAt, ...]


def any_difference(
    outcomes: Outcomes, rng: np.random.Generator, permutations: int = PERMUTATIONS, *, agents: int = 1
) -> Found:
    """Success at every dose that shares trials with the lowest, ascending: whether it depends on the dose.

    A finding must pass two tests. First a permutation of outcomes between the doses of a cluster: its P value,
    ``(1 + those at least as extreme) / (1 + permutations)``, is exact for any shared luck if doses change nothing. But
    if they change which trials are solved and not how many, it rejects in up to a third of studies. So, second, the
    interval of the difference (Bonferroni over all differences) must exclude 0.

    Several agents are one family: a sentence that says which of them change is false if one of its parts is. P values
    are multiplied by their number and intervals widened alike (Bonferroni; Hsu 1996, Multiple Comparisons, Ch. 1), so
    that a P value is below 0.05 only if its interval excludes 0. Holm's steps have no such intervals.

    ``outcomes`` are the trials of one agent; ``agents`` are judged together, and for many more permutations are drawn,
    as their P values have to be smaller.
    """
    begun, permutations = outcomes.at_ended_doses, max(permutations, _PER_AGENT * agents)
    later = begun.dose > begun.dose.min(initial=math.inf)
    return whatever_broke(lambda of: _by_dose(of[0], rng, permutations, agents), [begun], [later], _held)


def each_difference(groups: Sequence[Outcomes], *, agents: int = 1) -> tuple[tuple[int, DifferenceAt], ...]:
    """Each group of trials against the first one, in the pairs of trials that the two share.

    A comparison looks at its own two groups alone, so that a further group changes its P value only by the number that
    it is corrected for (Bonferroni, with the agents). The P value is the larger of two: McNemar's exact one and that of
    the interval; with people the second alone.

    Args:
        groups: The trials of one agent by condition, the control first.
        agents: Number of agents that are judged together.

    Returns:
        The place of each group that shares a trial with the first one, and the difference; its dose is that place.
    """
    begun = [one if len(one.ended) else one.ended for one in groups]
    gains = [i > 0 for i in range(len(groups))]
    found = whatever_broke(lambda of: _against_first(of, agents), begun, gains, _held)
    return tuple((int(one.dose), one) for one in found)


def few_broke_until(groups: Sequence[Outcomes]) -> int:
    """The last step, from 0 to the budget, by which at most 5 % of the begun trials of every group broke."""
    last = max((one.budget for one in groups), default=0)
    for one in groups:
        allowed = math.floor(FEW_BROKE * len(one) + 1e-9)
        last = min([last, *np.sort(one.broken.length)[allowed : allowed + 1].tolist()])  # it broke in the next step
    return last


def independent_difference(first: Outcomes, second: Outcomes, *, same_luck: bool) -> DifferenceAt | None:
    """Success of one side less that of another, whose trials are no pairs; None if no trial of one of them ended.

    Newcombe's interval and Fisher's exact test. Where people are on a side, trials are clustered by person, and by luck
    if that is the same in both.
    """
    if not (len(first.ended) and len(second.ended)):
        return None
    apart = partial(_difference, dose=1.0, apart=True, same_luck=same_luck)
    (made,) = whatever_broke(lambda of: (apart(*of),), [first, second], [False, True], _held)
    return made


def _held(found: Found, low: Found, high: Found) -> Found:
    """The differences without the broken trials, with what holds at both ends of what these can have become."""
    lows, highs, held = {one.dose: one for one in low}, {one.dose: one for one in high}, []
    for one in found:
        least, most = lows[one.dose], highs[one.dose]
        made, courses = bounded(one, least, most), [course for end in (one, least, most) if (course := end.course)]
        held.append(
            replace(
                made,
                first=between(one.first, most.first, least.first),
                second=between(one.second, least.second, most.second),
                course=held_at_both_ends(*courses) if courses else None,
                bounds=(least.value, most.value),
            )
        )
    return tuple(held)


def _against_first(groups: Sequence[Outcomes], agents: int) -> Found:
    people = any(one.crossed for one in groups)
    if groups[0].order is not None and not people:
        return _at_every_look(groups, agents)
    shared = {
        i: one
        for i, one in enumerate(groups[1:], 1)
        if len(one) and len(groups[0]) and (people or len(blocks_of([groups[0], one]).whole([0, 1])[0]))
    }
    return tuple(_difference(groups[0], one, float(i), choices=agents * len(shared)) for i, one in shared.items())


def _at_every_look(groups: Sequence[Outcomes], agents: int) -> Found:
    """The same as :func:`_against_first`, as it holds at every look."""
    blocks, solved, family = blocks_of(groups), {}, []
    for i in range(1, len(groups)):
        both = ~np.isnan(blocks.solved[:, [0, i]]).any(axis=1)
        if both.any():
            solved[i] = own = blocks.solved[both][:, [0, i]]
            family.append(Numbers(values=own[:, 1] - own[:, 0], block=blocks.place[both]))
    margin = groups[0].order.margin if groups[0].order else None
    courses = at_every_look(family, agents=agents, margin=margin) if family else ()
    found = []
    for (i, own), course in zip(solved.items(), courses, strict=True):
        before, after = (share_at_every_look(column) for column in own.T)
        found.append(
            DifferenceAt(
                dose=float(i), first=before, second=after, value=course.value, low=course.low, high=course.high,
                p_value=course.p_value, test=E_PROCESS, course=course,
            )
        )  # fmt: skip
    return tuple(found)


def _difference(
    before: Outcomes,
    after: Outcomes,
    dose: float,
    exchange: float | None = None,
    *,
    choices: int = 1,
    apart: bool = False,
    same_luck: bool = True,
) -> DifferenceAt:
    """The difference of two groups in the trials that can be compared; McNemar's test without a permutation.

    With ``apart`` they are of two studies, so that no trials are pairs and nobody played in both.
    """
    first, second = (proportion(int(one.solved.sum()), len(one)) for one in (before, after))
    if before.crossed or after.crossed:
        both, test = joined([before, after]), CLUSTERED
        later = both.dose == 1
        luck = both.luck + later * (0 if same_luck else len(both))
        alone = np.char.add("/", luck.astype(np.str_))  # an agent's trial is a cluster of its own
        people = np.where(both.player == "", alone, both.player)
        people = np.char.add(later.astype(np.str_), people) if apart else people
        found = clustered_difference(both.solved, later, people, luck, choices=choices)
        first, second = (share_of(one.solved, one.player if one.crossed else (), one.luck) for one in (before, after))
    elif apart:
        found, test = difference(first, second) or Difference(value=math.nan), "Fisher"
    else:
        solved, box = blocks_of([before, after]).whole([0, 1])
        found = paired(solved[:, 0], solved[:, 1], box, choices=choices, exchange=exchange)
        first, second = (share_of(column, (), (), box) for column in solved.T)
        test = "McNemar, and interval" if exchange is None else PERMUTED
    return DifferenceAt(
        dose=dose, first=first, second=second, value=found.value, low=found.low, high=found.high,
        p_value=found.p_value or 0.0, test=test,
    )  # fmt: skip


def _by_dose(outcomes: Outcomes, rng: np.random.Generator, permutations: int, agents: int) -> Found:
    values, place = np.unique(outcomes.dose, return_inverse=True)
    groups = [outcomes.at(outcomes.dose == dose) for dose in values]
    if outcomes.crossed or outcomes.order is not None:
        return tuple(replace(one, dose=float(values[int(one.dose)])) for one in _against_first(groups, agents))
    away, compared, error = _permuted(outcomes, place, len(values), permutations, rng)
    tested = np.flatnonzero(compared[1:] > 0) + 1
    scaled = np.abs(away) / error
    largest = scaled[1:, tested].max(axis=1, initial=0.0)
    found = []
    for i in tested.tolist():
        exchange = float((1 + np.count_nonzero(largest >= scaled[0, i] - _TIE)) / (1 + len(largest)))
        corrected, choices = min(1.0, agents * exchange), agents * len(tested)
        found.append(_difference(groups[0], groups[i], float(values[i]), corrected, choices=choices))
    return tuple(found)


def _permuted(
    outcomes: Outcomes, place: NDArray[np.intp], places: int, permutations: int, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Outcomes permuted within blocks of luck; the first row is as observed.

    Returns:
        Share solved at each dose minus that at the first, over the blocks that have both, shape (1 + permutations,
        doses); number of such blocks, shape (doses,); standard error of these differences, with one more block that
        differs, of the same shape.
    """
    clusters = outcomes.cluster
    order, alike = np.lexsort((place, clusters)), dict[tuple[int, ...], list[NDArray[np.bool_]]]()
    for rows in np.split(order, np.flatnonzero(np.diff(clusters[order])) + 1):  # those at the same doses together
        alike.setdefault(tuple(place[rows].tolist()), []).append(outcomes.solved[rows])
    away = np.zeros((1 + permutations, places))
    both, variance = np.zeros((2, places))
    for labels, of in alike.items():
        members, at = np.array(of), list(labels)
        varied = members[members.any(axis=1) & ~members.all(axis=1)].astype(np.uint8)
        many = max(1, _AT_ONCE // max(1, varied.size))
        shuffled = (
            rng.permuted(np.broadcast_to(varied, (min(many, permutations - first), *varied.shape)), axis=2)
            for first in range(0, permutations, many)
        )
        totals = [some.sum(axis=1, dtype=np.float64) + np.count_nonzero(members.all(axis=1)) for some in shuffled]
        found = np.vstack([members.sum(axis=0), *totals])
        if len(at) > 1 and at[0] == 0:
            away += (found - found[:, :1]) @ np.eye(places)[at]
            both[at] += len(members)
            count = members.sum(axis=1)
            variance[at] += float(np.sum(2 * count * (len(at) - count))) / (len(at) * (len(at) - 1))
    most = np.maximum(both, 1)
    return away / most, both, np.sqrt(variance + 1) / most
