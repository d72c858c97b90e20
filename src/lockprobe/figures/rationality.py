"""Rationality of actions for an observer that believes reports and one that doubts them, with random choices."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from lockprobe.analysis.rationality import Rationality
from lockprobe.analysis.summary import AgentSummary
from lockprobe.figures.frame import heading, p_axis, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Dash, Style

__all__ = ["draw_optimal_actions", "draw_steps_lost"]

_LOOKS: dict[str, tuple[Style, str, Dash]] = {
    "naive": (Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True), "reports believed", ":"),
    "aware": (Style(colour=ACCENT, marker="s", dash="-", lead=True), "reports doubted", "--"),
}
"""How each observer is drawn, its name in the legend, and the line of chance."""

_APART = {"naive": -0.006, "aware": 0.006}
"""Sideways shifts that keep the marks of the observers apart, in widths of the axis."""

Bar = tuple[float, float | None, float | None]
"""A value and the ends of its interval, where it has one."""


def draw_optimal_actions(axes: Axes, agent: AgentSummary) -> None:
    """Share of actions that no other beats, by flip probability."""
    share_axis(axes, "share of optimal actions")
    p_axis(axes, agent.conditions)
    for x, found in _by_observer(agent):
        values = [(r.optimal.value, r.optimal.low, r.optimal.high) for r in found]
        _observer(axes, x, values, [r.by_chance["optimal"] for r in found], found[0].noise)
    sizes = sorted({found.steps for condition in agent.conditions for found in condition.rationality})
    several = f"{sizes[0]} to {sizes[-1]}" if len(sizes) > 1 else f"{sizes[0]}"
    title(
        axes, heading(agent), f"n = {several} actions per flip rate; bars: 95 % intervals", "dotted, dashed: by chance"
    )


def draw_steps_lost(axes: Axes, agent: AgentSummary) -> None:
    """Mean regret of an action in expected steps, by flip probability."""
    share_axis(axes, "steps lost per action")
    p_axis(axes, agent.conditions)
    axes.set_ylim(auto=True)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    for x, found in _by_observer(agent):
        values = [(r.regret.value, r.regret.low, r.regret.high) for r in found]
        _observer(axes, x, values, [r.by_chance["regret"] for r in found], found[0].noise)
    axes.set_ylim(bottom=-0.03 * axes.get_ylim()[1])


def _by_observer(agent: AgentSummary) -> list[tuple[list[float], list[Rationality]]]:
    """For every observer the p at which it judged, and its judgement."""
    judged = [(condition.p, condition.rationality) for condition in agent.conditions if condition.rationality]
    return [([p for p, _ in judged], [found[i] for _, found in judged]) for i in range(len(judged[0][1]))]


def _observer(axes: Axes, x: Sequence[float], values: Sequence[Bar], chance: Sequence[float], noise: str) -> None:
    """One observer's values with their intervals, and the line of chance."""
    style, name, dash = _LOOKS[noise]
    low, high = axes.get_xlim()
    axes.errorbar(
        [p + _APART[noise] * (high - low) for p in x],
        [value for value, _, _ in values],
        yerr=[
            [0.0 if least is None else max(0.0, value - least) for value, least, _ in values],
            [0.0 if most is None else max(0.0, most - value) for value, _, most in values],
        ],
        fmt="",
        marker=style.marker,
        color=style.colour,
        linestyle="-",
        linewidth=0.8,
        markersize=4.6,
        markeredgecolor="white",
        markeredgewidth=0.7,
        elinewidth=1.1,
        zorder=4,
        label=name,
    )
    reach = 0.04 * (high - low)
    ends = x if len(x) > 1 else [x[0] - reach, x[0] + reach]
    axes.plot(ends, list(chance) * (len(ends) // len(x)), color=style.colour, linestyle=dash, linewidth=0.9, zorder=2)
