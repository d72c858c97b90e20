"""The tables of a study of conditions, from the rows of ``results.json``, as rows of text."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.report.format import NONE, Table, p_cell, percent, points_cell
from lockprobe.report.schema import ConditionResult, CrossingResult, EffectResult

__all__ = ["crossing_table", "effect_table", "table_of_conditions"]


def effect_table(effects: Sequence[EffectResult]) -> Table:
    """Every condition against the control, in the trials that both have."""
    head = ["agent", "condition", "control", "solved, control", "solved", "difference, points", "P", "says"]
    return [head] + [
        [
            row.agent,
            row.condition,
            row.control,
            f"{row.control_solved} of {row.trials}",
            f"{row.solved} of {row.trials}",
            points_cell(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            "shown" if row.detectable else "not shown",
        ]
        for row in effects
    ]


def crossing_table(crossings: Sequence[CrossingResult]) -> Table:
    """Two interventions alone and together."""
    head = ["agent", "first", "second", "both", "second beside the first less alone, points", "P", "says"]
    return [head] + [
        [
            row.agent,
            row.first,
            row.second,
            row.both,
            points_cell(row.difference, row.difference_low, row.difference_high),
            p_cell(row.p_value),
            "shown" if row.detectable else "not shown",
        ]
        for row in crossings
    ]


def table_of_conditions(conditions: Sequence[ConditionResult]) -> Table:
    """Every agent under every condition. Intervals are 95 % Wilson; chance is for trials of exactly those lengths."""
    head = ["agent", "condition", "what acts", "modality", "trials", "success", "mean steps", "loop rate", "by chance"]
    table = [[*head, "misread", "false reports", "errors"]]
    table += [
        [
            row.agent,
            row.condition,
            row.acts or NONE,
            row.modality,
            str(row.trials),
            _share(row.success, row.success_low, row.success_high),
            NONE if row.mean_steps_all is None else f"{row.mean_steps_all:.1f}",
            _share(row.loop_rate, row.loop_rate_low, row.loop_rate_high),
            f"{percent(row.loop_rate_chance, 0)} to {percent(row.loop_rate_chance_no_repeat, 0)}",
            percent(row.misread.value) if row.claims else NONE,
            percent(row.false_report_of_all_steps.value),
            str(row.broken),
        ]
        for row in conditions
    ]
    said = {row[2] for row in table[1:]} - {NONE}
    kept = [i for i in range(len(table[0])) if _says_something(table, i) or i not in (2, 3)]
    if said <= {row[1] for row in table[1:]}:
        kept = [i for i in kept if i != 2]  # conditions without names of their own are called by what acts
    return [[row[i] for i in kept] for row in table]


def _says_something(table: Table, column: int) -> bool:
    return len({row[column] for row in table[1:]}) > 1


def _share(value: float | None, low: float | None, high: float | None) -> str:
    return NONE if value is None else f"{percent(value, 0)} [{percent(low, 0)}, {percent(high, 0)}]"
