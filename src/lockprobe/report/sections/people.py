"""People: who played, what they opened, how long they took, and agents' steps relative to theirs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.format import TextTable
from lockprobe.report.people_said import (
    compared_said,
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
from lockprobe.statistics.relative_steps import RelativeSteps
from lockprobe.statistics.response_times import ResponseTimes, response_times
from lockprobe.studies.study import Study

if TYPE_CHECKING:
    from lockprobe.people.progress import Flow

__all__ = ["SECTIONS"]

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
    from lockprobe.people.step_times import times_of_steps

    flow = flow_of(opened.study, opened.diaries, opened.withdrawn)
    times = times_of_steps(opened.study, opened.trials, opened.diaries, opened.directory)
    for of, count in (("planned", opened.study.invited), ("finished", opened.finished_by_people)):
        yield _people(quantity="boxes", of=of, value=count, unit="boxes")
    if flow:
        yield from _flow(flow, found.people if found else 0)
    if found:
        yield from _all_people(found)
        for at in (*found.at, *found.over):
            yield from _at(at, _place(opened.study, at))
        for relative in found.relative:
            yield from _relative(relative, _place(opened.study, relative))
    for took in response_times(opened.trials, times):
        yield from _times(took, _place(opened.study, took))
    yield from _said(numbers, flow)


def _place(study: Study, at: PeopleAt | RelativeSteps | ResponseTimes) -> dict[str, Any]:
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


def _relative(one: RelativeSteps, place: dict[str, Any]) -> Iterator[Estimate]:
    """The steps of an agent relative to those of people, on the trials of both."""
    both: dict[str, Any] = {"agent": one.agent, "versus": PEOPLE, "versus_modality": one.modality, "n": one.trials}
    both |= place
    for of, median in (("agent", one.steps), ("people", one.people)):
        note = _BEYOND if median is None else ""
        yield Estimate(quantity="median_steps_of_both", **both, of=of, value=median, unit="steps", note=note)
    for value, note in ((one.ratio, ""), (one.least, "at least"), (one.most, "at most")):
        if value is not None:
            ratio = partial(Estimate, quantity="steps_ratio", **both, unit="ratio", note=note)
            yield ratio(value=value, low=one.low, high=one.high)
    ratio = partial(Estimate, quantity="mean_steps_ratio", **both, unit="ratio")
    yield ratio(value=one.mean_ratio, low=one.mean_low, high=one.mean_high)


def _times(took: ResponseTimes, place: dict[str, Any]) -> Iterator[Estimate]:
    """How long people took for a choice: median and quartiles, and the median of first choices."""
    values = {"": took.median, "lower quartile": took.low, "upper quartile": took.high, "first choices": took.first}
    for of, value in values.items():
        if value is not None:
            n = took.choices if of != "first choices" else None
            yield _people(quantity="response_time", **place, of=of, value=value, unit="ms", n=n)


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
        for text in compared_said(found, _names(numbers, found), where):
            yield Finding(section="people", kind="finding", text=text, rests_on=("steps_ratio",))
        yield plain(text=limits_said(found), rests_on=("trials_shown",))


def _where(study: Study, at: PeopleAt) -> str:
    """What a sentence says of a condition: its name, or its flip rate if all conditions are flip rates."""
    if not study.of_flips:
        return f"under {at.condition}"
    shown = f", shown as {spoken(at.modality)}" if len(study.modalities) > 1 else ""
    return f"at a flip rate of {study.labelled(at.condition).p:g}{shown}"


def _names(numbers: StudyNumbers, found: People) -> dict[tuple[str, str], str]:
    """What sentences call the agents that the study is about; the baselines if people are its only subject."""
    known = {(agent.agent, agent.modality): agent.name for agent in numbers.flips.agents}
    every = dict.fromkeys((one.agent, one.modality) for one in found.relative)
    subjects = [one for one in every if one[0] in numbers.subjects]
    return {one: known.get(one, one[0]) for one in subjects or every}


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
    """People by condition, and over all conditions last; with how long they took for a choice, if that is known."""
    every = [row for row in found.where("success", agent=PEOPLE, of=_BY_PERSON) if row.modality]
    if not every:
        return []
    at, over = [row for row in every if row.condition], [row for row in every if not row.condition]
    several, timed = len(over) > 1, bool(found.where("response_time"))
    head = [_varied(found), "people", "trials", "solved", "success", "median steps", "mean steps"]
    head += ["ms per choice", "ms of first choices"] if timed else []
    table = [(["modality"] if several else []) + head]
    for row in [*at, *(over if len(at) > len(over) else [])]:
        people, steps, mean = (
            found.one(quantity, **_over(row), of=of)
            for quantity, of in (("people", ""), ("median_steps_all", _BY_PERSON), ("mean_steps_all", _BY_PERSON))
        )
        cells = [_condition(found, row), f"{people.value:g}", str(row.n), str(row.count), share_of_row(row)]
        cells += [_steps_cell(steps), f"{mean.value:.1f}", *(_took(found, row) if timed else [])]
        table.append([row.modality, *cells] if several else cells)
    return table


def _took(found: Results, row: Estimate) -> list[str]:
    names = ("", "lower quartile", "upper quartile", "first choices")
    median, low, high, first = (_whole(found.get("response_time", **_over(row), of=of)) for of in names)
    return [NONE if median == NONE else f"{median} [{low}, {high}]", first]


def _whole(row: Estimate | None) -> str:
    return NONE if row is None else f"{row.value:.0f}"


def _steps_cell(row: Estimate) -> str:
    if row.low is None and row.high is None:
        return _step(row.value)
    return f"{_step(row.value)} [{_step(row.low)}, {_step(row.high)}]"


def _step(steps: float | None) -> str:
    return _BEYOND if steps is None else f"{steps:g}"


def _steps_table(found: Results) -> TextTable:
    """Agents' steps and those of people."""
    if not _any(found):
        return []
    head = [
        "agent",
        _varied(found),
        "common trials",
        "median steps",
        "median of people",
        "ratio",
        "ratio of mean steps",
    ]
    return [head] + [
        [
            found.label(row.agent, row.modality),
            _condition(found, row),
            str(row.n),
            *(_step(found.one("median_steps_of_both", **_over(row), of=of).value) for of in ("agent", "people")),
            _ratio(found.get("steps_ratio", **_over(row))),
            _ratio(row),
        ]
        for row in found.where("mean_steps_ratio", versus=PEOPLE)
    ]


def _ratio(row: Estimate | None) -> str:
    """A ratio with its interval; an end that is None is open, if the other is none."""
    if row is None:
        return NONE
    said = f"{row.note} {row.value:.2f}".lstrip()
    if row.low is None and row.high is None:
        return said
    return f"{said} [{', '.join('open' if end is None else f'{end:.2f}' for end in (row.low, row.high))}]"


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
_STEPS = Table("people-steps", _steps_table, numeric_from=2)
_POSITIONS = Table("people-positions", _positions_table, numeric_from=0)


def _caption(found: Results) -> Caption:
    """Of the panel on steps, where another agent played trials that people played."""
    own = f"success by {_varied(found)}"
    learning = "People play several boxes and may learn from one to the next; agents keep nothing."
    bars = "Bars are 95 % intervals, clustered by person and block for people"
    if not found.where("mean_steps_ratio", versus=PEOPLE):
        return Caption(f"People: {own}. {learning}", f"{bars}.")
    return Caption(
        f"People, models and strategies: {own} in all their trials ({_trials_each(found)}), and beside or below an "
        f"agent's median steps divided by the human median, in trials that both played. {learning}",
        f"{bars}; bars that reach the edge of the lower panel are open. In medians unsolved trials are censored at the "
        "budget.",
        "Baselines are thin with hollow markers and have no bars.",
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
    "Success under each condition and steps relative to the human median: people, models and strategies",
    _caption,
    draw="lockprobe.report.figures.people:people",
    applies=_any,
)

_OF_TIMES = Note(
    "Milliseconds per choice: median and quartiles over all choices. First choices, which include looking at a new "
    "panel, are part of these and also shown separately.",
    Markup(
        "A time starts when the box is on the screen and ends with the choice, by the clock of the page "
        "(<code>performance.now</code>). It excludes the question about the last action."
    ),
)
_OF_STEPS = Note(
    "Steps in the trials that people also played, with the same panel, labels and interventions. Ratios above 1: more "
    "steps than people; at most and at least: one of the two medians exceeds the budget.",
    "Medians are Kaplan-Meier estimates with unsolved trials censored at the budget; in means they count with the "
    "whole budget. Intervals resample people with all their boxes, and blocks of trials; each end is the wider of the "
    "two.",
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
    if found.where("response_time"):
        yield _OF_TIMES
    if len(_steps_table(found)) > 1:
        yield _STEPS
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
        tables=(_PEOPLE, _STEPS, _POSITIONS),
        figures=(_FIGURE,),
    ),
)
