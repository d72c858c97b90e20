"""The tables that compare agents, from the rows of ``results.json``."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.agent_comparison.leaderboard_row import Regret
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import Paired
from lockprobe.formatting import NONE, bracketed, p_cell, percent
from lockprobe.report.format import EVERY, TextTable, share_cell
from lockprobe.report.leaderboard import (
    ComparisonResult,
    InteractionResult,
    LeaderboardByDose,
    LeaderboardResult,
    MoneyResult,
)
from lockprobe.studies.spending import dollars

__all__ = [
    "comparison_by_p_table",
    "comparison_table",
    "interaction_table",
    "leaderboard_by_p_table",
    "leaderboard_table",
]

_MEASURES = ["success", "80 % by step", "relative area", "loops above chance", "misread"]
_MONEY = ["tokens in", "cached", "tokens out", "US$", "US$ per solved trial"]


def leaderboard_table(rows: Sequence[LeaderboardResult]) -> TextTable:
    """Every agent over all p, the highest success first."""
    spent = _spent(rows)
    head = ["rank", "agent", "trials", *_MEASURES, *(_MONEY if spent else [])]
    return [head] + [
        [_rank(row), row.label, str(row.trials), *_measures(row), *(_money(row.money) if spent else [])] for row in rows
    ]


def leaderboard_by_p_table(rows: Sequence[LeaderboardResult]) -> TextTable:
    """The same by p; of an agent that plays the same at every p only once."""
    spent = _spent(rows)
    table = [["agent", "flip rate", "trials", *_MEASURES, *(_MONEY if spent else [])]]
    for row in rows:
        for at in row.by_p[:1] if row.same_at_every_p else row.by_p:
            p = EVERY if row.same_at_every_p else f"{at.p:g}"
            cells = [row.label, p, str(at.trials), *_measures(at)]
            table.append([*cells, *(_money(at.money) if spent else [])])
    return table


def comparison_table(rows: Sequence[ComparisonResult]) -> TextTable:
    """Every two agents over all p, on the same boxes with the same false reports."""
    head = ["agent", "compared with", "pairs of trials", "success", "success of the other", "difference, points"]
    return [[*head, "P", "corrected P", "difference in steps", "P", "corrected P", "played by one only"]] + [
        [
            row.second_label,
            row.first_label,
            str(row.success.pairs),
            percent(row.second_success, 0),
            percent(row.first_success, 0),
            _points(row.success),
            p_cell(row.success.p_value),
            p_cell(row.success.p_adjusted),
            _signed(row.steps),
            p_cell(row.steps.p_value),
            p_cell(row.steps.p_adjusted),
            str(row.finished_by_one_only),
        ]
        for row in rows
    ]


def comparison_by_p_table(rows: Sequence[ComparisonResult]) -> TextTable:
    """The same by p; of two agents that both play alike at every p only once."""
    head = ["agent", "compared with", "flip rate", "pairs of trials", "solved only by the first"]
    head += ["solved only by the other", "difference, points", "McNemar", "corrected P", "difference in steps"]
    return [head] + [
        [
            row.second_label,
            row.first_label,
            EVERY if row.same_at_every_p else f"{at.p:g}",
            str(at.success.n),
            str(at.success.only_second),
            str(at.success.only_first),
            _points(at.success),
            p_cell(at.success.p_value),
            p_cell(at.success.p_adjusted),
            _signed(at.steps),
        ]
        for row in rows
        for at in (row.by_p[:1] if row.same_at_every_p else row.by_p)
    ]


def interaction_table(rows: Sequence[InteractionResult]) -> TextTable:
    """Differences between agents in the effect of false reports."""
    head = ["agent", "compared with", "from flip rate", "to flip rate", "difference in change, points"]
    table = [[*head, "P, corrected for flip rates", "P, corrected for pairs"]]
    for row in rows:
        names = [row.second_label, row.first_label, f"{row.lowest:g}"]
        table.append([*names, "all higher, mean", _points(row.mean), p_cell(row.p_value), p_cell(row.p_adjusted)])
        table += [[*names, f"{at.p:g}", _points(at.change), p_cell(at.p_adjusted), NONE] for at in row.at]
    return table


def _rank(row: LeaderboardResult) -> str:
    low, high = row.rank_low, row.rank_high
    return NONE if low is None else f"{low}" if low == high else f"{low} to {high}"


def _measures(row: LeaderboardResult | LeaderboardByDose) -> list[str]:
    return [
        share_cell(row.success),
        "not reached" if row.steps_to_80 is None else f"{row.steps_to_80}",
        NONE if row.regret is None else _area(row.regret),
        bracketed(row.loops_above_chance, None, None),
        _misread(row),
    ]


def _misread(row: LeaderboardResult | LeaderboardByDose) -> str:
    if row.misread.n:
        return share_cell(row.misread)
    return "not asked" if row.not_asked else NONE


def _money(spent: MoneyResult) -> list[str]:
    least = "at least " if spent.uncounted_calls else ""
    return [
        _count(spent.input_tokens),
        percent(spent.cached_share, 0),
        _count(spent.output_tokens),
        *(NONE if amount is None else least + dollars(amount) for amount in (spent.dollars, spent.dollars_per_solved)),
    ]


def _spent(rows: Sequence[LeaderboardResult]) -> bool:
    return any(row.money.input_tokens is not None or row.money.uncounted_calls for row in rows)


def _count(tokens: int | None) -> str:
    return NONE if tokens is None else str(tokens)


def _points(found: BlockMean | Paired) -> str:
    return bracketed(found.value, found.low, found.high)


def _signed(found: BlockMean) -> str:
    return bracketed(found.value, found.low, found.high, "{:+.1f}", 1)


def _area(regret: Regret) -> str:
    """The area under the success curve, 0 for a random agent and 1 for the shortest plan: what regret leaves of 1."""
    low, high = (None if end is None else 1 - end for end in (regret.high, regret.low))
    return bracketed(1 - regret.value, low, high, "{:.2f}", 1)
