"""The tables of agents side by side, from the rows of ``results.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lockprobe.formatting import NONE, bracketed, minus, percent, share
from lockprobe.report.format import EVERY, Table
from lockprobe.studies.spending import dollars

__all__ = [
    "comparison_by_p_table",
    "comparison_table",
    "interaction_table",
    "leaderboard_by_p_table",
    "leaderboard_table",
]

Row = Mapping[str, Any]
Rows = Sequence[Row]

_MEASURES = ["success", "80 % by step", "regret", "loops above chance", "misread"]
_MONEY = ["tokens in", "cached", "tokens out", "US$", "US$ per solved trial"]


def leaderboard_table(rows: Rows) -> Table:
    """Every agent over all p, the highest success first."""
    spent = _spent(rows)
    head = ["rank", "agent", "trials", *_MEASURES, *(_MONEY if spent else [])]
    return [head] + [
        [_rank(row), row["label"], str(row["trials"]), *_measures(row), *(_money(row["money"]) if spent else [])]
        for row in rows
    ]


def leaderboard_by_p_table(rows: Rows) -> Table:
    """The same by p; of an agent that plays the same at every p only once."""
    spent = _spent(rows)
    table = [["agent", "flip rate", "trials", *_MEASURES, *(_MONEY if spent else [])]]
    for row in rows:
        for at in row["by_p"][:1] if row["same_at_every_p"] else row["by_p"]:
            p = EVERY if row["same_at_every_p"] else f"{at['p']:g}"
            cells = [row["label"], p, str(at["trials"]), *_measures(at)]
            table.append([*cells, *(_money(at["money"]) if spent else [])])
    return table


def comparison_table(rows: Rows) -> Table:
    """Every two agents over all p, on the same boxes with the same false reports."""
    head = ["agent", "against", "pairs of trials", "success", "against", "difference, points", "P", "corrected"]
    return [[*head, "difference in steps", "P", "corrected", "finished by one only"]] + [
        [
            row["second_label"],
            row["first_label"],
            str(row["success"]["pairs"]),
            percent(row["second_success"]),
            percent(row["first_success"]),
            _points(row["success"]),
            _p(row["success"]["p_value"]),
            _p(row["success"]["p_adjusted"]),
            _signed(row["steps"]),
            _p(row["steps"]["p_value"]),
            _p(row["steps"]["p_adjusted"]),
            str(row["finished_by_one_only"]),
        ]
        for row in rows
    ]


def comparison_by_p_table(rows: Rows) -> Table:
    """The same by p; of two agents that both play alike at every p only once."""
    head = ["agent", "against", "flip rate", "pairs of trials", "solved only by the first named", "only by the other"]
    return [[*head, "difference, points", "McNemar", "corrected", "difference in steps"]] + [
        [
            row["second_label"],
            row["first_label"],
            EVERY if row["same_at_every_p"] else f"{at['p']:g}",
            str(at["success"]["n"]),
            str(at["success"]["only_second"]),
            str(at["success"]["only_first"]),
            _points(at["success"]),
            _p(at["success"]["p_value"]),
            _p(at["success"]["p_adjusted"]),
            _signed(at["steps"]),
        ]
        for row in rows
        for at in (row["by_p"][:1] if row["same_at_every_p"] else row["by_p"])
    ]


def interaction_table(rows: Rows) -> Table:
    """Whether false reports change both agents alike."""
    head = [
        "agent",
        "against",
        "change from flip rate",
        "to flip rate",
        "changes more by, points",
        "corrected for flip rate",
    ]
    table = [[*head, "corrected for pairs"]]
    for row in rows:
        names = [row["second_label"], row["first_label"], f"{row['lowest']:g}"]
        table.append([*names, "higher, mean", _points(row["mean"]), _p(row["p_value"]), _p(row["p_adjusted"])])
        table += [[*names, f"{at['p']:g}", _points(at["change"]), _p(at["p_adjusted"]), NONE] for at in row["at"]]
    return table


def _rank(row: Row) -> str:
    low, high = row["rank_low"], row["rank_high"]
    return NONE if low is None else f"{low}" if low == high else f"{low} to {high}"


def _measures(row: Row) -> list[str]:
    return [
        _share(row["success"]),
        "not reached" if row["steps_to_80"] is None else f"{row['steps_to_80']}",
        NONE if row["regret"] is None else _bare(row["regret"], "{:.2f}"),
        NONE if row["loops_above_chance"] is None else minus(f"{100 * row['loops_above_chance']:+.0f}"),
        _misread(row),
    ]


def _misread(row: Row) -> str:
    if row["misread"]["n"]:
        return _share(row["misread"])
    return "not asked" if row["not_asked"] else NONE


def _money(spent: Row) -> list[str]:
    least = "at least " if spent["uncounted_calls"] else ""
    return [
        _count(spent["input_tokens"]),
        percent(spent["cached_share"]),
        _count(spent["output_tokens"]),
        *(
            NONE if amount is None else least + dollars(amount)
            for amount in (spent["dollars"], spent["dollars_per_solved"])
        ),
    ]


def _spent(rows: Rows) -> bool:
    return any(row["money"]["input_tokens"] is not None or row["money"]["uncounted_calls"] for row in rows)


def _count(tokens: int | None) -> str:
    return NONE if tokens is None else str(tokens)


def _share(found: Row) -> str:
    return share(found["value"], found["low"], found["high"])


def _points(found: Row) -> str:
    return bracketed(found["value"], found["low"], found["high"])


def _signed(found: Row) -> str:
    return _bare(found, "{:+.1f}")


def _bare(found: Row, form: str) -> str:
    return bracketed(found["value"], found["low"], found["high"], form, 1)


def _p(value: float | None) -> str:
    return NONE if value is None else f"{value:.2g}"
