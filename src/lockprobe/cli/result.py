"""What a study found, for a terminal or a program: its answer, the numbers of each agent, and what to do next."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count, takewhile
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind

if TYPE_CHECKING:
    from lockprobe.report.rows import Results

_LARGEST = 2**28
"""Bytes of ``results.json``."""

_LINES = 6
"""Lines on trials that broke."""

_UNTESTED = re.compile(r"Not tested for (?P<agents>.+): whether .*\((?P<option>--[^:)]+): ")
"""Who has not played false reports that stay, and what plays them, in the sentence that says so."""


@dataclass(frozen=True, slots=True)
class _Step:
    """A next step: a command as it is typed, or what is added to the one before, and what it shows."""

    command: str
    shows: str


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
    """The answer, also of every other agent, a line for each number of every agent, and the next commands."""
    agents: dict[str, list[str]] = {}
    for row in _key_numbers(found) if not _all_broken(found) else ():
        lines = agents.setdefault(row["agent"], [])
        for said in (f"{row['success']} {row['where']}", f"{row.get('change', '')} {row.get('against', '')}"):
            if said.strip() and said not in lines:
                lines.append(said)
    wide = max(map(len, agents), default=0)
    numbers = [
        f"  {agent if first else '':{wide}}  {line}"
        for agent, lines in agents.items()
        for first, line in zip([True, *[False] * len(lines)], lines, strict=False)
    ]
    if more := found.facts_about("first screen").get("more", ""):
        numbers.append(f"  {more}")
    broke = [f"  {text}" for text in _broke(found)]
    numbers += broke[:_LINES] + [f"  and {len(broke) - _LINES} more, in the report"] * (len(broke) > _LINES)
    steps = _next(found, directory)
    widest = max((len(one.command) for one in steps), default=0)
    following = [f"{'' if i else 'Next:':6}{one.command:{widest}}  {one.shows}".rstrip() for i, one in enumerate(steps)]
    answer = [f"{'' if i else 'Answer:':7} {said}" for i, said in enumerate(_answers(found))]
    return [*answer, *numbers, *following] if found.answer else following


def result_facts(found: Results, directory: Path) -> dict[str, object]:
    """The same for programs; numbers are text, as on the page, and rows of ``results.json`` hold them as numbers."""
    return {
        "answer": found.answer,
        "answers": _answers(found),
        "numbers": list(_key_numbers(found)),
        "broke": _broke(found),
        "next": [{"command": one.command, "shows": one.shows} for one in _next(found, directory)],
    }


def _answers(found: Results) -> list[str]:
    """The answer, and the verdicts on other agents of a study of why, whose answer is of the first one."""
    verdicts = [one.text for one in found.findings if (one.section, one.kind) == ("why", "verdict")]
    return [found.answer, *(said for said in verdicts if said not in found.answer)]


def _broke(found: Results) -> list[str]:
    """What is known of trials that broke, of every agent: under its first condition, and by an early step."""
    kinds = ("known", "long", "earlier")
    return [
        f"{found.label(one.agent, one.modality)}: {one.text}"
        for one in found.findings
        if one.section == "broken" and one.kind in kinds and one.agent in found.subjects
    ]


def _key_numbers(found: Results) -> Iterator[Mapping[str, str]]:
    """The key numbers of the first screen, agent by agent."""
    return takewhile(bool, (found.facts_about(f"first screen {i}") for i in count(1)))


def _next(found: Results, directory: Path) -> list[_Step]:
    """What is worth typing next: to see one trial, and to decide what is open or to look into what was found."""
    if again := _all_broken(found):
        return [again]
    said = {one.kind: one.text for one in found.findings if one.section == "overview"}
    where, steps = quote(str(directory)), []
    if trial := next((one.key for one in found.exhibits if one.section == "trials"), ""):
        steps.append(_Step(f"lockprobe replay {where} {quote(trial)}", "one trial, the truth beside what was told"))
    if untested := _UNTESTED.search(said.get("untested", "")):
        played = any(one.doses.get("flip.keep", 0) > 0 for one in found.design.conditions)
        whose = f", for {untested['agents']}" if played else ""
        shows = f"whether false reports that stay do the same{whose}"
        steps.append(_Step(f"the same command with {untested['option']}", shows))
    elif "needed" in said:
        steps.append(_Step("the same command with more --trials", said["needed"]))
    elif any("flip.p" in one.doses for one in found.design.conditions) and _can_be_forked(found):
        steps.append(_Step(f"lockprobe branch {where}", "what one false report does, from a recorded step on"))
    return steps


def _can_be_forked(found: Results) -> bool:
    """Whether an agent played that can be asked again: not a person, nor a client with tools."""
    return any(row.n and spec_kind(row.agent) not in (PEOPLE, MCP) for row in found.where("success"))


def _all_broken(found: Results) -> _Step | None:
    """What plays the trials again, if no trial of an agent that the study is about ended; None if one did."""
    broken = [row for row in found.where("broken", condition="") if row.agent in found.subjects]
    ended = {row.agent for row in found.where("success") if row.n}
    if not broken or ended & {*found.subjects}:
        return None
    final = [row.of for row in broken if found.fact(f"{row.agent}, broken at {row.of}", "will be replayed") == "no"]
    again = " and then ".join(dict.fromkeys(f"--again {of}" for of in final))
    return _Step(
        f"the same command{f' with {again}' * bool(again)}", "plays the broken trials again, when the cause is mended"
    )
