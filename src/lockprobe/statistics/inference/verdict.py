"""The tests of one agent in one common form: question and result.

The paper concludes from a peak picked by eye, an order picked by AIC and a correlation. Each question has one test here
that keeps its error rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from lockprobe.statistics.inference.difference import AnyDifference
from lockprobe.statistics.inference.hazard import Hazard
from lockprobe.statistics.inference.mean_steps import MeanSteps
from lockprobe.statistics.inference.ushape import TwoLines
from lockprobe.statistics.proportions import ALPHA

Question = Literal["success", "speed", "shape", "looping", "looping again"]

MEAN_STEPS = "mean steps, Student over blocks"
"""The test of how many steps a trial takes."""

ONE_LOOK = "one look"
"""Why a test says nothing of a study that is judged at every look: it holds for one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TestResult:
    """The result of one test of one agent.

    Attributes:
        name: The test.
        question: The question that it answers.
        p_value: [0, 1]; None if it cannot be computed.
        effect: The effect size; None without an estimate.
        low, high: Ends of its 95 % interval, if there is one.
        direction: 1 if the effect is more or sooner, -1 if less, 0 if neither or it has none.
        note: Why there is no P value, as a short code; empty if there is one.
        broken: Whether trials broke, so that interval and P value hold whatever became of them.
    """

    __test__ = False  # no test of this package, whatever its name begins with

    name: str
    question: Question
    p_value: float | None
    effect: float | None = None
    low: float | None = None
    high: float | None = None
    direction: int = 0
    note: str = ""
    broken: bool = False

    @property
    def rejects(self) -> bool:
        """Whether the answer is yes: the P value is below 0.05."""
        return self.p_value is not None and self.p_value < ALPHA


def success_test(found: AnyDifference) -> TestResult:
    """Whether success depends on p."""
    clearest = found.clearest
    return TestResult(
        name="greatest difference from the lowest dose, permutation",
        question="success",
        p_value=found.p_value,
        effect=clearest.value if clearest else None,
        low=clearest.low if clearest else None,
        high=clearest.high if clearest else None,
        direction=int(np.sign(clearest.value)) if clearest else 0,
        note=found.note,
    )


def at_every_look(tests: Sequence[TestResult]) -> tuple[TestResult, ...]:
    """The tests of a study that is judged at every look: that of success; others hold for one look, and say nothing."""
    first, *others = tests
    unsaid: dict[str, Any] = {"p_value": None, "effect": None, "low": None, "high": None}
    return (
        replace(first, name="greatest difference from the lowest dose, e-process"),
        *(replace(one, **unsaid, direction=0, note=ONE_LOOK) for one in others),
    )


def speed_test(steps: MeanSteps) -> TestResult:
    """Whether p changes how many steps a trial takes."""
    return TestResult(
        name=MEAN_STEPS,
        question="speed",
        p_value=steps.p_value,
        effect=steps.value if steps.p_value is not None else None,
        low=steps.low,
        high=steps.high,
        direction=0 if steps.p_value is None else -int(np.sign(steps.value)),
        note=steps.note,
    )


def two_lines_test(name: str, question: Question, found: TwoLines, *, first: int) -> TestResult:
    """Whether something changes its direction over p; ``first`` is that of the first line, 1 or -1."""
    turns = found.first is not None and first * found.first.z > 0
    return TestResult(
        name=name,
        question=question,
        p_value=None if found.p_value is None else found.p_value if turns else 1.0,
        effect=found.break_p,
        note=found.note,
    )


def looping_test(onset: Hazard | None) -> TestResult:
    """Whether p changes how soon the agent loops."""
    return TestResult(
        name="loop onset, log-rank",
        question="looping",
        p_value=onset.p_value if onset else None,
        effect=onset.ratio if onset else None,
        direction=onset.direction if onset else 0,
        note="" if onset else "fewer than two doses",
    )
