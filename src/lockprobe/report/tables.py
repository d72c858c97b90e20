"""The tables of a report, as rows of text, CSV and TeX."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.summary import ConditionSummary, StudySummary

__all__ = ["as_csv", "as_tex", "condition_table", "interval", "misinterpretation_table", "percent"]

NONE = "\N{EN DASH}"
"""A cell without a value."""

Table = list[list[str]]
"""Rows of cells, the first row with the names of the columns."""

_TEX = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "±": r"$\pm$",
    "\N{EN DASH}": "--",
    "\N{MINUS SIGN}": "$-$",
    "≈": r"$\approx$",
}


def misinterpretation_table(summary: StudySummary) -> Table:
    """The paper's Table 1, one row per condition of the agents that the study is about.

    References repeat what they are told, and so never misinterpret.
    """
    head = [
        "agent",
        "modality",
        "p",
        "average rate per trial",
        "total",
        "in trials",
        "pooled rate",
        "claims",
        "claims against truth",
    ]
    return _without_modality(
        [head]
        + [
            [
                condition.agent,
                condition.modality,
                f"{condition.p:g}",
                percent(said.mean_rate) + ("" if said.sd_rate is None else f" ± {percent(said.sd_rate)}"),
                str(said.total),
                f"{said.affected} of {said.trials}",
                percent(said.pooled.value),
                str(said.pooled.n),
                str(said.against_truth.count),
            ]
            for agent in summary.subjects
            for condition in agent.conditions
            if (said := condition.claims).trials
        ]
    )


def condition_table(summary: StudySummary) -> Table:
    """One row per condition. Intervals are 95 % Wilson; chance is for trials of exactly those lengths."""
    head = [
        "agent",
        "modality",
        "p",
        "trials",
        "solved",
        "success",
        "loop rate",
        "by chance",
        "coverage",
        "redundant",
        "median step (solved)",
        "80 % by",
        "errors",
    ]
    return _without_modality([head] + [_row(condition) for condition in summary.conditions])


def _without_modality(table: Table) -> Table:
    """The table without its second column, if that says the same in every row."""
    return table if len({row[1] for row in table[1:]}) > 1 else [[row[0], *row[2:]] for row in table]


def _row(condition: ConditionSummary) -> list[str]:
    found, curve = condition.behaviour, condition.curve
    reached = curve.steps_to(0.8)
    return [
        condition.agent,
        condition.modality,
        f"{condition.p:g}",
        str(condition.success.n),
        str(condition.success.count),
        interval(condition.success),
        interval(found.loops),
        f"{percent(found.chance_uniform, 0)} to {percent(found.chance_no_repeat, 0)}",
        percent(found.coverage, 0),
        percent(found.redundant_share, 0),
        NONE if curve.median_steps is None else f"{curve.median_steps:g}",
        NONE if reached is None else str(reached),
        str(sum(condition.errors.values())),
    ]


def percent(value: float | None, digits: int = 1) -> str:
    """A share in per cent, or a dash where there is none."""
    return NONE if value is None or math.isnan(value) else f"{100 * value:.{digits}f} %"


def interval(share: Proportion) -> str:
    """A share with its interval."""
    return NONE if share.n == 0 else f"{percent(share.value, 0)} [{100 * share.low:.0f}, {100 * share.high:.0f}]"


def as_csv(table: Sequence[Sequence[str]]) -> str:
    """The table as CSV. A cell that a spreadsheet would take for a formula is led by an apostrophe."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerows([f"'{cell}" if cell[:1] in ("=", "+", "-", "@") else cell for cell in row] for row in table)
    return out.getvalue()


def as_tex(table: Sequence[Sequence[str]]) -> str:
    """The table for LaTeX with booktabs."""
    head, *rows = [" & ".join("".join(_TEX.get(c, c) for c in cell) for cell in row) + r" \\" for row in table]
    lines = [
        rf"\begin{{tabular}}{{{'l' * len(table[0])}}}",
        r"\toprule",
        head,
        r"\midrule",
        *rows,
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"
