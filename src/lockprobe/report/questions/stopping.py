"""How differences developed with the blocks, at which block each was decided, and what was played."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from lockprobe.foundation.formatting import count, listed, points
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import condition_words
from lockprobe.report.rows import Curve, Estimate, Results, Row, measured_row, who
from lockprobe.report.section import Figure, Lines, Note, Part, Section, Table
from lockprobe.studies.decisions import Decision
from lockprobe.studies.study import Study

_HOLDS = "Success and its differences hold at every look, so their intervals are wider than those of one look"

_ONE_LOOK = "as it holds for one look, at a number of people that was fixed before"

_NAMED = 3
"""Conditions or agents that a sentence names."""

_Answers = Mapping[str, Sequence[Decision]]
"""Agent -> what is decided, of a study that stops when it is."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    until = numbers.study.until
    for agent, one in ((agent, one) for agent, own in numbers.decisions.items() for one in own):
        of: dict[str, Any] = {"agent": agent, "of": one.question.name}
        course = one.course
        if course.n:
            yield measured_row("difference_by_block", course, **of, unit="points", p_value=None)
            lines = {"x": course.blocks, "value": course.means, "low": course.lows, "high": course.highs}
            points: dict[str, Any] = {name: tuple(line.tolist()) for name, line in lines.items()}
            yield Curve(quantity="difference_by_block", **of, axis="block", n=course.n, **points)
        if one.at is not None and until is not None:
            said = decided_said(one.verdict, until.points)
            yield Estimate(quantity="decided_at_block", **of, unit="blocks", value=one.at, note=said)


def every_look_said(study: Study, kind: str, answers: _Answers, played: int) -> str:
    """For how many looks the page holds, and why (``kind``); empty for a study of fixed size that is finished."""
    people = f" What people did is shown {_ONE_LOOK}." * (PEOPLE in study.agents)
    if kind == "unfinished":
        return f"{_HOLDS}; reading them now and playing on is valid.{people}"
    added = "Trials were added to this study after it had begun"
    return f"{progress_said(study, answers, played) if kind == 'until' else added}. {_HOLDS}.{people}" if kind else ""


def progress_said(study: Study, answers: _Answers, played: int) -> str:
    """How many differences a study that stops when it is decided has decided, without a full stop."""
    found = [one for own in answers.values() for one in own]
    assert study.until is not None
    what = "decided" if study.until.rule == "decided" else f"known to {study.until} points"
    done = f"{sum(one.at is not None for one in found)} of {count(len(found), 'difference')} between conditions"
    return f"{done} {what}, with {played} of at most {study.size} trials"


def small_said(found: Results) -> str:
    """Which differences are shown to be smaller than the margin, either way; empty if none is."""
    words = condition_words(found)
    small = [row for row in found.where("decided_at_block") if row.note.startswith("smaller") and row.of in words]
    by_agent = grouped(small, lambda row: row.agent).items()
    said = [f"{listed([words[row.of] for row in own], named=_NAMED)} on {who(agent)}" for agent, own in by_agent]
    rest = f"; and on {count(len(said) - _NAMED, 'more agent')}" * (len(said) > _NAMED)
    of = f"effects of {'; of '.join(said[:_NAMED])}{rest}"
    return f"Shown to be {small[0].note}, either way: {of}." if small else ""


def decided_said(verdict: str | None, points: float) -> str:
    """What was decided of a difference, in words.

    >>> decided_said("effect", 0.1), decided_said("small", 0.1), decided_said(None, 0.1)
    ('an effect', 'smaller than 10 points', 'open')
    """
    said = {"effect": "an effect", "small": f"smaller than {100 * points:g} points", "not needed": "not needed"}
    return said.get(verdict or "", f"known to ±{100 * points:g} points" if verdict else "open")


def _table(found: Results) -> Lines:
    yield ["agent", "difference", "blocks", "estimate, points", "decided", "at block"]
    for row in found.where("difference_by_block"):
        decided = found.get("decided_at_block", agent=row.agent, of=row.of)
        said = [decided.note, f"{decided.value:.0f}"] if decided else ["open", None]
        yield [row.agent, row.of, str(row.n), row, *said]


_REACH = 60
"""The widest interval that is drawn to its ends, in points."""


def draw(found: Results) -> Any:
    """A panel for each difference."""
    from lockprobe.report.figures import drawing as figures

    margin = 100 * found.study["until"]["points"]

    def on(axes: Any, curve: Curve) -> None:
        value, low, high = (100 * np.array(of, dtype=float) for of in (curve.value, curve.low, curve.high))
        axes.axhline(0, color=figures.FAINT, linewidth=0.8)
        for end in (-margin, margin):
            axes.axhline(end, color=figures.FAINT, linewidth=0.8, linestyle=":")
        axes.fill_between(curve.x, low, high, color=figures.TARGET, alpha=0.18, linewidth=0, step="post")
        axes.plot(curve.x, value, color=figures.TARGET, linewidth=1.4)
        reach = min(100.0, max(_REACH, 1.25 * float(np.abs(value[len(value) // 4 :]).max())))
        axes.set(ylim=(-reach, reach), xlim=(0, curve.x[-1] * 1.02 + 1))
        figures.whole_axis(axes, curve.x[-1], "blocks")
        step = 25 if reach < 75 else 50
        ticks = range(-step * int(reach / step), int(reach) + 1, step)
        figures.axis(axes, "y", ticks, [points(tick / 100) for tick in ticks], "difference, points")
        decided, said = found.get("decided_at_block", agent=curve.agent, of=curve.of), ""
        if decided is not None and decided.value is not None:
            axes.axvline(decided.value, color=figures.INK, linewidth=1.0, linestyle=(0, (4, 3)))
            said = f"{decided.note}, block {decided.value:.0f}"
        figures.title(axes, figures.safe_name(curve.agent, 38), figures.safe_name(curve.of, 38), said)

    curves = [one for one in found.curves if one.quantity == "difference_by_block" and len(one.x) > 1]
    curves.sort(key=lambda one: (one.of != "total", one.agent not in found.subjects))  # of many the first are drawn
    wide, high = (5.6, 2.3) if len(curves) == 1 else (3.2, 1.45)
    return figures.sheet(curves, on, height=high, width=wide)


FIGURE = Figure(
    "stopping",
    "Estimate and interval after every block, a panel for each difference",
    lambda found: Note(
        "Success under each condition minus success under the control after every block, with the interval that holds "
        "at every look. The vertical line marks the block with which it was decided, dotted is the margin.",
        "Intervals are confidence sequences of the mean by betting; several differences of an agent are corrected by "
        "closed testing.",
    ),
    draw,
    applies=lambda found: bool(found.where("difference_by_block")),
)

_TABLE = Table("stopping", _table)

_NOTE = Note(
    "A statement that is made once stays: intervals lie within those before, and P values are the smallest so far.",
    "Blocks count in the order in which they were planned, up to the first that is still open. In at most 5 % of "
    "studies one of these statements is false at any look; contrasts of arms have levels of their own. A rule that "
    "stops a study assumes that an effect does not drift while it runs.",
)


def _show(found: Results) -> Iterator[Part]:
    if rows := found.where("difference_by_block"):
        said = f"{len(found.where('decided_at_block'))} of {len(rows)} differences between conditions are decided."
        yield Part("Differences block by block", said, [FIGURE, _TABLE, _NOTE])


SECTIONS = (Section("stopping", "Differences block by block", _rows, _show, (_TABLE,), (FIGURE,)),)
