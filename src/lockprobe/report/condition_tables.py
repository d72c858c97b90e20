"""The tables of a study of conditions, from the rows of ``results.json``, as rows of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lockprobe.formatting import NONE, bracketed, percent
from lockprobe.report.format import Table

__all__ = ["crossing_table", "effect_table", "table_of_conditions"]

Rows = Sequence[Mapping[str, Any]]
"""Rows of ``results.json``."""


def effect_table(effects: Rows) -> Table:
    """Every condition against the control, in the trials that both have."""
    head = ["agent", "condition", "control", "solved, control", "solved", "difference, points", "P", "says"]
    return [head] + [
        [
            row["agent"],
            row["condition"],
            row["control"],
            f"{row['control_solved']} of {row['trials']}",
            f"{row['solved']} of {row['trials']}",
            bracketed(row["difference"], row["difference_low"], row["difference_high"]),
            f"{row['p_value']:.2g}",
            "shown" if row["detectable"] else "not shown",
        ]
        for row in effects
    ]


def crossing_table(crossings: Rows) -> Table:
    """Two interventions alone and together."""
    head = ["agent", "first", "second", "both", "second beside the first less alone, points", "P", "says"]
    return [head] + [
        [
            row["agent"],
            row["first"],
            row["second"],
            row["both"],
            bracketed(row["difference"], row["difference_low"], row["difference_high"]),
            NONE if row["p_value"] is None else f"{row['p_value']:.2g}",
            "shown" if row["detectable"] else "not shown",
        ]
        for row in crossings
    ]


def table_of_conditions(conditions: Rows) -> Table:
    """Every agent under every condition. Intervals are 95 % Wilson; chance is for trials of exactly those lengths."""
    head = ["agent", "condition", "what acts", "modality", "trials", "success", "mean steps", "loop rate", "by chance"]
    table = [[*head, "misread", "false reports", "errors"]]
    table += [
        [
            row["agent"],
            row["condition"],
            row["acts"] or NONE,
            row["modality"],
            str(row["trials"]),
            _share(row, "success"),
            NONE if row["mean_steps_all"] is None else f"{row['mean_steps_all']:.1f}",
            _share(row, "loop_rate"),
            f"{percent(row['loop_rate_chance'])} to {percent(row['loop_rate_chance_no_repeat'])}",
            percent(row["misread"]["value"], 1) if row["claims"] else NONE,
            percent(row["false_report_of_all_steps"]["value"], 1),
            str(row["broken"]),
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


def _share(row: Mapping[str, Any], name: str) -> str:
    if row[name] is None:
        return NONE
    return f"{percent(row[name])} [{percent(row[f'{name}_low'])}, {percent(row[f'{name}_high'])}]"
