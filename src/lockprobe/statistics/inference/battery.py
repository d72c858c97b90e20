"""All statistics of one agent's trials over p, computed once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.left_out import section
from lockprobe.statistics.inference.association import Correlation, pearson
from lockprobe.statistics.inference.broken_trials import (
    BrokenShares,
    broken_shares,
    completed,
    worst_case_difference,
    worst_case_lines,
    worst_case_tests,
)
from lockprobe.statistics.inference.course import Course, course
from lockprobe.statistics.inference.difference import AnyDifference, any_difference
from lockprobe.statistics.inference.hazard import (
    LoopEffect,
    NaiveAssociation,
    loop_hazard,
    loop_landmark,
    naive_association,
)
from lockprobe.statistics.inference.logrank import LogRanks, loop_onset_logrank, solution_logrank
from lockprobe.statistics.inference.mean_steps import MeanSteps, mean_steps
from lockprobe.statistics.inference.shape import BinomialOrders, binomial_orders
from lockprobe.statistics.inference.smaller_budget import Reversal, reversal
from lockprobe.statistics.inference.trend import trend_fit
from lockprobe.statistics.inference.ushape import LindMehlum, TwoLines, corrected, lind_mehlum, onset_lines, two_lines
from lockprobe.statistics.inference.verdict import (
    ONE_LOOK,
    TestResult,
    at_every_look,
    harm_tests,
    looping_again_tests,
    looping_tests,
    shape_tests,
    speed_tests,
    success_tests,
)
from lockprobe.statistics.outcomes import Outcomes, points

__all__ = ["Inference", "infer"]


_Test = TypeVar("_Test")


@dataclass(frozen=True, slots=True, kw_only=True)
class Inference:
    """The tests of one agent's trials over p.

    Attributes:
        difference: Whether success depends on p.
        reversal: A smaller budget with the opposite effect; None where trials broke.
        course: The course of success over p, in one word; None without trials.
        orders: Polynomials of the logit of success.
        lines: Whether success rises and falls, by two lines.
        bend: Whether success rises and falls, by a quadratic.
        steps: Whether p changes the mean number of steps.
        speed: Whether p changes how soon the box is solved.
        onset: Whether p changes how soon the agent loops.
        onset_lines: Whether first loops come later and then sooner again, by two lines.
        hazard: Whether success is rarer after a loop, by p and step.
        landmark: The same by p, among trials that still run after step 10.
        whole: Naive: loop against success over whole trials.
        fine: Naive: correlation of looping and success over repetitions.
        coarse: Naive: correlation of looping and success over values of p.
        broken: Trials that ended as error, by p; None if there are none.
        tests: All tests in one form, by question, the recommended one first.
    """

    difference: AnyDifference
    reversal: Reversal | None
    course: Course | None
    orders: BinomialOrders
    lines: TwoLines
    bend: LindMehlum
    steps: MeanSteps
    speed: LogRanks
    onset: LogRanks
    onset_lines: TwoLines
    hazard: LoopEffect
    landmark: LoopEffect
    whole: NaiveAssociation
    fine: Correlation
    coarse: Correlation
    broken: BrokenShares | None
    tests: tuple[TestResult, ...]


def infer(
    outcomes: Outcomes,
    rng: np.random.Generator,
    *,
    broken: Outcomes | None = None,
    blind: Outcomes | None = None,
    budget: int | None = None,
    agents: int = 1,
) -> Inference:
    """Run all tests on one agent's trials over p.

    If trials broke, the recommended tests conclude only what holds in three cases: without the broken trials, with all
    of them unsolved, and with all of them solved (:mod:`lockprobe.statistics.inference.broken_trials`).

    Args:
        outcomes: The ended trials of one agent.
        rng: The stream of the permutations.
        broken: Its trials that ended as error.
        blind: Trials of a blind agent with the same action habits on the same box. Their odds ratio after a loop is
            the null hypothesis; without them it is 1.
        budget: Steps of a trial; by default those of the longest.
        agents: Number of agents whose courses of success are judged together. Differences, their intervals and the two
            lines are corrected for them; the tests of other questions are not.

    Raises:
        BadValue: If a dose is no finite number.
    """
    if not (proper := np.isfinite(outcomes.dose)).all():
        raise BadValue("dose of the trials", outcomes.dose[~proper][0], "a finite number")
    most = int(outcomes.length.max(initial=1)) if budget is None else budget
    found = _tested(outcomes, rng, blind, most, agents)
    if broken is None or not len(broken):
        return found
    shares = broken_shares(outcomes, broken, rng)
    ends = [_tested(whole, rng, blind, most, agents) for whole in completed(outcomes, broken)]
    difference = worst_case_difference(found.difference, *(end.difference for end in ends))
    lines = worst_case_lines(found.lines, *(end.lines for end in ends))
    return replace(
        found,
        difference=difference,
        reversal=None,
        lines=lines,
        onset_lines=worst_case_lines(found.onset_lines, *(end.onset_lines for end in ends)),
        course=course(points(outcomes, by_repetition=False), difference, lines),
        broken=shares,
        tests=worst_case_tests(found.tests, *(end.tests for end in ends)),
    )


def _tested(
    outcomes: Outcomes, rng: np.random.Generator, blind: Outcomes | None, budget: int, agents: int
) -> Inference:
    repetitions, conditions = points(outcomes), points(outcomes, by_repetition=False)
    difference = any_difference(outcomes, rng, agents=agents)
    none = outcomes.at(np.zeros(len(outcomes), dtype=np.bool_))

    def of(name: str, test: Callable[[Outcomes], _Test]) -> _Test:
        return section(name, lambda: test(outcomes), lambda: test(none))

    steps, speed = of("Mean steps", lambda some: mean_steps(some, budget)), of("Steps to solve", solution_logrank)
    onset = of("Loop onset", loop_onset_logrank)
    orders = of("Binomial model of success", lambda some: binomial_orders(some.dose, some.solved))
    bend = of("Lind-Mehlum test", lambda some: lind_mehlum(some.dose, some.solved))
    lines = corrected(
        of("Two lines of success", lambda some: two_lines(some.dose, some.solved, _players(some))), agents
    )
    if outcomes.order is not None:
        lines = TwoLines(note=ONE_LOOK)
    again = of("Two lines of loop onset", onset_lines)
    rates = of("Two lines of loop rates", lambda some: two_lines(some.dose, some.looped, _players(some)))
    hazard = of("Success after a loop", lambda some: loop_hazard(some, blind))
    landmark = of("Success after a loop by step 10", lambda some: loop_landmark(some, blind))
    whole = of("Loops against success", naive_association)
    fine = of("Correlation over repetitions", lambda some: pearson(points(some)))
    coarse = of("Correlation over flip rates", lambda some: pearson(points(some, by_repetition=False)))
    tests = (
        *success_tests(difference, conditions),
        *speed_tests(steps, speed),
        *shape_tests(lines, bend, orders, trend_fit(repetitions, "success", np.empty((0, len(repetitions))))),
        *looping_tests(onset, conditions),
        *looping_again_tests(again, rates),
        *harm_tests(hazard, landmark, whole, fine, coarse),
    )
    return Inference(
        difference=difference,
        reversal=section("Smaller budgets", lambda: reversal(outcomes, difference), lambda: None),
        course=course(conditions, difference, lines),
        orders=orders,
        lines=lines,
        bend=bend,
        steps=steps,
        speed=speed,
        onset=onset,
        onset_lines=again,
        hazard=hazard,
        landmark=landmark,
        whole=whole,
        fine=fine,
        coarse=coarse,
        broken=None,
        tests=tests if outcomes.order is None else at_every_look(tests),
    )


def _players(outcomes: Outcomes) -> NDArray[np.int64] | None:
    """The clusters of people's trials; None for an agent, whose trials are independent there."""
    return outcomes.cluster if outcomes.crossed else None
