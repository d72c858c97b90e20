"""Attempts against the rules of the box: what the plant missed or forced, and success with and without a miss."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.format import TextTable
from lockprobe.report.rows import Cell, Estimate, Results, Row
from lockprobe.report.section import Block, Heading, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.report.table_rows import share_of_row
from lockprobe.statistics.broken_trials import begun
from lockprobe.statistics.clustered import ClusteredProportion, share_of
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.rules import break_shares, rule_breaks, unbroken

_NAME = "rules"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    if (rules := numbers.rules) is not None and rules.against:
        for cell in numbers.cells:
            yield from _of_cell(cell, numbers)


def _of_cell(cell: PlayedCell, numbers: StudyNumbers) -> Iterator[Estimate]:
    """The shares of one agent under one condition, also where its plant broke no rule."""
    box, trials = numbers.study.box, cell.trials
    counts, shares = rule_breaks(trials, box), break_shares(trials, box)
    if counts is None or not counts.attempts:
        return
    yield cell.estimate("attempts", counts.attempts, unit="attempts")
    yield from _share(cell, "missed_share", shares.missed)
    yield from _share(cell, "forced_share", shares.forced)
    yield from _share(cell, "moved_another_share", shares.others)
    kept = [trial for trial in trials if unbroken(trial, box) == len(trial.steps)]
    every, solved = begun(outcomes(kept), broken_off(kept))
    yield from cell.share("success_without_miss", share_of(solved, every.player, every.luck))


def _share(cell: PlayedCell, quantity: str, found: ClusteredProportion) -> list[Estimate]:
    return cell.share(quantity, found, note="clustered by trial")


def _cells(found: Results) -> list[Cell]:
    return [cell for cell in found.cells if cell.get("attempts")]


def _attempts(found: Results) -> TextTable:
    """Attempts at free and at locked joints, and how many of them broke the rules; none where none did."""
    head = ["agent", "condition", "attempts", "at free joints", "of these missed", "at locked joints"]
    table = [[*head, "of these forced", "another joint moved"]]
    for cell in _cells(found):
        missed, forced, others = (cell.get(f"{what}_share") for what in ("missed", "forced", "moved_another"))
        free, locked = (str(row.n if row else 0) for row in (missed, forced))
        shares = [free, share_of_row(missed), locked, share_of_row(forced), share_of_row(others)]
        table.append([cell.agent, cell.condition, f"{cell.value('attempts'):g}", *shares])
    return table if len(table) > 1 else []


def _success(found: Results) -> TextTable:
    """Success of all trials, and of those without a miss; none where no attempt broke the rules."""
    table = [["agent", "condition", "trials", "success", "trials without a miss", "success without a miss"]]
    for cell in _cells(found):
        every, kept = cell.get("success"), cell.get("success_without_miss")
        row = [text for one in (every, kept) for text in (str(one.n if one else 0), share_of_row(one))]
        table.append([cell.agent, cell.condition, *row])
    return table if len(table) > 1 else []


_ATTEMPTS, _SUCCESS = Table("rules", _attempts), Table("success-without-miss", _success)


def _show(found: Results) -> Iterator[Part]:
    if not _cells(found):
        return
    attempts = Note(
        "Missed: a free joint did not move. Forced: a locked joint moved.",
        "Intervals are 95 % intervals clustered by trial.",
    )
    selected = Text(
        "A longer trial has more chances of a miss. So trials without a miss tend to be shorter than others, and their "
        "success does not estimate that of a hand without misses."
    )
    success = Note(
        "The last two columns count only trials in which no attempt broke the rules. Everywhere else on these pages "
        "success is that of all trials, and success by chance is that of a box that keeps its rules.",
        "Intervals as in the table of all conditions.",
    )
    blocks: list[Block] = [_ATTEMPTS, attempts, Heading("Success with and without misses"), _SUCCESS, selected, success]
    yield Part("Attempts against the rules", _answer(found), blocks, _NAME)


def _answer(found: Results) -> str:
    rows = found.where("missed_share")
    missed = sum(row.count or 0 for row in rows)
    return f"{missed} of {sum(row.n or 0 for row in rows)} attempts at free joints missed."


SECTIONS = (
    Section(name=_NAME, title="Attempts against the rules", rows=_rows, show=_show, tables=(_ATTEMPTS, _SUCCESS)),
)
