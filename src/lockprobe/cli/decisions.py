"""What a study that stops when it is decided has decided, as lines and as facts."""

from __future__ import annotations

from collections.abc import Iterable

from lockprobe.foundation.formatting import count, points
from lockprobe.report.questions.stopping import decided_said, progress_said
from lockprobe.studies.decisions import Decision, answers_by_agent
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

_LINES = 6
"""Differences of an agent that have a line each."""


def decided(study: Study, trials: Iterable[Trial]) -> tuple[list[str], list[dict[str, object]]]:
    """How much is decided, and each difference of every agent; differences in facts are of shares.

    Args:
        study: A study that stops when it is decided.
        trials: Its own on record.
    """
    assert study.until is not None
    trials = list(trials)
    found = answers_by_agent(study, trials)
    lines, facts = [progress_said(study, found, study.places_filled(trials))], list[dict[str, object]]()
    for agent, own in found.items():
        facts += [{"agent": agent, **_plain(one)} for one in own]
        for one in own[:_LINES]:
            course, halves = one.course, ""
            where = f" (block {one.at})" if one.at else f" after {count(course.n, 'block')}"
            if not one.question.of_share and course.n > 1:
                whole, first, second = map(points, (course.value, *course.halves))
                halves = f"; {whole} points, {first} in the first half of the blocks and {second} in the second"
            lines.append(
                f"  {agent}, {one.question.name}: {decided_said(one.verdict, study.until.points)}{where}{halves}"
            )
        if len(own) > _LINES:
            lines.append(f"  {agent}: and {len(own) - _LINES} more, in the report")
    return lines, facts


def _plain(one: Decision) -> dict[str, object]:
    course = one.course
    return {
        "difference": one.question.name,
        "verdict": one.verdict,
        "block": one.at,
        "blocks": course.n,
        "value": course.value if course.n else None,
        "low": course.low,
        "high": course.high,
        "halves": None if course.n < 2 else course.halves,
        "p_value": course.p_value,
    }
