"""Does success rise with p, fall, or both? One word for an agent, from the tests to conclude from.

The paper describes a course, up to p = 0.4 and down again (Sec. 3.2, Fig. 4). Agents of very different kinds show parts
of it, so that a course says little of its cause; a study of several agents is read by it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lockprobe.analysis.inference.peak import AnyDifference
from lockprobe.analysis.inference.ushape import TwoLines
from lockprobe.analysis.outcomes import Point
from lockprobe.analysis.proportions import ALPHA

__all__ = ["Course", "CourseKind", "course"]

CourseKind = Literal["rises", "falls", "rises and falls", "falls and rises", "no change detectable", "not tested"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """How success goes over p.

    Attributes:
        kind: In words.
        first: Share solved at the lowest p.
        highest: The highest share solved.
        highest_p: Where that is.
        lowest: The lowest share solved.
        lowest_p: Where that is.
        last: Share solved at the highest p.
    """

    kind: CourseKind
    first: float
    highest: float
    highest_p: float
    lowest: float
    lowest_p: float
    last: float


def course(conditions: list[Point], difference: AnyDifference, lines: TwoLines) -> Course | None:
    """The course of an agent's success over p; None without trials.

    A rise is a p at which success is above that at the lowest p, a fall one at which it is below (permutation test,
    corrected for looking at every p), at the 5 % level; or both by two lines.

    Args:
        conditions: One point per p, ascending.
        difference: The test of the differences from the lowest p.
        lines: The two-lines test.
    """
    if not conditions:
        return None
    best, worst = (pick(conditions, key=lambda point: point.success) for pick in (max, min))
    return Course(
        kind=_kind(best.p < worst.p, difference, lines),
        first=conditions[0].success,
        highest=best.success,
        highest_p=best.p,
        lowest=worst.success,
        lowest_p=worst.p,
        last=conditions[-1].success,
    )


def _kind(best_first: bool, difference: AnyDifference, lines: TwoLines) -> CourseKind:
    if difference.p_value is None:
        return "not tested"
    if lines.direction is not None:
        return "rises and falls" if lines.direction == "inverted U" else "falls and rises"
    differs = [at.value for at in difference.at if at.p_value < ALPHA]
    rises, falls = any(value > 0 for value in differs), any(value < 0 for value in differs)
    if rises and falls:
        return "rises and falls" if best_first else "falls and rises"
    return "rises" if rises else "falls" if falls else "no change detectable"
