"""One agent over the doses of one axis: fits, differences from the lowest dose, and tests.

Flip rates and every other dose have the same quantities, with another value in the column ``axis``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

from lockprobe.report.prose.hypothesis_tests import limits_said, unit_of_effect, why_missing
from lockprobe.report.rows import Curve, Estimate, Fact, Row
from lockprobe.report.rows.primary import CONTROL
from lockprobe.report.study_numbers import BOUNDS, share_rows
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.axis import AGENT
from lockprobe.statistics.inference.difference import DifferenceAt
from lockprobe.statistics.inference.trend import TrendFit
from lockprobe.statistics.inference.ushape import TwoLines
from lockprobe.statistics.inference.verdict import TestResult
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.reference import Reference
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.trial.condition import Condition

DOSE = "dose"
"""The unit of a dose, which is named in the column ``axis``."""

PERMUTED = "permutation within blocks, and interval"


def at(dose: float, *more: str) -> str:
    """What part of a quantity is at a dose, and what part of that."""
    return ", ".join((f"{dose:.15g}", *more))


@dataclass(frozen=True, slots=True)
class AgentCourse:
    """One agent over one axis, whose key its rows have in their column ``axis``, and the conditions of its study."""

    agent: AgentSummary
    axis: str
    conditions: Mapping[str, Condition]

    @property
    def columns(self) -> dict[str, Any]:
        """What tells its rows from those of others."""
        return {"agent": self.agent.agent, "modality": self.agent.modality, "axis": self.axis}

    @property
    def dose(self) -> str:
        """What a dose is called."""
        return self.agent.axis.name

    def estimate(self, quantity: str, value: float | None = None, **more: Any) -> Estimate:
        """A row over all doses."""
        return Estimate(quantity=quantity, value=value, **self.columns | more)

    def curve(self, quantity: str, **more: Any) -> Curve:
        """A curve over all doses."""
        return Curve(quantity=quantity, **self.columns, **more)

    def under(self, dose: float, *more: str) -> dict[str, Any]:
        """The columns of a row at one dose."""
        return {"of": at(dose, *more), "doses": self._doses(dose)}

    def _doses(self, dose: float) -> dict[str, float]:
        """All doses of the condition at a dose of the axis."""
        if self.agent.axis.kind == AGENT:
            return {f"{AGENT}.{self.agent.axis.dose}": dose}
        return dict(self.conditions[self._names[dose]].doses)

    @property
    def _names(self) -> dict[float, str]:
        """Dose -> the name of its condition."""
        return {one.dose: one.name for one in self.agent.conditions}

    def against_lowest(self, dose: float, *more: str) -> dict[str, Any]:
        """The columns of a row that compares a dose with the lowest; options of agents have no condition each."""
        if self.agent.axis.kind == AGENT:
            return self.under(dose, *more)
        name, control = self._names[dose], self._names[min(self._names)]
        pair = {"condition": name, "control": control, "modality": self.conditions[name].modality}
        return self.under(dose) | pair | {"of": ", ".join(more)}

    def fact(self, about: str, text: str) -> Iterator[Fact]:
        """What no number says; none if it is empty."""
        if text:
            yield Fact(about=about, name=f"{self.agent.name}, {self.axis}", text=text)

    def missing(self, quantity: str, code: str) -> Iterator[Fact]:
        """Why a quantity is missing."""
        alike = f"Not tested: it plays the same trials at every {self.dose}." if code and self.agent.blind else ""
        return self.fact(quantity, alike or why_missing(code, self.agent.axis))


def course_rows(course: AgentCourse, reference: Reference | None) -> Iterator[Row]:
    """The rows of success of an agent over an axis; ``reference`` is what blind agents reach on the box."""
    agent, found = course.agent, course.agent.inference
    yield from _doses(course, reference)
    yield from trend_rows(course, "success_fit", agent.success_fit)
    yield from _model(course)
    yield from _differences(course)
    yield from two_lines_rows(course, "success_two_lines", found.lines)
    yield from _broken(course)
    for test in () if agent.blind else found.tests:
        yield from _test(course, test)


def _doses(course: AgentCourse, reference: Reference | None) -> Iterator[Row]:
    """The doses that are analysed, and what blind agents reach there."""
    found = course.agent
    for one in found.conditions:
        yield course.estimate("trials_at_dose", one.success.n, unit="trials", **course.under(one.dose))
    if (lowest := found.inference.difference.lowest) is not None:
        yield course.estimate("lowest_dose", lowest, unit=DOSE)
    budget = next((len(one.curve.share) - 1 for one in found.conditions if one.success.n), None)
    if reference is not None and budget is not None:
        for of, share in (("uniform", reference.random), ("no-repeat", reference.no_repeat)):
            yield course.estimate("success_chance", share[budget], of=of, note="exact")


def trend_rows(course: AgentCourse, quantity: str, fit: TrendFit) -> Iterator[Row]:
    """The paper's least-squares polynomials over repetitions, and the curve of the second order."""
    for one in fit.orders:
        yield from _coefficients(course, quantity, f"order {one.order}", one.coefficients)
        for of, score in (("AIC", one.aic), ("leave-one-out error", one.cv_rmse)):
            if score is not None:
                yield course.estimate(f"{quantity}_score", score, of=f"order {one.order}, {of}", n=fit.n, unit="score")
    for of, chosen in (("AIC", fit.order_by_aic), ("cross-validation", fit.order_by_cv)):
        if chosen is not None:
            yield course.estimate(f"{quantity}_order", chosen, of=of, n=fit.n, unit="order")
    if (curve := fit.quadratic) is not None:
        yield course.curve(quantity, n=fit.n, x=curve.dose, value=curve.value, low=curve.low, high=curve.high)
        if curve.turning is not None:
            yield course.estimate(f"{quantity}_turning", curve.turning, of=curve.turning_kind or "", unit=DOSE)
        if curve.turning_share is not None:
            yield course.estimate(f"{quantity}_turning_share", curve.turning_share, of=curve.turning_kind or "")
    yield from course.missing(quantity, fit.note)


def _coefficients(course: AgentCourse, quantity: str, order: str, values: Sequence[float]) -> Iterator[Estimate]:
    for power, value in enumerate(values):
        yield course.estimate(f"{quantity}_coefficient", value, of=f"{order}, power {power}", unit="coefficient")


def _model(course: AgentCourse) -> Iterator[Row]:
    """Polynomials of the logit of success over trials, and the curve of the order that AICc prefers."""
    found = course.agent.inference.orders
    for one in found.orders:
        order = f"order {one.order}"
        yield from _coefficients(course, "success_model", order, one.coefficients)
        scores = {"log-likelihood": one.log_likelihood, "AICc": one.aicc, "deviance": one.deviance}
        for of, score in scores.items():
            yield course.estimate("success_model_score", score, of=f"{order}, {of}", n=found.n, unit="score")
        if one.p_value is not None:
            test = "likelihood ratio against the next lower order"
            yield course.estimate("success_model_score", of=order, n=found.n, p_value=one.p_value, test=test)
    if found.order is not None:
        yield course.estimate("success_model_order", found.order, of="AICc", n=found.n, unit="order")
    if (curve := found.curve) is not None:
        yield course.curve("success_model", n=found.n, x=curve.dose, value=curve.value, low=curve.low, high=curve.high)
    yield from course.missing("success_model", found.note)


def _differences(course: AgentCourse) -> Iterator[Row]:
    """Success at every dose minus that at the lowest, and the clearest of these differences once more."""
    tested, contrast = course.agent.inference.difference, course.agent.contrast
    corrected = {
        "family": f"success by {course.dose}",
        "corrected_for": max(1, len(tested.at)) * tested.agents,
    }
    for one in tested.at:
        yield _difference(course, "success_difference", one, corrected | course.against_lowest(one.dose))
        yield from _details(course, one, corrected)
    if contrast is not None:
        of = corrected | course.under(contrast.other.dose) | {"of": ""}
        yield course.estimate("clearest_dose", contrast.other.dose, unit="dose")
        yield _difference(course, "clearest_success_difference", contrast.difference, of)
        yield course.estimate("clearest_success_difference", of="Fisher", p_value=contrast.fisher, test="Fisher")
    if tested.permutations:
        yield course.estimate("permutations", tested.permutations, unit="permutations")
    yield from course.missing("success_difference", tested.note)


def _difference(course: AgentCourse, quantity: str, one: DifferenceAt, of: dict[str, Any]) -> Estimate:
    found = {"n": one.second.n, "low": one.low, "high": one.high, "p_value": one.p_value, "test": PERMUTED}
    if one.course:
        found["test"] = E_PROCESS
    return course.estimate(quantity, one.value, unit="points", **found, **of)


def _details(course: AgentCourse, one: DifferenceAt, corrected: dict[str, Any]) -> Iterator[Estimate]:
    """The shares that are compared, the pairs that differ, and the bounds of the difference if trials broke."""

    def test(of: str, p_value: float, test: str, **more: Any) -> Estimate:
        columns = course.against_lowest(one.dose, of) | more
        return course.estimate("success_difference", unit="points", p_value=p_value, test=test, **columns)

    for where, share in (((), one.second), ((CONTROL,), one.first)):
        yield from share_rows("success_in_pairs", share, **course.columns | course.against_lowest(one.dose, *where))
    if one.course is None:
        yield test("permutation", one.exchange, "permutation within blocks", **corrected)
    if (pairs := one.pairs) is not None:
        if one.course is None:
            yield test("McNemar", pairs.p_value, "McNemar", n=pairs.n)
        for where, count in (((), pairs.only_second), ((CONTROL,), pairs.only_first)):
            of = course.against_lowest(one.dose, *where)
            yield course.estimate("solved_at_one_only", count, n=pairs.n, count=count, unit="trials", **of)
    for end, bound in zip(BOUNDS, one.bounds or (), strict=False):
        columns = course.against_lowest(one.dose, end)
        yield course.estimate("success_difference", bound, unit="points", **columns)


def two_lines_rows(course: AgentCourse, quantity: str, found: TwoLines) -> Iterator[Row]:
    """A line on each side of a break: whether something rises and then falls, or falls and then rises."""
    if found.break_p is not None:
        shape = {"p_value": found.p_value, "test": "two lines", "note": found.direction or ""}
        yield course.estimate(quantity, found.break_p, unit=DOSE, **shape)
    for of, line in (("first line", found.first), ("second line", found.second)):
        if line is not None:
            yield course.estimate(quantity, line.z, of=of, unit="z", p_value=line.p_value)
            if line.slope is not None:
                yield course.estimate(quantity, line.slope, of=f"{of}, slope", unit="logits")
    yield from course.missing(quantity, found.note)


def _broken(course: AgentCourse) -> Iterator[Row]:
    """The share of trials that broke, and whether it depends on the dose."""
    found = course.agent.inference.broken
    shares: Sequence[tuple[float, Proportion]] = found.at if found else ()
    yield from chain.from_iterable(
        share_rows("broken_share", share, **course.columns, **course.under(p)) for p, share in shares
    )
    if found is not None and found.p_value is not None:
        yield course.estimate("broken_share_differs", p_value=found.p_value, test="permutation within blocks")


def _test(course: AgentCourse, test: TestResult) -> Iterator[Estimate]:
    """A test, of its question."""
    of, tested = test.question, course.agent.inference.difference
    many = {"success": max(1, len(tested.at)) * tested.agents, "shape": tested.agents}
    yield course.estimate(
        "test",
        test.effect,
        of=of,
        unit=unit_of_effect(test.name),
        low=test.low,
        high=test.high,
        p_value=test.p_value,
        test=test.name,
        note=limits_said(test, course.agent.axis),
        corrected_for=many.get(test.question, 1),
    )
    if test.direction:
        yield course.estimate("test_direction", test.direction, of=of, unit="direction", test=test.name)
