"""The course of success over p: whether it rises, falls, or both, in one word for each agent.

The paper describes a rise up to p = 0.4 and a fall after it (Sec. 3.2, Fig. 4). Agents of very different kinds show
parts of that course, so the course says little about its cause.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from lockprobe.statistics.inference.difference import AnyDifference
from lockprobe.statistics.inference.ushape import TwoLines
from lockprobe.statistics.outcomes import Point
from lockprobe.statistics.proportions import ALPHA

__all__ = ["Course", "CourseKind", "course"]

CourseKind = Literal["rises", "falls", "rises and falls", "falls and rises", "no change detectable", "not tested"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """The course of success over p, with the shares behind it.

    Attributes:
        kind: The course in words.
        first: Share solved at the lowest p.
        highest: The highest share solved.
        highest_dose: The p of the highest share.
        lowest: The lowest share solved.
        lowest_dose: The p of the lowest share.
        last: Share solved at the highest p.
    """

    kind: CourseKind
    first: float
    highest: float
    highest_dose: float
    lowest: float
    lowest_dose: float
    last: float


def course(conditions: list[Point], difference: AnyDifference, lines: TwoLines) -> Course | None:
    """The course of an agent's success over p (one point per p, ascending); None without trials."""
    if not conditions:
        return None
    best, worst = (pick(conditions, key=lambda point: point.success) for pick in (max, min))
    found = Course(
        kind="not tested",
        first=conditions[0].success,
        highest=best.success,
        highest_dose=best.dose,
        lowest=worst.success,
        lowest_dose=worst.dose,
        last=conditions[-1].success,
    )
    return replace(found, kind=_kind(found, difference, lines))


def _kind(seen: Course, difference: AnyDifference, lines: TwoLines) -> CourseKind:
    """The course in words, from two tests at the 5 % level.

    Success rises if it is higher at some p than at the lowest p, and falls if it is lower (permutation test and
    interval, corrected for all p). The two-lines test can show a rise and a fall. Both tests are corrected for the
    agents that are judged together. They share no level: where nothing changes two opposite significant lines are rare,
    and where success only rises or only falls the first test finds nothing false.
    """
    if difference.p_value is None:
        return "not tested"
    if lines.direction is not None and lines.p_value is not None and lines.p_value < ALPHA:
        return "rises and falls" if lines.direction == "inverted U" else "falls and rises"
    differs = [at.value for at in difference.at if at.p_value < ALPHA]
    rises, falls = any(value > 0 for value in differs), any(value < 0 for value in differs)
    if rises and falls:
        return "rises and falls" if seen.highest_dose < seen.lowest_dose else "falls and rises"
    return "rises" if rises else "falls" if falls else "no change detectable"
