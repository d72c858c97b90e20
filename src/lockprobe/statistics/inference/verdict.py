"""The tests of one agent in one common form: question, result, and whether to conclude from it.

The paper concludes from a peak picked by eye, an order picked by AIC and a correlation. Each question has one test
here that keeps its error rate, marked *recommended*. The others are naive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from lockprobe.statistics.inference.association import Correlation
from lockprobe.statistics.inference.difference import AnyDifference
from lockprobe.statistics.inference.hazard import LoopEffect, NaiveAssociation
from lockprobe.statistics.inference.logrank import LogRanks
from lockprobe.statistics.inference.mean_steps import MeanSteps
from lockprobe.statistics.inference.shape import BinomialOrders
from lockprobe.statistics.inference.trend import TrendFit
from lockprobe.statistics.inference.ushape import LindMehlum, TwoLines
from lockprobe.statistics.outcomes import Point
from lockprobe.statistics.proportions import ALPHA, Difference, difference, proportion

__all__ = [
    "MEAN_STEPS",
    "ONE_LOOK",
    "Question",
    "TestResult",
    "at_every_look",
    "harm_tests",
    "looping_again_tests",
    "looping_tests",
    "shape_tests",
    "speed_tests",
    "success_tests",
]

Question = Literal["success", "speed", "shape", "looping", "looping again", "harm"]

MEAN_STEPS = "mean steps, Student over blocks"
"""The recommended test of how many steps a trial takes."""

ONE_LOOK = "one look"
"""Why a test says nothing of a study that is judged at every look: it holds for one."""

_ONE_P = "fewer than two doses"


@dataclass(frozen=True, slots=True, kw_only=True)
class TestResult:
    """The result of one test of one agent.

    Attributes:
        name: The test.
        question: The question that it answers.
        recommended: Whether to conclude from it; other tests are shown for comparison.
        p_value: [0, 1]; None if it cannot be computed.
        effect: The effect size; None without an estimate.
        low, high: Ends of its 95 % interval, if there is one.
        baseline: The simulated effect of a blind agent with the same action habits, if that is the null hypothesis;
            None if the null hypothesis is no effect.
        direction: 1 if the effect is more (sooner, higher odds), -1 if less, 0 if neither or it has none.
        holds: For a rule without a P value, whether it says yes; None otherwise.
        note: Why there is no P value, as a short code; empty if there is one.
        broken: Whether the P value is the largest over the possible endings of broken trials.
    """

    __test__ = False  # no test of this package, whatever its name begins with

    name: str
    question: Question
    recommended: bool
    p_value: float | None
    effect: float | None = None
    low: float | None = None
    high: float | None = None
    baseline: float | None = None
    direction: int = 0
    holds: bool | None = None
    note: str = ""
    broken: bool = False

    @property
    def rejects(self) -> bool:
        """Whether the answer is yes: the P value is below 0.05, or the rule holds."""
        return bool(self.holds) if self.p_value is None else self.p_value < ALPHA


def success_tests(found: AnyDifference, conditions: list[Point]) -> list[TestResult]:
    """Tests of whether success depends on p."""
    clearest = found.clearest
    chosen = _chosen(conditions, "success", highest=True)
    return [
        TestResult(
            name="greatest difference from the lowest dose, permutation",
            question="success",
            recommended=True,
            p_value=found.p_value,
            effect=clearest.value if clearest else None,
            low=clearest.low if clearest else None,
            high=clearest.high if clearest else None,
            direction=int(np.sign(clearest.value)) if clearest else 0,
            note=found.note,
        ),
        TestResult(
            name="any difference, permutation",
            question="success",
            recommended=False,
            p_value=found.omnibus,
        ),
        _naive(chosen, "success", "highest success, chosen by eye, Fisher"),
    ]


def at_every_look(tests: Sequence[TestResult]) -> tuple[TestResult, ...]:
    """The tests of a study that is judged at every look: that of success; others hold for one look, and say nothing."""
    first, *others = (test for test in tests if test.recommended)
    unsaid: dict[str, Any] = {"p_value": None, "effect": None, "low": None, "high": None, "holds": None}
    return (
        replace(first, name="greatest difference from the lowest dose, e-process"),
        *(replace(one, **unsaid, baseline=None, direction=0, note=ONE_LOOK) for one in others),
    )


def speed_tests(steps: MeanSteps, speed: LogRanks) -> list[TestResult]:
    """Tests of whether p changes how fast the box is solved."""
    return [
        TestResult(
            name=MEAN_STEPS,
            question="speed",
            recommended=True,
            p_value=steps.p_value,
            effect=steps.change if steps.p_value is not None else None,
            low=steps.low,
            high=steps.high,
            direction=0 if steps.p_value is None else -int(np.sign(steps.change)),
            note=steps.note,
        ),
        replace(_logrank(speed, "speed", "steps to solve, log-rank"), recommended=False),
    ]


def shape_tests(lines: TwoLines, bend: LindMehlum, found: BinomialOrders, fit: TrendFit) -> list[TestResult]:
    """Tests of whether success rises and falls."""
    orders = found.orders
    rises = lines.first is not None and lines.first.z > 0
    opens_down = bend.slope_low is not None and bend.slope_low > 0
    return [
        TestResult(
            name="two lines",
            question="shape",
            recommended=True,
            p_value=None if lines.p_value is None else lines.p_value if rises else 1.0,
            effect=lines.break_p,
            note=lines.note,
        ),
        TestResult(
            name="Lind-Mehlum",
            question="shape",
            recommended=False,
            p_value=None if bend.p_value is None else bend.p_value if opens_down else 1.0,
            effect=bend.extremum,
            low=bend.low,
            high=bend.high,
            note=bend.note,
        ),
        TestResult(
            name="quadratic term, likelihood ratio",
            question="shape",
            recommended=False,
            p_value=orders[2].p_value if len(orders) > 2 else None,
        ),
        TestResult(
            name="order 2 by AIC and cross-validation, maximum inside",
            question="shape",
            recommended=False,
            p_value=None,
            holds=_peaks(fit),
        ),
    ]


def _peaks(fit: TrendFit) -> bool | None:
    """Whether both criteria choose order 2 and that fit has its maximum inside the range of p (Sec. 3.2)."""
    if fit.order_by_aic is None or fit.order_by_cv is None or fit.quadratic is None:
        return None
    return fit.order_by_aic == 2 and fit.order_by_cv == 2 and fit.quadratic.turning_kind == "maximum"


def looping_tests(onset: LogRanks, conditions: list[Point]) -> list[TestResult]:
    """Tests of whether p changes how soon the agent loops."""
    chosen = _chosen(conditions, "loop_rate", highest=False)
    return [
        _logrank(onset, "looping", "loop onset, log-rank"),
        _naive(chosen, "looping", "lowest loop rate, chosen by eye, Fisher"),
    ]


def looping_again_tests(onset: TwoLines, rates: TwoLines) -> list[TestResult]:
    """Tests of whether the agent loops later and then sooner: two lines of loop onset, and naively of loop rates."""
    return [
        TestResult(
            name=name,
            question="looping again",
            recommended=found is onset,
            p_value=None if found.p_value is None else found.p_value if falls else 1.0,
            effect=found.break_p,
            note=found.note,
        )
        for name, found in (("loop onset, two lines", onset), ("loop rates, two lines", rates))
        for falls in [found.first is not None and found.first.z < 0]
    ]


def _logrank(found: LogRanks, question: Question, name: str) -> TestResult:
    primary = found.primary
    return TestResult(
        name=name,
        question=question,
        recommended=True,
        p_value=primary.p_value if primary else None,
        effect=primary.hazard_ratio if primary else None,
        direction=primary.direction if primary else 0,
        note="" if primary else _ONE_P,
    )


def harm_tests(
    hazard: LoopEffect, landmark: LoopEffect, whole: NaiveAssociation, fine: Correlation, coarse: Correlation
) -> list[TestResult]:
    """Tests of whether success is rarer after a loop."""
    return [
        replace(_mantel_haenszel(hazard, "success after a loop, Mantel-Haenszel by dose and step"), recommended=True),
        replace(_mantel_haenszel(landmark, "looped by step 10, Mantel-Haenszel by dose"), direction=0),
        TestResult(
            name="looped against solved, Fisher",
            question="harm",
            recommended=False,
            p_value=whole.p_value,
            effect=whole.odds_ratio,
            note="too few remain" if whole.p_value is None else "",
        ),
        *(
            TestResult(
                name=f"Pearson over {unit}",
                question="harm",
                recommended=False,
                p_value=found.p_value,
                effect=found.r,
            )
            for unit, found in (("repetitions", fine), ("doses", coarse))
        ),
    ]


def _mantel_haenszel(found: LoopEffect, name: str) -> TestResult:
    return TestResult(
        name=name,
        question="harm",
        recommended=False,
        p_value=found.p_value,
        effect=found.odds_ratio,
        low=found.low,
        high=found.high,
        baseline=found.blind.odds_ratio if found.blind else None,
        direction=found.direction,
        note=found.note,
    )


def _chosen(conditions: list[Point], quantity: Literal["success", "loop_rate"], *, highest: bool) -> Difference | None:
    """Naive: the lowest p against the p that looks best in a figure, without correction."""
    if len(conditions) < 2:
        return None
    first, *others = conditions
    best = (max if highest else min)(others, key=lambda point: getattr(point, quantity))
    shares = [proportion(round(getattr(point, quantity) * point.n), point.n) for point in (first, best)]
    return difference(*shares)


def _naive(found: Difference | None, question: Question, name: str) -> TestResult:
    return TestResult(
        name=name,
        question=question,
        recommended=False,
        p_value=found.p_value if found else None,
        effect=found.value if found else None,
        low=found.low if found else None,
        high=found.high if found else None,
        note="" if found else _ONE_P,
    )
