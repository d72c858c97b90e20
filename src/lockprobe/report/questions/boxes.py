"""Several boxes: whether what was found holds on each of them, and what it says of boxes like these."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from lockprobe.foundation.formatting import end_of, listed, p_value
from lockprobe.report.format import alone, beside, entry_text
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import Line, primary_lines
from lockprobe.report.rows import Estimate, Results, Row, measured_row
from lockprobe.report.section import Block, Lines, Note, Part, Section, Table
from lockprobe.statistics.blocks import blocks_of
from lockprobe.statistics.clustered import FEWEST_BOXES
from lockprobe.statistics.pairs import FEWEST, between_boxes, paired
from lockprobe.statistics.proportions import ALPHA, proportion

_BETWEEN = "SD between boxes"
"""Part of a difference: its standard deviation between boxes, with the test of whether it differs."""

_FURTHER = "a further box"
"""Part of a difference: the range in which it lies on one more box."""

_TEST = "F between boxes and Cochran's Q, the larger P"


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    """Success on each box, what a condition changes there, and whether that differs between them."""
    if len(numbers.study.boxes) == 1:
        return
    for cell in numbers.cells:
        for box in numbers.study.boxes:
            own = cell.ended.solved[cell.ended.box == box.name]
            yield from cell.share("success", proportion(int(own.sum()), len(own)), of=box.name)
        control = numbers.by_name.get((cell.agent, numbers.design.control(cell.condition)))
        if control is None or control is cell:
            continue
        solved, played = blocks_of([control.ended, cell.ended]).whole([0, 1])
        if len(np.unique(played)) < 2:
            continue
        of: dict[str, Any] = {"control": control.condition, "unit": "points"}
        for name in dict.fromkeys(played.tolist()):
            found = paired(*solved[played == name].T)
            yield measured_row("success_difference", found, **cell.of, **of, of=name, p_value=None)
        if between := between_boxes(solved[:, 0], solved[:, 1], played):
            mean, deviation = between
            tested = {"p_value": mean.p_value, "test": _TEST, "n": mean.n, "clusters": mean.clusters}
            yield cell.estimate("success_difference", deviation, of=_BETWEEN, **tested, **of)
            yield measured_row("success_difference", mean, **cell.of, **of, of=_FURTHER, p_value=None)


def boxes_said(found: Results) -> str:
    """Of what the intervals of a study are: more trials on its boxes, or boxes like these."""
    names = [str(box.get("name", "")) for box in found.boxes]
    k = len(names)
    if k == 1:
        return f"All trials are of {names[0]}. Intervals are for more trials on this box; other boxes may differ."
    these = f"The boxes are {listed(names, named=_NAMED)}. Intervals"
    if k < FEWEST:
        return f"{these} are for more trials on these {_NUMBERS[k]}, which are too few to speak of boxes like these."
    shares = "" if k >= FEWEST_BOXES else f", and those of single shares for these {k}"
    drawn = all(re.fullmatch(r"random-[2-8]-\d+", name) for name in names)
    taken = "" if drawn else ", if these are taken as a sample"
    return f"{these} of changes are for boxes like these {k}{taken}{shares}; every box counts alike."


_NUMBERS, _NAMED = {2: "two", 3: "three", 4: "four"}, 4
"""Numbers as words; boxes that a sentence names."""


def _lines(found: Results) -> list[Line]:
    """The agents whose change is tested, those that the study is about first."""
    return [line for line in primary_lines(found) if line.change and line.second and not line.alike]


def _of(found: Results, line: Line, of: str) -> Estimate | None:
    """A part of the change of an agent."""
    control, condition = line.conditions
    return found.get("success_difference", agent=line.agent, condition=condition, control=control, axis="", of=of)


def _on(found: Results, line: Line, name: str) -> list[Estimate | None]:
    """Success of an agent on a box under the two conditions of its line, and its change."""
    of = {"agent": line.agent, "modality": line.modality, "of": name}
    first, second = (found.get("success", condition=one, **of) for one in line.conditions)
    return [first, second, beside(_of(found, line, name), first, second)]


def differ_said(found: Results) -> str:
    """On which agents the effect differs between boxes, and what it is on each of a few; empty if on none."""
    tested = [(line, row) for line in _lines(found) if (row := _of(found, line, _BETWEEN))]
    differ = [line for line, row in tested if row.p_value is not None and row.p_value < ALPHA]
    if not differ:
        return ""
    names = [str(box.get("name", "")) for box in found.boxes]
    said = f"The effect on {listed([line.label for line in differ], named=3)} differs between boxes"
    if len(differ) > 1 or len(names) > _NAMED:
        return f"{said}."
    rows = {name: alone(_on(found, differ[0], name)[-1]) for name in names}
    changes = [f"{entry_text(row)} points on {name}" for name, row in rows.items() if row]
    return f"{said}: {listed(changes)}."


def _table(found: Results) -> Lines:
    """Success on each box and over all, and its change."""
    yield ["agent", "box", "control", "changed", "change, points"]
    for line in _lines(found):
        for name in (str(box.get("name", "")) for box in found.boxes):
            yield [line.label, name, *_on(found, line, name)]
        yield [line.label, "all boxes", line.first, line.second, line.change]


_TABLE = Table("boxes", _table, drawn="change, points")

_NOTE = Note(
    "Success on each box under the two conditions of the answer, and its change in pairs of trials; intervals are for "
    "more trials on that box, one by one.",
    "Over boxes: Student's interval over their changes, joined with that of these boxes. Whether effects differ: the "
    "larger P of an F test and of Cochran's Q.",
    "Where few boxes differ at all, the interval allows for boxes with large changes that are not among these. Curves, "
    "mean steps, loops, fits and the paper's claims count trials: they are for more trials on these.",
)


def _show(found: Results) -> Iterator[Part]:
    if len(found.boxes) == 1:
        return
    lines, more = _lines(found), []
    for line in lines:
        whole, further = (_of(found, line, of) for of in (_BETWEEN, _FURTHER))
        if whole is not None and further is not None and len(found.boxes) >= FEWEST:
            more.append(
                f"{line.label} {line.under}: standard deviation of the change between boxes "
                f"{100 * (whole.value or 0.0):.0f} points ({p_value(whole.p_value)}). With as many trials on one more "
                f"box like these, a change between {end_of(further.low or 0.0)} and {end_of(further.high or 0.0)} "
                "points would be seen."
            )
    no = "No difference of the effect between boxes was detected." if lines else boxes_said(found)
    every_look = bool(found.progress.every_look)
    once = ["Numbers of a single box hold for one look, those of all boxes at every look."] * every_look
    shown: list[Block] = [[*more, *once], _TABLE, _NOTE] if lines else []
    yield Part("Does it hold on every box?", differ_said(found) or no, shown)


SECTIONS = (Section("boxes", "Boxes", _rows, _show, (_TABLE,)),)
