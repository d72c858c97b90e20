"""The measures that installed packages add, for every agent under every condition."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from lockprobe.analysis.measures import find_measure, measured
from lockprobe.errors import UserMistake
from lockprobe.formatting import NONE, minus
from lockprobe.plugins import plugin_names
from lockprobe.record import Trial
from lockprobe.report.format import TextTable
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.schema import MeasureResult

__all__ = ["measure_rows", "measure_table"]


def measure_rows(opened: OpenedStudy) -> list[MeasureResult]:
    """The mean of each of those measures with its 95 % interval; of one that breaks, why.

    Args:
        opened: A study; no code of a package runs if it holds what they measured.
    """
    if opened.measures is not None:
        return list(opened.measures)
    cells: dict[str, list[Trial]] = {}
    for trial in opened.trials if plugin_names("measure") else ():
        cells.setdefault(trial.cell, []).append(trial)
    return [row for members in cells.values() for name in plugin_names("measure") for row in _rows(members, name)]


def _rows(trials: Sequence[Trial], name: str) -> list[MeasureResult]:
    first = trials[0]
    row = partial(MeasureResult, agent=first.group, condition=first.condition, measure=name)
    try:
        (found,) = measured(trials, [find_measure(name)])
    except UserMistake as error:
        return [row(what=str(error), kind="broken", trials=0, value=None, low=None, high=None)]
    return [row(what=found.what, kind=found.kind, trials=found.n, value=found.value, low=found.low, high=found.high)]


def measure_table(rows: Sequence[MeasureResult]) -> TextTable:
    """The same as rows of text."""
    head = ["agent", "condition", "measure", "what it is", "trials", "mean [95 % interval]"]
    return [head] + [[row.agent, row.condition, row.measure, row.what, str(row.trials), _said(row)] for row in rows]


def _said(row: MeasureResult) -> str:
    if row.value is None:
        return NONE
    if row.low is None or row.high is None:
        return minus(f"{row.value:.3g}")
    return minus(f"{row.value:.3g} [{row.low:.3g}, {row.high:.3g}]")
