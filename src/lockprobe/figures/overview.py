"""The figure of a report's first screen: success of every agent by flip rate or step, named where its line ends."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.figures.frame import FAINT, SMALL, agent_label, blank, label_right, p_axis, share_axis, step_axis
from lockprobe.figures.palette import Style, shifts, styles
from lockprobe.figures.primitives import bars, means, published, staircase
from lockprobe.figures.success_by_flip_rate import published_success

__all__ = ["draw_overview"]

_MOST = 7
"""Agents that are drawn: those that the study is about first."""

_NAME = 24
"""Characters of a name at the right edge."""


def draw_overview(axes: Axes, result: StudySummary) -> None:
    """Success by flip rate, or by step where there is only one, with chance and the paper's points."""
    shown = [(a, style) for a, style in styles(result) if any(one.success.n for one in a.conditions)][:_MOST]
    if not shown:
        return blank(axes, "no trial has ended")
    if len({one.p for one in result.conditions}) == 1:
        return _by_step(axes, result, shown)
    return _by_p(axes, result, shown)


def _by_p(axes: Axes, result: StudySummary, shown: Sequence[tuple[AgentSummary, Style]]) -> None:
    """Shares with Wilson's intervals, beside the range of random agents."""
    moved, labels = shifts(result), []
    for agent, style in shown:
        counted = [one for one in agent.conditions if one.success.n]
        x = [one.p + moved[agent.agent, agent.modality] for one in counted]
        shares = [one.success for one in counted]
        if style.lead:
            bars(axes, x, shares, style)
        means(axes, x, shares, style, line=True)
        labels.append((shares[-1].value or 0.0, agent_label(agent, _NAME), style.colour))
    share_axis(axes, "trials solved")
    p_axis(axes, result.conditions, max(map(abs, moved.values()), default=0.0), axis=result.axis)
    if result.reference:
        budget = max(len(one.curve.share) for one in result.conditions) - 1
        low, high = (curve[budget] for curve in (result.reference.random, result.reference.no_repeat))
        axes.axhspan(low, high, color=FAINT, alpha=0.13, linewidth=0, zorder=0)
        labels.append(((low + high) / 2, "chance", FAINT))
    if stars := published_success(result.conditions):
        published(axes, stars)
        middle = sum(axes.get_xlim()) / 2
        for place in stars:
            side = 1 if place[0] < middle else -1
            axes.annotate(
                "Zenkri\n& Brock", place, (6 * side, 0), textcoords="offset points", va="center",
                ha="left" if side > 0 else "right", fontsize=SMALL, color=FAINT, zorder=6,
                bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.4},
            )  # fmt: skip
    label_right(axes, labels)


def _by_step(axes: Axes, result: StudySummary, shown: Sequence[tuple[AgentSummary, Style]]) -> None:
    """Shares solved by each step, beside the range of random agents."""
    labels, curves = [], []
    for i, (agent, style) in enumerate(shown):
        curve = next(one.curve.share for one in agent.conditions if one.success.n)
        staircase(axes, curve, style, label="", first=1 + i % 4)
        curves.append(len(curve))
        labels.append((curve[-1], agent_label(agent, _NAME), style.colour))
    budget = max(curves) - 1
    if result.reference:
        low, high = (one[: budget + 1] for one in (result.reference.random, result.reference.no_repeat))
        axes.fill_between(range(budget + 1), low, high, step="post", color=FAINT, alpha=0.13, linewidth=0, zorder=0)
        labels.append(((low[-1] + high[-1]) / 2, "chance", FAINT))
    step_axis(axes, budget, "solved by this step")
    label_right(axes, labels)
