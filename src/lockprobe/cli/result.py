"""What a study found, for a terminal or a program: its answer, the numbers of each agent, and what to do next."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind

if TYPE_CHECKING:
    from lockprobe.report.primary import Line
    from lockprobe.report.rows import Results

_LARGEST = 2**28
"""Bytes of ``results.json``."""

_LINES = 6
"""Lines on trials that broke."""


def read_result(directory: Path) -> Results | None:
    """The results that the last report of a study wrote; None if there are none that can be read."""
    # a tenth of a second of imports, which the first trials need not wait for
    from pydantic import ValidationError

    from lockprobe.report.rows import Results

    try:
        return Results.model_validate_json(read_input(directory / "results.json", _LARGEST))
    except (LockprobeError, ValidationError):
        return None


def result_lines(found: Results, directory: Path) -> list[str]:
    """The answer, a line for every agent, and the next commands."""
    from lockprobe.report.answer import known_of_broken, said_lines
    from lockprobe.report.primary import primary_lines

    lines = [] if _all_broken(found) else primary_lines(found)
    broke = [f"{agent}: {said}" for agent, said in known_of_broken(found)]
    numbers = [f"  {line}" for line in (*said_lines(lines), *broke[:_LINES])]
    numbers += [f"  and {len(broke) - _LINES} more, in the report"] * (len(broke) > _LINES)
    steps = _next(found, directory)
    widest = max((len(command) for command, _ in steps), default=0)
    following = [f"{'' if i else 'Next:':6}{command:{widest}}  {shows}" for i, (command, shows) in enumerate(steps)]
    return [f"Answer: {found.answer}", *numbers, *following] if found.answer else following


def result_facts(found: Results, directory: Path) -> dict[str, object]:
    """The same for programs."""
    from lockprobe.report.answer import known_of_broken
    from lockprobe.report.primary import primary_lines

    return {
        "answer": found.answer,
        "agents": [] if _all_broken(found) else [_plain(line) for line in primary_lines(found)],
        "broke": [f"{agent}: {said}" for agent, said in known_of_broken(found)],
        "next": [{"command": command, "shows": shows} for command, shows in _next(found, directory)],
    }


def _plain(line: Line) -> dict[str, object]:
    """The line of an agent for programs: shares and their difference as numbers."""
    size, rows = ("value", "low", "high", "n", "p_value"), (("first", line.first), ("second", line.second))
    numbers = {of: {name: getattr(row, name) for name in size} for of, row in (*rows, ("change", line.change)) if row}
    asked = {"contrast": line.cause} if line.cause else {}
    said = {"control": line.control, "under": line.under, **numbers, "verdict": line.verdict}
    return {"agent": line.label, **asked, **said}


def _next(found: Results, directory: Path) -> list[tuple[str, str]]:
    """What is worth typing next, or adding to the command that was typed, and what it shows."""
    if again := _all_broken(found):
        return [again]
    where, steps = quote(str(directory)), list[tuple[str, str]]()
    if trial := found.fact("trials", "first"):
        steps.append((f"lockprobe replay {where} {quote(trial)}", "one trial, the truth beside what was told"))
    if any("flip.p" in one.doses for one in found.design.conditions) and any(
        row.n and spec_kind(row.agent) not in (PEOPLE, MCP)  # neither of these can be asked again
        for row in found.where("success")
    ):
        steps.append((f"lockprobe branch {where}", "what one false report does, from a recorded step on"))
    return steps


def _all_broken(found: Results) -> tuple[str, str] | None:
    """What plays the trials again, if no trial of an agent that the study is about ended; None if one did."""
    broken = [row for row in found.where("broken", condition="") if row.agent in found.subjects]
    ended = {row.agent for row in found.where("success") if row.n}
    if not broken or ended & {*found.subjects}:
        return None
    final = [row.of for row in broken if found.fact(f"{row.agent}, broken at {row.of}", "will be replayed") == "no"]
    again = " and then ".join(dict.fromkeys(f"--again {of}" for of in final))
    return (
        f"the same command{f' with {again}' * bool(again)}",
        "plays the broken trials again, when the cause is mended",
    )
