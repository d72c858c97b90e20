"""The primary answer as a list: a row for each agent, drawn in per cent of its width, so that one drawing serves all.

Up to three agents that heed what they are told have a row with large numbers. More are a list that can be sorted, with
both shares on one axis: no agent is left out of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from lockprobe.foundation.formatting import capital, p_cell, p_value, percent, points
from lockprobe.report.answer import not_excluded
from lockprobe.report.curve import MOST
from lockprobe.report.prose import at_dose
from lockprobe.report.rows import Cell, Results, clearness
from lockprobe.report.rows.primary import Line, primary_lines
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.statistics.inference.difference import FEW_BROKE

BEFORE = "by the last step with few breaks"
"""Part of success: by the last step by which at most 5 % of trials broke under every condition."""

_TICK = 0.25
"""Step of the axis of changes; its ends are the first steps beyond all intervals, at least two."""


@dataclass(frozen=True, slots=True)
class AnswerList:
    """What the template of the list reads.

    Attributes:
        lines: A row for each agent.
        many: Whether it is the list of many agents.
        compared: Whether any agent was compared under two conditions.
        reach: The end of the axis of changes, a share.
        chance: What random agents solve, with and without immediate repeats, least first; empty if it is not known.
    """

    lines: Sequence[Line]
    many: bool
    compared: bool
    reach: float
    chance: tuple[float, ...]

    def at(self, change: float) -> str:
        """Where a change stands, in per cent of the axis."""
        return f"{50 + 50 * change / self.reach:.2f}%"

    @property
    def doses(self) -> Mapping[str, str]:
        """What the second share of each agent is at, in a word or two, where that is not the same for all."""
        under = {line.label: line.under for line in self.lines if line.under}
        if len({*under.values()}) < 2 or not all(said.startswith("at ") for said in under.values()):
            return {}
        return {label: said.rpartition(" ")[2] for label, said in under.items()}

    @property
    def open(self) -> bool:
        """Whether a change was not detected although its interval leaves out 0."""
        rows = [line.change for line in self.lines if line.change and line.verdict == "not detected"]
        ends = [(row.low, row.high) for row in rows if row.low is not None and row.high is not None]
        return any(low > 0 or high < 0 for low, high in ends)

    @property
    def ticks(self) -> list[tuple[str, str]]:
        """Where the axis of changes has labels, and these."""
        half = max(_TICK, self.reach - _TICK)
        return [(self.at(x), points(x)) for x in (-half, 0.0, half)]

    @property
    def counts(self) -> list[tuple[int, str]]:
        """How many of the agents that the answer is about solve more, fewer, or are not shown to do either."""
        own = [line for line in self.lines if not line.baseline] or self.lines
        of, most = [line.verdict for line in own], not_excluded(own)
        others = {*of} & {"solves more", "solves fewer"}  # without any, the answer says how much is open
        open_ = "no effect detected" + f"; changes of up to {most} points not excluded" * bool(most and others)
        said = {"solves more": "solve more", "solves fewer": "solve fewer", "not detected": open_}
        return [(of.count(what), words) for what, words in said.items() if of.count(what) or what != "not detected"]


def answer_list(found: Results) -> AnswerList:
    """The list of a study."""
    lines = primary_lines(found)
    ends = [abs(end) for line in lines if line.change for end in (line.change.low, line.change.high) if end is not None]
    reach = max(2 * _TICK, math.ceil(max(ends, default=0.0) / _TICK - 1e-9) * _TICK)
    chance = [found.curve("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat")]
    return AnswerList(
        lines=lines,
        many=sum(not line.alike for line in lines) > MOST,
        compared=any(line.change for line in lines),
        reach=reach,
        chance=tuple(sorted(curve.value[-1] or 0.0 for curve in chance if curve)),
    )


def said_lines(lines: Iterable[Line]) -> list[str]:
    """The list for a terminal, in columns."""
    rows = []
    for line in lines:
        first, second, change = (share_of_row(line.first), share_of_row(line.second), points_cell(line.change))
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
    return [f"{said}was {points_cell(row)} points ({p_value(row.p_value)}{many}).{known}"]


def _where(cell: Cell) -> str:
    return f"under {cell.condition}" if cell.p is None else at_dose(cell.p)
