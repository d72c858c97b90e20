"""Selection bias from broken trials, and worst-case bounds on conclusions.

A trial that ends as error counts neither as solved nor as failed. If trials break more often under one condition, the
remaining ones are a biased sample: calls that fail with equal probability at every step break long trials, which are
seldom solved. So everything is tested three times: without the broken trials, with all of them unsolved, and with all
of them solved at the next step. A conclusion must hold in all three (bounds of Manski 1990, at the two extremes that
treat conditions alike).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.statistics.inference.difference import AnyDifference, Bound, DifferenceAt, any_difference
from lockprobe.statistics.inference.ushape import TwoLines
from lockprobe.statistics.inference.verdict import ONE_LOOK, TestResult
from lockprobe.statistics.outcomes import Outcomes, appended
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion

PERMUTATIONS = 999


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenShares:
    """Share of broken trials by p.

    Attributes:
        at: Share of begun trials that broke, by p, ascending.
        p_value: Permutation test (within trials of equal luck) that the shares are equal at all p; None if no two p
            share a trial.
    """

    at: tuple[tuple[float, Proportion], ...]
    p_value: float | None

    @property
    def differ(self) -> bool:
        """Whether the share of broken trials is shown to depend on p."""
        return self.p_value is not None and self.p_value < ALPHA


def broken_shares(counted: Outcomes, broken: Outcomes, rng: np.random.Generator) -> BrokenShares | None:
    """Count the broken trials of one agent at each p, given its ended ones; None if none broke."""
    if not len(broken):
        return None
    begun = appended(counted, broken)
    broke = replace(begun, solved=np.arange(len(begun)) >= len(counted))
    here = [(float(p), broke.solved[broke.dose == p]) for p in np.unique(broke.dose)]
    return BrokenShares(
        at=tuple((p, proportion(int(which.sum()), len(which))) for p, which in here),
        p_value=any_difference(broke, rng, PERMUTATIONS).omnibus,
    )


def completed(counted: Outcomes, broken: Outcomes) -> tuple[Outcomes, Outcomes]:
    """All trials in both extreme cases: broken ones unsolved (censored at their last step), or solved a step later."""
    unsolved = replace(broken, solved=np.zeros(len(broken), dtype=np.bool_))
    solved = replace(broken, solved=np.ones(len(broken), dtype=np.bool_), length=broken.length + 1)
    return appended(counted, unsolved), appended(counted, solved)


def worst_case_difference(found: AnyDifference, unsolved: AnyDifference, solved: AnyDifference) -> AnyDifference:
    """The differences without the broken trials, with the largest P value of the three cases."""
    bounds = [{one.dose: one for one in other.at} for other in (unsolved, solved)]
    at = tuple(_worst_case_at(one, *(bound.get(one.dose) for bound in bounds)) for one in found.at)
    return replace(found, at=at, p_value=min((one.p_value for one in at), default=None))


def _worst_case_at(found: DifferenceAt, unsolved: DifferenceAt | None, solved: DifferenceAt | None) -> DifferenceAt:
    if unsolved is None or solved is None:
        return replace(found, p_value=1.0)
    three = (found, unsolved, solved)
    alike = len({np.sign(one.value) for one in three}) == 1
    return replace(
        found,
        p_value=max(one.p_value for one in three) if alike else 1.0,
        if_unsolved=Bound(value=unsolved.value, p_value=unsolved.p_value),
        if_solved=Bound(value=solved.value, p_value=solved.p_value),
    )


def worst_case_lines(found: TwoLines, *others: TwoLines) -> TwoLines:
    """The two lines without the broken trials, with a shape only if all three cases show it."""
    three = (found, *others)
    if any(one.p_value is None for one in three):
        return replace(found, p_value=None, direction=None)
    same = len({one.direction for one in three}) == 1
    return replace(
        found,
        p_value=max(one.p_value or 0.0 for one in three) if same else 1.0,
        direction=found.direction if same else None,
    )


def worst_case_tests(
    found: Sequence[TestResult], unsolved: Sequence[TestResult], solved: Sequence[TestResult]
) -> tuple[TestResult, ...]:
    """The tests with the largest of three P values, or 1 if directions differ."""
    return tuple(map(_worst_case, zip(found, unsolved, solved, strict=True)))


def _worst_case(three: tuple[TestResult, TestResult, TestResult]) -> TestResult:
    if three[0].note == ONE_LOOK:
        return three[0]
    first, values = three[0], [test.p_value for test in three if test.p_value is not None]
    if len(values) < len(three):
        return replace(first, p_value=None, note="too few remain")
    same = len({test.direction for test in three}) == 1
    return replace(first, p_value=max(values) if same else 1.0, broken=True)
