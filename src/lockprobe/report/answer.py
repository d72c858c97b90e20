"""The answer of a study from its rows: in sentences, as a list with a row for each agent, and what is known of breaks.

The list is drawn in per cent of its width, so that one drawing serves all. Up to three agents that heed what they are
told have a row with large numbers. More are a list that can be sorted, with both shares on one axis: no agent is left
out of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from lockprobe.foundation.formatting import capital, listed, p_value, percent, points
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.curve import MOST
from lockprobe.report.format import entry_text
from lockprobe.report.primary import Line, primary_lines
from lockprobe.report.prose import at_dose
from lockprobe.report.rows import BOUNDS, Cell, Results, who
from lockprobe.statistics.differences import FEW_BROKE

_WIDE = 10
"""Points up to which a change that is not excluded need not be said; chosen by eye."""

_DOES = {"solves more": ("raise", "raises"), "solves fewer": ("lower", "lowers")}
"""Verdict -> what was done to the success of these agents, by several things and by one."""


def headline(lines: Sequence[Line], cause: str = "", *, several: bool = True) -> str:
    """What was found, in one sentence that serves one agent and thirty; empty if nothing was compared.

    The ``cause`` may change their success (false reports), which is a plural if ``several``; without one it is the
    condition of each line.
    """
    done: dict[str, dict[str, list[str]]] = {}
    for line in (line for verdict in _DOES for line in lines if line.verdict == verdict):
        done.setdefault(cause or line.conditions[-1], {}).setdefault(line.verdict, []).append(line.label)
    hidden = [line for line in lines if line.verdict == "not detected"]
    labels, names = [line.label for line in hidden], {line.conditions[-1] for line in hidden}
    if not (done or hidden):
        return ""
    if not done:
        alone = len(names) == 1 and all(line.change.corrected_for <= 1 for line in hidden if line.change)
        what = cause or (names.pop() if alone else "any condition")
        most = not_excluded(lines)
        open_ = f"; changes of up to {most} points are not excluded" * (most > _WIDE)
        return f"No effect of {what} on {_whose(labels, of=len(lines), every='any of')} was detected{open_}."
    said = []
    for what, by in done.items():
        whose = [
            f"{_DOES[verdict][not (several and cause)]} {_whose(own, 'that' if i else '', of=len(lines))}"
            for i, (verdict, own) in enumerate(by.items())
        ]
        said.append(f"{what} {' and '.join(whose)}")
    if hidden:
        others = _whose(labels, "that", of=len(lines))
        said.append(f"no effect{' of any condition' * (not cause)} on {others} was detected")
    return f"{capital('; '.join(said))}."


def beside_said(lines: Sequence[Line]) -> str:
    """What was found of agents for comparison, which the answer leaves out; empty without any beside others."""
    said, others = [], [line for line in lines if line.baseline]
    for verdict, own in grouped(others, lambda line: line.verdict).items():
        names = listed([line.label for line in own], named=3)
        if verdict == "not detected":
            said.append(f"no effect on {names} was detected")
        elif verdict != "not compared":
            said.append(f"{names} {verdict.replace('s ', ' ', 1) if len(own) > 1 else verdict}")
    few = f"{len(others)} of the {len(lines)} agents {'is a' if len(others) == 1 else 'are'}"
    strategy = "reference strategy" if len(others) == 1 else "reference strategies"
    beside = f"{few} {strategy}, for comparison and not in this answer: {'; '.join(said)}."
    return beside if said and len(others) < len(lines) else ""


def solved_said(found: Results, lines: Sequence[Line]) -> str:
    """Who solved how much where nothing was compared; of several agents, who solved the most; trials that broke."""
    shares = [(line.first.value, line) for line in lines if line.first and line.first.value is not None]
    if not shares:
        return "No trial has ended yet."
    most = max(share for share, _ in shares)
    best = [line for share, line in shares if share == most]
    sizes = sorted({line.first.n or 0 for line in best if line.first})
    of = f"{percent(most)} of {sizes[0]}{f' to {sizes[-1]}' if len(sizes) > 1 else ''} trials"
    broke = sum(int(row.value or 0) for _, line in shares for row in found.where("broken", **line.of_first, of=""))
    rest = f" {broke} trials broke and are in no share." * bool(broke)
    first = best[0]
    if len(shares) == 1:
        alike = " under every condition: it plays alike whatever it is told" * first.alike
        ends = [found.get("success", **first.of_first, of=part) for part in BOUNDS]
        between = " and ".join(percent(row.value) for row in ends if row)
        rest = f"; {broke} more broke, so of all trials it is between {between}" * bool(broke)
        name = capital(first.label) if first.agent == PEOPLE else first.label
        return f"{name} solved {of}{alike}{rest}."
    return f"Of {len(shares)} agents {listed([line.label for line in best], named=3)} solved the most: {of}.{rest}"


def not_excluded(lines: Iterable[Line]) -> int:
    """The largest change in points that intervals of undetected changes hold; 0 without any."""
    rows = [line.change for line in lines if line.change and line.verdict == "not detected"]
    return round(100 * max((abs(end) for row in rows for end in (row.low, row.high) if end is not None), default=0.0))


def _whose(labels: Sequence[str], what: str = "", *, of: int, every: str = "all") -> str:
    """The success of agents, by name as long as these are two, else how many of all."""
    many = f"{len(labels)} of {of}" if len(labels) < of else f"{every} {of}"
    return f"{what or 'the success'} of {listed(labels) if len(labels) < 3 else f'{many} agents'}"


def broken_said(found: Results) -> str:
    """That all trials of some agents ended as an error; empty without any."""
    solved = {row.agent for row in found.where("success", of="") if row.n}
    broken: dict[str, int] = {}
    for row in found.where("broken", of=""):
        if row.condition and row.value and row.agent not in solved:
            broken[row.agent] = broken.get(row.agent, 0) + int(row.value)
    if not broken:
        return ""
    which = f"All {sum(broken.values())} trials" if sum(broken.values()) > 1 else "The only trial"
    return f"{which} of {listed([*map(who, broken)], named=3)} ended as an error."


_TICK = 0.25
"""Step of the axis of changes; its ends are the first steps beyond all intervals, at least two."""


class AnswerList:
    """What the template of the list reads: a row for each agent, and what they have in common.

    Attributes:
        lines: A row for each agent.
        compared: Whether any agent was compared under two conditions.
        many: Whether so many were that each has one line, and both shares are on one axis.
        reach: The end of the axis of changes, a share.
        chance: What random agents solve, with and without immediate repeats, least first; empty if it is not known.
        doses: What the second share of each agent is at, in a word or two, where that is not the same for all.
        each: How many trials each share is of, in words.
        ticks: Where the axis of changes has labels, in per cent of it, and these.
    """

    def __init__(self, found: Results) -> None:
        self.lines = lines = primary_lines(found)
        changes = [line.change for line in lines if line.change]
        ends = [abs(end) for row in changes for end in (row.low, row.high) if end is not None]
        under = {line.label: line.under for line in lines if line.under}
        differ = len({*under.values()}) > 1 and all(said.startswith("at ") for said in under.values())
        self.compared = bool(changes)
        self.many = self.compared and sum(not line.alike for line in lines) > MOST
        self.reach = max(2 * _TICK, math.ceil(max(ends, default=0.0) / _TICK - 1e-9) * _TICK)
        self.chance = sorted(curve.value[-1] or 0.0 for curve in found.random_play)
        self.doses = {label: said.rpartition(" ")[2] for label, said in under.items() if differ}
        sizes = sorted({row.n for line in lines for row in (line.first, line.second) if row and row.n is not None})
        self.each = f"{' to '.join(map(str, (*sizes[:1], *sizes[1:][-1:])))} trials each" if sizes else ""
        half = max(_TICK, self.reach - _TICK)
        self.ticks = [(f"{50 + 50 * x / self.reach:.2f}%", points(x)) for x in (-half, 0.0, half)]

    @property
    def counts(self) -> list[tuple[int, str]]:
        """How many of the agents that the answer is about solve more, fewer, or are not shown to; the rest."""
        own = [line for line in self.lines if not line.baseline] or self.lines
        beside = len(self.lines) - len(own)
        of, most = [line.verdict for line in own], not_excluded(own)
        others = {*of} & {"solves more", "solves fewer"}  # without any, the answer says how much is open
        open_ = "no effect detected" + f"; changes of up to {most} points not excluded" * bool(most and others)
        more, fewer = f"of {len(own)} agents solve more", "solve fewer"
        said = {"solves more": more, "solves fewer": fewer, "not detected": open_}
        shown = [(of.count(what), words) for what, words in said.items() if of.count(what) or what != "not detected"]
        return shown + [(beside, "more for comparison, in italics")] * bool(beside)


def said_lines(lines: Iterable[Line]) -> list[str]:
    """The list for a terminal, in columns."""
    rows = []
    for line in lines:
        first, second, change = map(entry_text, (line.first, line.second, line.change))
        shares = f"{first} {line.control}" + f", {second} {line.under}" * bool(line.second)
        tested = f"{change} points, {p_value(line.change.p_value)}" if line.change else ""
        rows.append((line.label, shares, tested, line.verdict * (line.change is not None or line.alike)))
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    return ["  ".join(f"{cell:{width}}" for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]


def known_of_broken(found: Results, *, every: bool = False) -> list[tuple[str, str]]:
    """Agent, and what is known of its trials that broke: under its first condition with some, and until when few had.

    With ``every`` it is of all agents and conditions, else of those that the study is about.
    """
    said = []
    for row in found.where("last_step", of="few broke"):
        if not (every or row.agent in found.subjects):
            continue
        of = {"agent": row.agent, "modality": row.modality}
        own = [one for one in found.cells if (one.agent, one.modality) == (row.agent, row.modality)]
        sentences = [_bounds_said(cell) for cell in own if cell.value("broken")][: None if every else 1]
        broke, ended = (found.get("last_step", **of, of=part) for part in ("broken", "ended"))
        if broke and ended and (broke.value or 0) > (ended.value or 0):
            sentences.append(
                f"What is missing is long: half of the breaks came at step {broke.value:g} or later, other trials "
                f"ended at step {ended.value:g}."
            )
        if row.value:
            few = f"at most {percent(FEW_BROKE)} of trials had broken under every condition."
            sentences.append(f"By step {row.value:g} {few}")
        said.append((found.player(row.agent, row.modality).label, " ".join(sentences)))
    return said


def _bounds_said(cell: Cell) -> str:
    """What is known of the success under a condition some of whose trials broke, by Horowitz and Manski's bounds."""
    where = capital(f"under {cell.condition}" if cell.p is None else at_dose(cell.p))
    row, broken = cell.get("success"), cell.value("broken") or 0.0
    least, most = cell.value("success", "at least"), cell.value("success", "at most")
    if row is None or not row.n or least is None or most is None:
        return f"{where}: {f'All {broken:g} trials' if broken > 1 else 'The one trial'} broke."
    return (
        f"{where}: {broken:g} of {row.n + broken:g} trials broke, {row.count} of the other {row.n} opened the box: "
        f"between {percent(least)} and {percent(most)} [{percent(row.low)}, {percent(row.high)}] would have."
    )
