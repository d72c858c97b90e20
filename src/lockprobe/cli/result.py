"""What a study found and has decided, as lines for people and as facts for programs.

The report takes a second to import, for which help and the first trials need not wait.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.formatting import count, first_three, points
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind
from lockprobe.report.left_out import LeftOutSection
from lockprobe.studies import RESULTS
from lockprobe.studies.decisions import answers_by_agent
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

if TYPE_CHECKING:
    from lockprobe.report.rows import Results

_LINES = 6
"""Lines on trials that broke, and on differences of an agent; the others are in the report."""

_WIDER = "  Intervals hold at every look, so they are wider than those of one look."

Said = tuple[list[str], dict[str, object]]
"""Lines for people, and the same as facts for programs."""


def write(directory: Path) -> tuple[Path, Said]:
    """Write the report of a study. Gives its page, and the page's line with what :func:`found` says."""
    from lockprobe.report.page import write_report

    left_out: list[LeftOutSection] = []
    page = write_report(directory, tell=partial(print, "Report:", file=sys.stderr), left_out=left_out.append)
    results = read_result(directory)
    lines, facts = ([], {}) if results is None else found(results, directory)
    facts |= {"left_out": [one._asdict() for one in left_out]} if left_out else {}
    missing = first_three([f"{one.section} ({one.reason})" for one in left_out], "; ")
    return page, ([f"Report: {page}{', without ' * bool(missing)}{missing}", *lines], facts)


def read_result(directory: Path) -> Results | None:
    """The results that the last report of a study wrote; None if there are none that can be read."""
    from pydantic import ValidationError

    from lockprobe.report.rows import Results

    try:
        return Results.model_validate_json(read_input(directory / RESULTS))
    except (LockprobeError, ValidationError):
        return None


def found(results: Results, directory: Path) -> Said:
    """The answer, the numbers of every agent, and what is worth typing next, with what it shows."""
    from lockprobe.report.answer import known_of_broken, said_lines
    from lockprobe.report.primary import primary_lines

    steps, primary = dict[str, str](), primary_lines(results)
    broken = [row for row in results.where("broken", condition="") if row.agent in results.subjects]
    if broken and {row.agent for row in results.where("success") if row.n}.isdisjoint(results.subjects):
        final = any(results.fact(f"{row.agent}, broken at {row.of}", "will be replayed") == "no" for row in broken)
        steps[f"the same command{' with another --out' * final}"] = (
            "plays the broken trials again, when their cause is mended"
        )
        primary = []
    elif trial := results.fact("trials", "first"):
        where, played = quote(str(directory)), [row for row in results.where("success") if row.n]
        steps[f"lockprobe replay {where} {quote(trial)}"] = "one trial, the truth beside what was told"
        flipped = any("flip.p" in one.doses for one in results.design.conditions)
        if flipped and any(spec_kind(row.agent) not in (PEOPLE, MCP) for row in played):
            own = sorted({row.agent for row in played if spec_kind(row.agent) == "python"})
            allowed = "".join(f" --allow {quote(spec)}" for spec in own)
            steps[f"lockprobe branch {where}{allowed}"] = "what one false report does, from a recorded step on"
    broke = [f"{agent}: {said}" for agent, said in known_of_broken(results)]
    numbers = [f"  {line}" for line in (*said_lines(primary), *broke[:_LINES])]
    numbers += [f"  and {len(broke) - _LINES} more, in the report"] * (len(broke) > _LINES)
    numbers += [_WIDER] * bool(primary and results.progress.every_look)
    widest = max(map(len, steps), default=0)
    following = [f"{'' if i else 'Next:':6}{one:{widest}}  {shows}" for i, (one, shows) in enumerate(steps.items())]
    lines = [f"Answer: {results.answer}", *numbers, *following] if results.answer else following
    return lines, {"answer": results.answer, "broke": broke, "next": [*steps]}


def decided(study: Study, trials: Sequence[Trial]) -> tuple[list[str], list[dict[str, object]]]:
    """How much is decided, and each difference of every agent; differences in facts are of shares.

    Args:
        study: A study that stops when it is decided.
        trials: Its own on record.
    """
    from lockprobe.report.questions.stopping import decided_said, progress_said

    assert study.until is not None
    by_agent = answers_by_agent(study, trials)
    lines, facts = [progress_said(study, by_agent, study.places_filled(trials))], list[dict[str, object]]()
    for agent, own in by_agent.items():
        for i, one in enumerate(own):
            course, halves = one.course, ""
            fact = {"agent": agent, "difference": one.question.name, "verdict": one.verdict, "block": one.at}
            size = {name: getattr(course, name) for name in ("value", "low", "high", "p_value")}
            facts.append(fact | {"blocks": course.n, **(size if course.n else {})})
            if not one.question.of_share and course.n > 1:
                whole, first, second = map(points, (course.value, *course.halves))
                halves = f"; {whole} points, {first} in the first half of the blocks and {second} in the second"
            where = f" (block {one.at})" if one.at else f" after {count(course.n, 'block')}"
            said = f"  {agent}, {one.question.name}: {decided_said(one.verdict, study.until.points)}{where}{halves}"
            lines += [said] * (i < _LINES)
        lines += [f"  {agent}: and {len(own) - _LINES} more, in the report"] * (len(own) > _LINES)
    return lines, facts
