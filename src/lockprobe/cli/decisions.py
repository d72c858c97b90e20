"""What a study that stops when it is decided has decided, as lines and as facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.foundation.formatting import count, points
from lockprobe.report.questions.stopping import decided_said, progress_said
from lockprobe.studies.stopping import Answer
from lockprobe.studies.study import Study

_LINES = 6
"""Differences of an agent that have a line each."""


def decision_lines(study: Study, found: Mapping[str, Sequence[Answer]], played: int) -> list[str]:
    """How much is decided, and each difference of every agent.

    Args:
        study: A study that stops when it is decided.
        found: Agent -> its answers.
        played: Trials that are finished.
    """
    assert study.until is not None
    lines = [progress_said(study, found, played)]
    for agent, own in found.items():
        for one in own[:_LINES]:
            where = f" (block {one.at})" if one.at else f" after {count(one.course.n, 'block')}"
            halves = ""
            if not one.question.of_share and one.course.n > 1:
                whole, first, second = map(points, (one.course.value, *one.course.halves))
                halves = f"; {whole} points, {first} in the first half of the blocks and {second} in the second"
            decided = decided_said(one.verdict, study.until.points)
            lines.append(f"  {agent}, {one.question.name}: {decided}{where}{halves}")
        lines += [f"  {agent}: and {len(own) - _LINES} more, in the report"] * (len(own) > _LINES)
    return lines


def decision_facts(found: Mapping[str, Sequence[Answer]]) -> list[dict[str, object]]:
    """Every difference as JSON holds it; differences are of shares."""
    return [
        {
            "agent": agent,
            "difference": one.question.name,
            "verdict": one.verdict,
            "block": one.at,
            "blocks": one.course.n,
            "value": one.course.value if one.course.n else None,
            "low": one.course.low,
            "high": one.course.high,
            "halves": None if one.course.n < 2 else one.course.halves,
            "p_value": one.course.p_value,
        }
        for agent, own in found.items()
        for one in own
    ]
