"""Results of a study whose attempts broke the rules of the box: all numbers, and no sentence that judges an agent.

A hand that misses is no agent that fails. What a sentence would say of an agent, the plant may have done.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from lockprobe.report.format import TextTable
from lockprobe.report.schema import Results

__all__ = ["NOT_JUDGED", "judging_nobody", "marked", "without_verdicts"]

NOT_JUDGED = "not judged"
"""The verdict on an agent, whatever the question."""

_VERDICTS = {"conclusion", "course of success", "loops begin"}
"""Columns of tables that hold verdicts."""


def judging_nobody(content: Results) -> Results:
    """The results with the reason why no agent is judged in place of every sentence that would judge one."""
    said = content.not_judged
    if not said:
        return content
    changed: dict[str, Any] = {"findings": [said]}
    if content.overview:
        unsaid = {"answer": said, "chance": "", "interaction": "", "needed": ""}
        changed["overview"] = content.overview.model_copy(update=unsaid)
    if content.forks:
        changed["forks_said"] = [said]
    if content.has_conditions:
        changed |= _of_conditions(content, said)
    return content.model_copy(update=changed | _of_flips(content, said))


def _of_flips(content: Results, said: str) -> dict[str, Any]:
    return {
        "answers": {section: one if section == "conditions" else said for section, one in content.answers.items()},
        "modality_findings": [],
        "loop_findings": [""],
        "conclusions": [[]],
        "ranking_said": "",
        "comparisons_said": [],
        "beside": "",
        "courses_said": "",
        "lies": [row.model_copy(update={"said": said}) for row in content.lies],
        "claims": [replace(row, verdict=NOT_JUDGED, test=said) if row.agent else row for row in content.claims],
    }


def _of_conditions(content: Results, said: str) -> dict[str, Any]:
    one = {"findings": [said], "loop_findings": [""], "conclusions": [[]], "courses_said": said}
    return {
        "condition_findings": [],
        "series": [row.model_copy(update=one) for row in content.series],
        "why": [row.model_copy(update={"verdict": NOT_JUDGED, "said": [said]}) for row in content.why],
    }


def without_verdicts(table: TextTable, content: Results) -> TextTable:
    """A table whose columns of verdicts say that nobody is judged, if nobody is."""
    if not content.not_judged:
        return table
    head, *rows = table
    return [head] + [
        [NOT_JUDGED if name in _VERDICTS else cell for name, cell in zip(head, row, strict=True)] for row in rows
    ]


def marked(table: TextTable, content: Results) -> TextTable:
    """A table of numbers that judge nobody, with a column that says so."""
    if not content.not_judged:
        return table
    return [[*row, "no" if i else "judged"] for i, row in enumerate(table)]
