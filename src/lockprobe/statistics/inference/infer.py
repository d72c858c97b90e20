"""The tests of one agent's trials over p."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.left_out import section
from lockprobe.statistics.broken_trials import completed
from lockprobe.statistics.inference.broken_shares import BrokenShares, broken_shares
from lockprobe.statistics.inference.difference import AnyDifference, any_difference, bounded_differences
from lockprobe.statistics.inference.hazard import Hazard, looping
from lockprobe.statistics.inference.mean_steps import mean_steps
from lockprobe.statistics.inference.shape import BinomialOrders, binomial_orders
from lockprobe.statistics.inference.ushape import TwoLines, corrected, onset_lines, two_lines
from lockprobe.statistics.inference.verdict import (
    ONE_LOOK,
    TestResult,
    at_every_look,
    looping_test,
    speed_test,
    success_test,
    two_lines_test,
)
from lockprobe.statistics.outcomes import Outcomes

_Test = TypeVar("_Test")


@dataclass(frozen=True, slots=True, kw_only=True)
class Inference:
    """The tests of one agent's trials over p.

    Attributes:
        difference: Whether success depends on p.
        orders: Polynomials of the logit of success.
        lines: Whether success rises and falls, by two lines.
        onset: Whether p changes how soon the agent loops.
        onset_lines: Whether first loops come later and then sooner again, by two lines.
        broken: Trials that ended as error, by p; None if there are none.
        tests: The test of each question.
    """

    difference: AnyDifference
    orders: BinomialOrders
    lines: TwoLines
    onset: Hazard | None
    onset_lines: TwoLines
    broken: BrokenShares | None
    tests: tuple[TestResult, ...]


def infer(
    outcomes: Outcomes,
    rng: np.random.Generator,
    *,
    broken: Outcomes | None = None,
    budget: int | None = None,
    agents: int = 1,
) -> Inference:
    """Run all tests on one agent's trials over p.

    If trials broke, the tests conclude only what holds at both ends of what these can have become: those at the lowest
    p solved (and looping) in the step in which they broke and those at every other p never, and the reverse. A shape
    must hold in two more cases, in which those at the lowest and the highest p are set against all others
    (:mod:`lockprobe.statistics.broken_trials`).

    Args:
        outcomes: The ended trials of one agent.
        rng: The stream of the permutations.
        broken: Its trials that ended as error.
        budget: Steps of a trial; by default those of the longest.
        agents: Number of agents that are judged together. Differences, their intervals and the two lines are corrected
            for them; the tests of other questions are not.

    Raises:
        BadValue: If a dose is no finite number.
    """
    if not (proper := np.isfinite(outcomes.dose)).all():
        raise BadValue("dose of the trials", outcomes.dose[~proper][0], "a finite number")
    most = int(outcomes.length.max(initial=1)) if budget is None else budget
    found = _tested(outcomes, rng, most, agents)
    if broken is None or not len(broken):
        return found
    shares = broken_shares(outcomes, broken, rng)
    broken = broken.at(np.isin(broken.dose, outcomes.dose))
    lowest = broken.dose == outcomes.dose.min(initial=np.inf)
    outer = lowest | (broken.dose == outcomes.dose.max(initial=-np.inf))
    ends = [
        _tested(completed(outcomes, broken, soon, most), rng, most, agents)
        for side in (lowest, outer)
        for soon in (side, ~side)
    ]
    difference = bounded_differences(found.difference, *(end.difference for end in ends[:2]))
    success, *others = found.tests
    return replace(
        found,
        difference=difference,
        lines=_worst_lines(found.lines, *(end.lines for end in ends)),
        onset_lines=_worst_lines(found.onset_lines, *(end.onset_lines for end in ends)),
        broken=shares,
        tests=(
            replace(success_test(difference), name=success.name, broken=difference.p_value is not None),
            *(
                _worst_test(test, [end.tests[i] for end in ends[: 4 if "two lines" in test.name else 2]])
                for i, test in enumerate(others, 1)
            ),
        ),
    )


def _worst_lines(found: TwoLines, *ends: TwoLines) -> TwoLines:
    """The two lines without the broken trials, with a shape only if all ends show it."""
    values = [one.p_value for one in ends if one.p_value is not None]
    if found.p_value is None or len(values) < len(ends):
        return replace(found, p_value=None, direction=None)
    same = len({one.direction for one in (found, *ends)}) == 1
    return replace(found, p_value=max(values) if same else 1.0, direction=found.direction if same else None)


def _worst_test(found: TestResult, ends: Sequence[TestResult]) -> TestResult:
    """The test with the largest P value of the ends, or 1 if directions differ."""
    if found.p_value is None:
        return found
    values = [test.p_value for test in ends if test.p_value is not None]
    if len(values) < len(ends):
        return replace(found, p_value=None, note="too few remain")
    lows, highs = ([getattr(test, end) for test in ends] for end in ("low", "high"))
    same = len({test.direction for test in (found, *ends)}) == 1
    return replace(
        found,
        p_value=max(values) if same else 1.0,
        low=None if None in lows else min(lows),
        high=None if None in highs else max(highs),
        broken=True,
    )


def _tested(outcomes: Outcomes, rng: np.random.Generator, budget: int, agents: int) -> Inference:
    difference = any_difference(outcomes, rng, agents=agents)
    none = outcomes.at(np.zeros(len(outcomes), dtype=np.bool_))

    def of(name: str, test: Callable[[Outcomes], _Test]) -> _Test:
        return section(name, lambda: test(outcomes), lambda: test(none))

    steps = of("Mean steps", lambda some: mean_steps(some, budget))
    onset = of("Loop onset", looping)
    orders = of("Binomial model of success", lambda some: binomial_orders(some.dose, some.solved))
    lines = corrected(
        of("Two lines of success", lambda some: two_lines(some.dose, some.solved, _players(some))), agents
    )
    if outcomes.order is not None:
        lines = TwoLines(note=ONE_LOOK)
    again = of("Two lines of loop onset", onset_lines)
    tests = (
        success_test(difference),
        speed_test(steps),
        two_lines_test("two lines", "shape", lines, first=1),
        looping_test(onset),
        two_lines_test("loop onset, two lines", "looping again", again, first=-1),
    )
    return Inference(
        difference=difference,
        orders=orders,
        lines=lines,
        onset=onset,
        onset_lines=again,
        broken=None,
        tests=tests if outcomes.order is None else at_every_look(tests),
    )


def _players(outcomes: Outcomes) -> NDArray[np.int64] | None:
    """The clusters of people's trials; None for an agent, whose trials are independent there."""
    return outcomes.cluster if outcomes.crossed else None
