"""The primary answer as a list: a row for each agent, drawn in per cent of its width, so that one drawing serves all.

Up to three agents that heed what they are told have a row with large numbers. More are a list that can be sorted, with
both shares on one axis: no agent is left out of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from lockprobe.foundation.formatting import capital, listed, p_cell, points
from lockprobe.report.curve import MOST
from lockprobe.report.rows import Results
from lockprobe.report.rows.primary import Line, primary_lines
from lockprobe.report.table_rows import points_cell, share_of_row

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
        """How many agents solve more, fewer, or are not shown to do either."""
        of = [line.verdict for line in self.lines]
        most = _not_excluded(self.lines)
        open_ = "no effect detected" + f"; changes of up to {most} points not excluded" * bool(most)
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


def headline(lines: Sequence[Line], cause: str) -> str:
    """What was found, in one sentence that serves one agent and thirty; empty if nothing was compared.

    Args:
        lines: The agents.
        cause: What may change their success, in the plural: false reports.

    >>> headline([], "false reports")
    ''
    """
    of = {said: [line.label for line in lines if line.verdict == said] for said in _DOES}
    more, fewer, hidden = of.values()
    changed = [f"{_DOES[said]} {_whose(of[said])}" for said in ("solves more", "solves fewer") if of[said]]
    if not changed:
        most = _not_excluded(lines)
        open_ = f"; changes of up to {most} points are not excluded" * (most > _NARROW)
        return f"No effect of {cause} on {_whose(hidden)} was detected{open_}." if hidden else ""
    if more and fewer:
        changed[1] = f"lower {_whose(fewer, 'that')}"
    rest = f"; no effect on {_whose(hidden, 'that')} was detected" if hidden else ""
    return f"{capital(cause)} {' and '.join(changed)}{rest}."


_NARROW = 10
"""Points up to which a change that is not excluded need not be said; chosen by eye."""


def _not_excluded(lines: Sequence[Line]) -> int:
    """The largest change in points that intervals of undetected changes hold; 0 without any."""
    rows = [line.change for line in lines if line.change and line.verdict == "not detected"]
    return round(100 * max((abs(end) for row in rows for end in (row.low, row.high) if end is not None), default=0.0))


_DOES = {"solves more": "raise", "solves fewer": "lower", "not detected": ""}
"""Verdict -> what was done to the success of these agents."""


def _whose(labels: Sequence[str], what: str = "the success") -> str:
    """The success of agents, by name as long as these are two."""
    return f"{what} of {listed(labels) if len(labels) < 3 else f'{len(labels)} agents'}"


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


def known_of_broken(found: Results) -> list[tuple[str, str]]:
    """Agent, and what is known of its trials that broke: under its first condition, and by an early step."""
    kinds = ("known", "long", "earlier")
    return [
        (found.label(one.agent, one.modality), one.text)
        for one in found.findings
        if one.section == "broken" and one.kind in kinds and one.agent in found.subjects
    ]
