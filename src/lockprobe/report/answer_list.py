"""The primary answer as a list: a row for each agent, drawn in per cent of its width, so that one drawing serves all.

Up to three agents that heed what they are told have a row with large numbers. More are a list that can be sorted, with
both shares on one axis: no agent is left out of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from lockprobe.foundation.formatting import capital, p_cell, p_value, percent, points
from lockprobe.report.answer import not_excluded
from lockprobe.report.curve import MOST
from lockprobe.report.format import entry_text
from lockprobe.report.prose import at_dose
from lockprobe.report.rows import Cell, Results, clearness
from lockprobe.report.rows.primary import Line, primary_lines
from lockprobe.statistics.differences import FEW_BROKE

BEFORE = "by the last step with few breaks"
"""Part of success: by the last step by which at most 5 % of trials broke under every condition."""

_TICK = 0.25
"""Step of the axis of changes; its ends are the first steps beyond all intervals, at least two."""


class AnswerList:
    """What the template of the list reads: a row for each agent, and what they have in common.

    Attributes:
        lines: A row for each agent.
        many: Whether it is the list of many agents.
        compared: Whether any agent was compared under two conditions.
        reach: The end of the axis of changes, a share.
        chance: What random agents solve, with and without immediate repeats, least first; empty if it is not known.
        doses: What the second share of each agent is at, in a word or two, where that is not the same for all.
        open: Whether a change was not detected although its interval leaves out 0.
        ticks: Where the axis of changes has labels, in per cent of it, and these.
    """

    def __init__(self, found: Results) -> None:
        self.lines = lines = primary_lines(found)
        changes = [line.change for line in lines if line.change]
        ends = [abs(end) for row in changes for end in (row.low, row.high) if end is not None]
        chance = [found.curve("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat")]
        under = {line.label: line.under for line in lines if line.under}
        differ = len({*under.values()}) > 1 and all(said.startswith("at ") for said in under.values())
        self.many, self.compared = sum(not line.alike for line in lines) > MOST, bool(changes)
        self.reach = max(2 * _TICK, math.ceil(max(ends, default=0.0) / _TICK - 1e-9) * _TICK)
        self.chance = sorted(curve.value[-1] or 0.0 for curve in chance if curve)
        self.doses = {label: said.rpartition(" ")[2] for label, said in under.items() if differ}
        self.open = any(not row.detected and ((row.low or 0.0) > 0 or (row.high or 0.0) < 0) for row in changes)
        half = max(_TICK, self.reach - _TICK)
        self.ticks = [(f"{50 + 50 * x / self.reach:.2f}%", points(x)) for x in (-half, 0.0, half)]

    @property
    def counts(self) -> list[tuple[int, str]]:
        """How many of the agents that the answer is about solve more, fewer, or are not shown to do either."""
        own = [line for line in self.lines if not line.baseline] or self.lines
        of, most = [line.verdict for line in own], not_excluded(own)
        others = {*of} & {"solves more", "solves fewer"}  # without any, the answer says how much is open
        open_ = "no effect detected" + f"; changes of up to {most} points not excluded" * bool(most and others)
        said = {"solves more": "solve more", "solves fewer": "solve fewer", "not detected": open_}
        return [(of.count(what), words) for what, words in said.items() if of.count(what) or what != "not detected"]


def said_lines(lines: Iterable[Line]) -> list[str]:
    """The list for a terminal, in columns."""
    rows = []
    for line in lines:
        first, second, change = map(entry_text, (line.first, line.second, line.change))
        shares = f"{first} {line.control}" + f", {second} {line.under}" * bool(line.second)
        tested = f"{change} points, P = {p_cell(line.change.p_value)}" if line.change else ""
        rows.append((line.label, shares, tested, line.verdict))
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    return ["  ".join(f"{cell:{width}}" for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]


def known_of_broken(found: Results, *, every: bool = False) -> list[tuple[str, str]]:
    """Agent, and what is known of its trials that broke: under its first condition with some, and by an early step.

    With ``every`` it is of all agents and conditions, else of those that the study is about.
    """
    said = []
    for agent, modality in dict.fromkeys((row.agent, row.modality) for row in found.where("last_step", of="few broke")):
        of = {"agent": agent, "modality": modality}
        cells = [
            cell for cell in found.cells if (cell.agent, cell.modality) == (agent, modality) and cell.value("broken")
        ]
        sentences = [f"{capital(_where(cell))}: {_bounds_said(cell)}" for cell in cells]
        broke, ended = (found.get("last_step", **of, of=part) for part in ("broken", "ended"))
        if broke and ended and (broke.value or 0) > (ended.value or 0):
            sentences.append(
                f"What is missing is long: half of the breaks came at step {broke.value:g} or later, other trials "
                f"ended at step {ended.value:g}."
            )
        sentences += _early(found, of)
        if every or agent in found.subjects:
            kept = sentences if every else [*sentences[:1], *sentences[len(cells) :]]
            said.append((found.label(agent, modality), " ".join(kept)))
    return said


def _bounds_said(cell: Cell) -> str:
    """What is known of the success of trials some of which broke, by Horowitz and Manski's bounds."""
    row, broken = cell.get("success"), cell.value("broken") or 0.0
    least, most = cell.value("success", "at least"), cell.value("success", "at most")
    if row is None or not row.n or least is None or most is None:
        return f"All {broken:g} trials broke." if broken > 1 else "The one trial broke."
    return (
        f"{broken:g} of {row.n + broken:g} trials broke, {row.count} of the other {row.n} opened the box: between "
        f"{percent(least)} and {percent(most)} [{percent(row.low)}, {percent(row.high)}] would have."
    )


def _early(found: Results, of: Mapping[str, str]) -> list[str]:
    """The clearest change by the last step by which few trials of any condition broke; none if nothing was compared."""
    rows = found.where("success_difference", **of, of=BEFORE)
    if (row := min(rows, key=clearness, default=None)) is None:
        return []
    step, looks = found.one("last_step", **of, of="few broke").value or 0, row.corrected_for
    known = "" if row.detected else " This does not show that there is no effect."
    many = f", corrected for {looks} comparisons" if looks > 1 else ""
    cells = {cell.condition: cell for cell in found.cells if cell.agent == row.agent}
    where = " less ".join(_where(cells[name]) if name in cells else name for name in (row.condition, row.control))
    said = (
        f"By step {step:g} at most {percent(FEW_BROKE)} of trials had broken under every condition. "
        f"By then success {where} "
    )
    return [f"{said}was {entry_text(row)} points ({p_value(row.p_value)}{many}).{known}"]


def _where(cell: Cell) -> str:
    return f"under {cell.condition}" if cell.p is None else at_dose(cell.p)
