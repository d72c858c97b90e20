"""People: who played and what they opened, beside agents on the same boxes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np
from markupsafe import Markup

from lockprobe.foundation.formatting import count, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.format import alone, entry_text
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import condition_words
from lockprobe.report.rows import Estimate, Results, Row, share_rows
from lockprobe.report.section import Block, Figure, Lines, Note, Part, Section, Table
from lockprobe.statistics.clustered import alike_weights, share_of
from lockprobe.statistics.outcomes import ended, outcomes
from lockprobe.statistics.proportions import proportion
from lockprobe.trial.record import Trial

_BY_PERSON = "by person"
"""Marks numbers whose interval is clustered by person and block."""

_FLOW = {
    "withdrawn": "withdrew (their data are deleted)",
    "left_open": "left boxes unfinished or still playing",
    "finished": "finished all their boxes",
}
"""What became of those who agreed to take part, in words."""

_WHO = "person", "people"

_people = partial(Estimate, agent=PEOPLE)
"""A row of all people."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    begun = [trial for trial in numbers.analysed if trial.player]
    own = ended(begun)
    if not numbers.study.invited and not own:
        return
    from lockprobe.people.diary import boxes_of, flow_of  # the whole experiment, which no study of agents needs

    yield _people(quantity="boxes", of="planned", value=numbers.study.invited, unit="boxes")
    yield _people(quantity="boxes", of="finished", value=numbers.finished_by_people, unit="boxes")
    sizes = Counter(trial.agent for trial in own)
    if flow := flow_of(numbers.diaries, numbers.withdrawn):
        flow["analysed"] = len(sizes)
        for of in ("consented", *_FLOW, "analysed", *["questioned", "second_round"] * bool(flow["questioned"])):
            yield _people(quantity="people", of=of, value=flow[of], unit="people")
        for condition, boxes in boxes_of(numbers.study, numbers.diaries).items():
            for of, many in zip(("given", "left_open"), boxes, strict=True):
                yield _people(quantity="boxes", condition=condition, of=of, value=many, unit="boxes")
        if checks := flow["checks"]:
            right: dict[str, Any] = {"value": flow["right"] / checks, "count": flow["right"], "n": checks}
            yield _people(quantity="people", of="attention checks", **right)
    if own:
        yield from _all_people(begun, own, sizes)
    for cell in numbers.cells:
        if cell.agent == PEOPLE and len(cell.ended):
            yield cell.estimate("people", len({*cell.ended.player.tolist()}), unit="people")


def _all_people(begun: Sequence[Trial], own: Sequence[Trial], sizes: Counter[str]) -> Iterator[Estimate]:
    """All people together, under all conditions; and by the position of the box."""
    yield _people(quantity="people", value=len(sizes), unit="people")
    for of, boxes in (("fewest of a person", min(sizes.values())), ("most of a person", max(sizes.values()))):
        yield _people(quantity="boxes", of=of, value=boxes, unit="boxes")
    every = outcomes(begun)
    yield from share_rows("success", share_of(every.known, every.player, every.luck), agent=PEOPLE, of=_BY_PERSON)
    alike = float(np.mean([trial.solved for trial in own] * alike_weights([trial.agent for trial in own])))
    yield _people(quantity="success", of="every person alike", value=alike, n=len(sizes))
    placed = [(at, trial.solved) for trial in own if isinstance(at := trial.facts.get("position"), int)]
    for at, those in sorted(grouped(placed, itemgetter(0)).items()):  # one box of each person: Wilson's interval
        found = proportion(sum(solved for _, solved in those), len(those))
        yield from share_rows("success", found, agent=PEOPLE, of=f"position={at}")


def _flow_said(found: Results) -> Iterator[str]:
    """Who came to the end and who did not, and how questions and checks were answered."""
    people = {row.of: int(row.value or 0) for row in found.where("people", condition="", modality="")}
    if "consented" not in people:
        return
    ends = ", ".join(f"{people[of]} {said}" for of, said in _FLOW.items() if people[of])
    yield f"{count(people['consented'], *_WHO)} agreed to take part: {ends}. {people['analysed']} are in the analysis."
    if people.get("second_round"):
        yield f"{people['second_round']} needed more than one round of the questions on the instructions."
    given, left = ({row.condition: row for row in found.where("boxes", of=of)} for of in ("given", "left_open"))
    if people["left_open"] and given:
        each = (f"{left[one].value:g} of {row.value:g} under {one}" for one, row in given.items())
        yield f"Unfinished boxes: {', '.join(each)}."
    for row in found.where("people", of="attention checks"):
        yield f"Attention checks: {row.count} of {row.n} answered correctly."


def _opened_said(found: Results) -> Iterator[str]:
    """How many boxes people opened, over all conditions and of their first ones."""
    everyone = found.one("people", agent=PEOPLE, modality="", condition="")
    every = found.one("success", agent=PEOPLE, modality="", condition="", of=_BY_PERSON)
    fewest, most = (found.one("boxes", of=f"{of} of a person").value for of in ("fewest", "most"))
    alike = f"; with every person counted alike it is {percent(found.one('success', of='every person alike').value)}"
    each = f"{fewest:g} each" if fewest == most else f"{fewest:g} to {most:g} each{alike}"
    opened = f"{count(int(everyone.value or 0), *_WHO)} opened {every.count} of {every.n} boxes"
    yield f"{opened} ({entry_text(every)}), {each}."
    first = found.get("success", of="position=1")
    if first and most != 1:
        of = f"{first.count} of {first.n} ({entry_text(first)})"
        yield f"Of their first boxes they opened {of}: people remember earlier boxes, agents do not."


def _table(found: Results) -> Lines:
    """People by condition, and by the position of the box."""
    yield ["condition", "people", "boxes", "success", "mean steps"]
    for cell in found.cells:
        if cell.agent == PEOPLE and (many := cell.get("people")):
            name = condition_words(found)[cell.condition]
            steps = alone(cell.get("mean_steps_all"))
            yield [name, f"{many.value:g}", str(cell.trials), cell.get("success"), steps]
    positions = [row for row in found.where("success", agent=PEOPLE) if row.of.startswith("position=")]
    for row in positions if len(positions) > 1 else ():
        yield [f"box {row.of.removeprefix('position=')} of a person", str(row.n), str(row.n), row, None]


_TABLE = Table("people", _table, 1)

_MOST = 8
"""Agents that are drawn, people first, then those that the study is about."""

_HEAD, _ROW = 0.26, 0.15
"""Heights of the name of a condition and of a row, in inches."""


def draw(found: Results) -> Any:
    """Success of people and of agents beside them, a group of rows for each condition; None without people."""
    from lockprobe.report.figures import drawing as figures

    many = len(found.design.players)
    players = sorted(found.design.players, key=lambda one: (one.agent != PEOPLE, not one.subject))[:_MOST]
    by_player = grouped(found.cells, lambda cell: (cell.agent, cell.modality))
    cells = [cell for one in players for cell in by_player[one.agent, one.modality]]
    shown = [(cell, row) for cell in cells if (row := cell.get("success"))]
    by_condition = grouped(shown, lambda pair: pair[0].condition)
    groups = {words: by_condition[name] for name, words in condition_words(found).items() if name in by_condition}

    def on(axes: Any, everyone: Estimate) -> None:
        y, across = 0.0, axes.get_yaxis_transform()
        for name, rows in groups.items():
            axes.text(0.0, y + 0.17, figures.safe_name(name, 44), transform=across, va="baseline", color=figures.INK)
            y += _HEAD
            for cell, row in rows:
                figures.estimates(axes, [y], [row], figures.style_of(cell), across=True)
                y += _ROW
        axes.set_ylim(y, 0.0)
        figures.share_axis(axes, "success", "x")
        for player in players:
            style = next(figures.style_of(cell) for cell in cells if cell.agent == player.agent)
            axes.plot([], [], label=figures.agent_label(player), **style.line)
        beside = "agents" if len(players) == many else f"{len(players) - 1} of {many - 1} agents"
        said = count(int(everyone.value or 0), *_WHO)
        figures.title(axes, f"{said} beside {beside}; bars: 95 % intervals")

    height = sum(_HEAD + _ROW * len(rows) for rows in groups.values())
    return figures.sheet(found.where("people", agent=PEOPLE, of="", modality=""), on, height=height, width=5.0)


_FIGURE = Figure(
    "people",
    "Success under each condition: people, models and strategies",
    lambda found: Note(
        "Success by condition: people, then agents on the same boxes. People play several boxes and may learn from one "
        "to the next; agents keep nothing.",
        "Bars are 95 % intervals, clustered by person and block for people. Baselines are thin.",
    ),
    draw,
    applies=lambda found: found.get("people", agent=PEOPLE, modality="") is not None,
)

_NOTE = Note(
    "In mean steps an unsolved box counts with the whole budget. Later boxes include only people who stayed; those who "
    "left early have no trials for the others.",
    "Intervals of success are clustered by person and block; of the first, second, … box they are Wilson intervals. "
    "All are of the boxes that were played, not of others like them.",
    Markup(
        "<p>In <code>results.json</code>, people are one agent, <code>participant</code>. Each trial was played by one "
        "person, and another person may have played the same trial under another condition. Tests cluster trials by "
        "person and block. Comparisons with an agent count only if they hold with every person counted alike.</p>"
    ),
)


def _show(found: Results) -> Iterator[Part]:
    planned, finished = (found.get("boxes", agent=PEOPLE, condition="", of=of) for of in ("planned", "finished"))
    if planned is None or finished is None:
        return
    played, asked = int(finished.value or 0), int(planned.value or 0)
    owed = f"; {asked - played} are still available" if asked != played else ""
    any_ended = _FIGURE.applies(found)
    said = [*_flow_said(found), *(_opened_said(found) if any_ended else ())]
    blocks: list[Block] = [said] if said else []
    blocks += [_FIGURE, _TABLE, _NOTE] if any_ended else []
    yield Part("People", f"{played} of {asked} boxes for people were played{owed}.", blocks)


SECTIONS = (Section("people", "People", _rows, _show, (_TABLE,), (_FIGURE,)),)
