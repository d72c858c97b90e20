"""People: who played and what they opened, beside agents on the same boxes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.format import TextTable
from lockprobe.report.people_said import (
    conditions_said,
    flow_said,
    limits_said,
    opened_said,
    steps_said,
)
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import share_of_row
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.people import People, PeopleAt
from lockprobe.studies.study import Study

if TYPE_CHECKING:
    from lockprobe.people.progress import Flow

_BY_PERSON = "by person"
"""Marks numbers whose interval is clustered by person and block."""

_BEYOND = "beyond the budget"

_people = partial(Estimate, agent=PEOPLE)
"""A row of all people."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    opened, found = numbers.opened, numbers.people
    if not opened.study.invited and found is None:
        return
    from lockprobe.people.progress import flow_of  # the whole experiment, which no study of agents needs

    flow = flow_of(opened.study, opened.diaries, opened.withdrawn)
    for of, count in (("planned", opened.study.invited), ("finished", opened.finished_by_people)):
        yield _people(quantity="boxes", of=of, value=count, unit="boxes")
    if flow:
        yield from _flow(flow, found.people if found else 0)
    if found:
        yield from _all_people(found)
        for at in (*found.at, *found.over):
            yield from _at(at, _place(opened.study, at))
    yield from _said(numbers, flow)


def _place(study: Study, at: PeopleAt) -> dict[str, Any]:
    """What a number is of: one condition, or all conditions of a modality."""
    doses = dict(study.labelled(at.condition).doses) if at.condition else {}
    return {"modality": at.modality, "condition": at.condition, "doses": doses}


_STAGES = ("consented", "withdrawn", "screened", "left_open", "finished", "analysed")
"""The flow of participants. Nothing is recorded of people before they agree."""


def _flow(flow: Flow, analysed: int) -> Iterator[Estimate]:
    """Who came to the end, the boxes that they were given, questions on the instructions, and attention checks."""
    counts = {**asdict(flow), "analysed": analysed}
    for of in (*_STAGES, *(("questioned", "second_round") if flow.questioned else ())):
        yield _people(quantity="participants", of=of, value=counts[of], unit="people")
    for one in flow.boxes:
        for of, count in (("given", one.given), ("left_open", one.left_open)):
            yield _people(quantity="boxes", condition=one.condition, of=of, value=count, unit="boxes")
    if flow.checks:
        share = flow.right / flow.checks
        yield _people(quantity="attention_checks", value=share, count=flow.right, n=flow.checks)


def _all_people(found: People) -> Iterator[Estimate]:
    """All people together, under all conditions; by the position of the box, and what they were shown."""
    yield _people(quantity="people", value=found.people, unit="people")
    for of, count in (("fewest", found.fewest), ("most", found.most)):
        yield _people(quantity="boxes_each", of=of, value=count, unit="boxes")
    yield from share_rows("success", found.success, agent=PEOPLE, of=_BY_PERSON)
    yield _people(quantity="success", of="every person alike", value=found.alike, n=found.people)
    for one in found.positions:
        yield from share_rows("success", one.success, agent=PEOPLE, of=f"position={one.position}")
    for name, values in found.saw.items():
        for value, count in values.items():
            yield _people(quantity="trials_shown", of=f"{name}={value}", value=count, unit="trials")


def _at(at: PeopleAt, place: dict[str, Any]) -> Iterator[Estimate]:
    """People under one condition, or in one modality over all conditions."""
    yield _people(quantity="people", **place, value=at.people, unit="people")
    yield from share_rows("success", at.success, agent=PEOPLE, **place, of=_BY_PERSON)
    of, steps = {**place, "of": _BY_PERSON, "unit": "steps", "n": at.success.n}, at.steps
    note = _BEYOND if steps.median is None else "open high" if steps.high is None and steps.low is not None else ""
    yield _people(quantity="median_steps_all", **of, value=steps.median, low=steps.low, high=steps.high, note=note)
    yield _people(quantity="mean_steps_all", **of, value=steps.mean)


def _said(numbers: StudyNumbers, flow: Flow | None) -> Iterator[Finding]:
    plain = partial(Finding, section="people", judges=False)
    for text in flow_said(flow, numbers.people.people if numbers.people else 0) if flow else ():
        yield plain(text=text, rests_on=("participants", "boxes"))
    if found := numbers.people:
        yield plain(text=opened_said(found), rests_on=("people", "boxes_each", "success"))
        where = {at.condition: _where(numbers.study, at) for at in found.at}
        for text in conditions_said(found, where):
            yield plain(text=text, rests_on=("success",))
        for text in steps_said(found):
            yield plain(text=text, rests_on=("median_steps_all",))
        yield plain(text=limits_said(found), rests_on=("trials_shown",))


def _where(study: Study, at: PeopleAt) -> str:
    """What a sentence says of a condition: its name, or its flip rate if all conditions are flip rates."""
    if not study.of_flips:
        return f"under {at.condition}"
    shown = f", shown as {spoken(at.modality)}" if len(study.modalities) > 1 else ""
    return f"at a flip rate of {study.labelled(at.condition).p:g}{shown}"


def _over(row: Estimate) -> dict[str, str]:
    """What a row is of, to find others of the same."""
    return {name: getattr(row, name) for name in ("agent", "modality", "condition", "versus")}


def _condition(found: Results, row: Estimate) -> str:
    """What tables call the condition of a row: its name, or its flip rate if all conditions are flip rates."""
    if found.beside_flips or not row.condition:
        return row.condition or "all"
    return next(f"{one.p:g}" for one in found.design.conditions if one.name == row.condition)


def _varied(found: Results) -> str:
    return "condition" if found.beside_flips else "flip rate"


def _people_table(found: Results) -> TextTable:
    """People by condition, and over all conditions last."""
    every = [row for row in found.where("success", agent=PEOPLE, of=_BY_PERSON) if row.modality]
    if not every:
        return []
    at, over = [row for row in every if row.condition], [row for row in every if not row.condition]
    several = len(over) > 1
    head = [_varied(found), "people", "trials", "solved", "success", "median steps", "mean steps"]
    table = [(["modality"] if several else []) + head]
    for row in [*at, *(over if len(at) > len(over) else [])]:
        people, steps, mean = (
            found.one(quantity, **_over(row), of=of)
            for quantity, of in (("people", ""), ("median_steps_all", _BY_PERSON), ("mean_steps_all", _BY_PERSON))
        )
        cells = [_condition(found, row), f"{people.value:g}", str(row.n), str(row.count), share_of_row(row)]
        cells += [_steps_cell(steps), f"{mean.value:.1f}"]
        table.append([row.modality, *cells] if several else cells)
    return table


def _steps_cell(row: Estimate) -> str:
    if row.low is None and row.high is None:
        return _step(row.value)
    return f"{_step(row.value)} [{_step(row.low)}, {_step(row.high)}]"


def _step(steps: float | None) -> str:
    return _BEYOND if steps is None else f"{steps:g}"


def _positions_table(found: Results) -> TextTable:
    """Success of first boxes, of second ones, and so on."""
    if not _any(found):
        return []
    rows = [row for row in found.where("success", agent=PEOPLE) if row.of.startswith("position=")]
    return [["position", "trials", "solved", "success"]] + [
        [row.of.removeprefix("position="), str(row.n), str(row.count), share_of_row(row)] for row in rows
    ]


def _any(found: Results) -> bool:
    """Whether a trial of people has ended."""
    return found.get("people", agent=PEOPLE, modality="") is not None


_PEOPLE = Table("people", _people_table, numeric_from=1)
_POSITIONS = Table("people-positions", _positions_table, numeric_from=0)


def _caption(found: Results) -> Caption:
    each = _trials_each(found) if any(cell.agent != PEOPLE for cell in found.cells) else ""
    return Caption(
        f"{'People, models and strategies' if each else 'People'}: success by {_varied(found)}"
        f"{f' in all their trials ({each})' if each else ''}. People play several boxes and may learn from one to the "
        "next; agents keep nothing.",
        "Bars are 95 % intervals, clustered by person and block for people.",
        "Baselines are thin with hollow markers and have no bars." if each else "",
    )


def _trials_each(found: Results) -> str:
    """How many trials people and agents have, as: for each flip rate 4 to 5 of people and 48 of an agent."""
    theirs, others = set[int](), set[int]()
    for cell in found.cells:
        if row := cell.get("success"):
            (theirs if cell.agent == PEOPLE else others).add(row.n or 0)
    said = (" to ".join(str(end) for end in sorted({min(ns), max(ns)})) for ns in (theirs, others))
    return f"for each {_varied(found)} {next(said)} of people and {next(said)} of an agent"


_FIGURE = Figure(
    "people",
    "Success under each condition: people, models and strategies",
    _caption,
    draw="lockprobe.report.figures.people:people",
    applies=_any,
)

_OF_STEPS = Note(
    "Median steps: Kaplan-Meier estimates with unsolved trials censored at the budget; in means they count with the "
    "whole budget.",
    "Intervals resample people with all their boxes, and blocks of trials; each end is the wider of the two.",
)
_OF_POSITIONS = Note(
    "Later positions include only people who stayed. Agents keep nothing from box to box.",
    "Intervals are Wilson intervals: each person has one box at each position.",
)
_OF_PEOPLE = Note(
    Markup(
        "In tables, people are one agent, <code>participant</code>. Each trial was played by one "
        "person, and another person may have played the same trial under another condition."
    ),
    "Tests of conditions cluster trials by person, as they cluster trials of other agents by block; if everybody "
    "plays under one condition, whole people are permuted. Comparisons with an agent cluster by both.",
)


def _show(found: Results) -> Iterator[Part]:
    planned, finished = (found.get("boxes", agent=PEOPLE, condition="", of=of) for of in ("planned", "finished"))
    if planned is not None and finished is not None:
        played, asked = int(finished.value or 0), int(planned.value or 0)
        owed = f"; {asked - played} are still available" if asked != played else ""
        said = f"{played} of {asked} boxes for people were played{owed}."
        yield Part("People", said, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    yield from map(Text, found.said("people"))
    if not _any(found):
        return
    yield _FIGURE
    yield _PEOPLE
    yield _OF_STEPS
    if len(_positions_table(found)) > 2:
        yield Detail("Success by position of the box: do people learn?", [_POSITIONS, _OF_POSITIONS])
    yield _OF_PEOPLE


SECTIONS = (
    Section(
        name="people",
        title="People",
        rows=_rows,
        show=_show,
        tables=(_PEOPLE, _POSITIONS),
        figures=(_FIGURE,),
    ),
)
