"""Every two agents on the same boxes: differences in success, and in the effect of false reports."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.agent_comparison.pair import AgentComparison
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.summary import StudySummary
from lockprobe.figures.forest import ForestRow, differences, interval
from lockprobe.figures.frame import agent_label, title
from lockprobe.figures.palette import SUBJECTS

__all__ = ["SHOWN", "change_rows", "difference_rows", "draw_changes", "draw_differences", "shown"]

SHOWN = 15
"""Pairs that one picture has room for."""


def shown(result: StudySummary) -> Sequence[AgentComparison]:
    """The pairs that are drawn: of agents that the study is about; with baselines if there is only one such agent."""
    between = [one for one in result.comparisons if one.among == "subjects"]
    return (between or result.comparisons)[:SHOWN]


def difference_rows(result: StudySummary) -> list[ForestRow]:
    """Differences in success over all p, a row for each pair."""
    return [_row(result, one, one.success, shown=one.verdict != 0) for one in shown(result)]


def change_rows(result: StudySummary) -> list[ForestRow]:
    """Differences in the effect of p on success, at the p with the clearest difference."""
    return [
        _row(
            result,
            one,
            moved.clearest.change,
            shown=moved.p_adjusted is not None and moved.p_adjusted < ALPHA,
            where=f"to {moved.clearest.p:g}: ",
        )
        for one in shown(result)
        if (moved := one.interaction)
    ]


def draw_differences(axes: Axes, result: StudySummary) -> None:
    """Differences in success over all p."""
    differences(axes, difference_rows(result))
    left = len([one for one in result.comparisons if one.among == shown(result)[0].among]) - len(shown(result))
    title(axes, "success over all flip rates", f"the first {SHOWN} pairs, {left} more in the tables" if left else "")


def draw_changes(axes: Axes, result: StudySummary) -> None:
    """Differences between agents in the effect of p on success."""
    differences(axes, change_rows(result))
    title(axes, "change from the lowest flip rate, at the clearest difference")


def _row(result: StudySummary, one: AgentComparison, mean: BlockMean, *, shown: bool, where: str = "") -> ForestRow:
    names = {(agent.agent, agent.modality): agent_label(agent) for agent in result.agents}
    return ForestRow(
        name=f"{names[one.second]}\n\N{MINUS SIGN} {names[one.first]}",
        said=where + interval(mean.value, mean.low, mean.high),
        value=mean.value,
        low=mean.low,
        high=mean.high,
        colour=SUBJECTS[0],
        face=SUBJECTS[0] if shown else "white",
    )
