"""The loops of one agent over the doses of an axis: fits, correlation with success, and first loops."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.questions.course_rows import AgentCourse, at, log_rank_rows, trend_rows, two_lines_rows
from lockprobe.report.rows import Curve, Estimate, Row
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.inference.association import Correlation
from lockprobe.statistics.inference.logrank import LogRanks


def loops_over_doses(course: AgentCourse) -> Iterator[Row]:
    """What concerns the loops of one agent over an axis; nothing if no trial has ended."""
    agent, found = course.agent, course.agent.inference
    if not any(condition.success.n for condition in agent.conditions):
        return
    yield from trend_rows(course, "loop_fit", agent.loop_fit)
    yield from _correlation(course, agent.correlation)
    yield from log_rank_rows(course, "hazard_ratio_of_first_loop", "first_loops", found.onset)
    yield from _onset(course, found.onset)
    yield from two_lines_rows(course, "first_loop_two_lines", found.onset_lines)


def _correlation(course: AgentCourse, found: Correlation) -> Iterator[Estimate]:
    """Loop rate against success over repetitions."""
    if found.n:
        ends = {"low": found.low, "high": found.high, "p_value": found.p_value, "test": "Student's t"}
        yield course.estimate("loop_success_correlation", found.r, unit="r", n=found.n, **ends)
    for of, value, unit in (("slope", found.slope, "ratio"), ("intercept", found.intercept, "share")):
        if value is not None:
            yield course.estimate("loop_success_line", value, of=of, unit=unit, n=found.n)


def _onset(course: AgentCourse, found: LogRanks) -> Iterator[Row]:
    """The share of trials that has looped by each step, its area, and at step 12; of flip rates its curve too."""
    if (primary := found.primary) is None:
        return
    groups = {"lowest": primary.lowest, "higher": primary.higher} | {
        at(one.higher.doses[0]): one.higher for one in found.each
    }
    for of, group in groups.items():
        own, curve = course.columns | {"of": of, "n": group.n}, group.curve
        yield Estimate(quantity="looped_by_step_12", **own, value=group.by_step(12))
        if (area := curve.area) is not None:
            yield Estimate(quantity="loop_onset_area", **own, value=area.value, low=area.low, high=area.high)
        if course.axis == FLIPS.name:
            band, steps = own | {"axis": "step", "low": curve.low, "high": curve.high}, tuple(range(len(curve.share)))
            yield Curve(quantity="loop_onset", **band, x=steps, value=curve.share)
