"""The paper's Figs. 3, 4, 5a and 5b, as the paper draws them. ``paper_corrected`` holds their companions.

Hollow stars are figures that the paper's text gives. They are drawn where the study has their place on its axes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.inference.trend import TrendFit
from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.published import (
    LOOPS_AT_0,
    LOOPS_AT_40,
    PEAK,
    REFERENCE_STEPS,
    SOLVED_AT_0,
    SOLVED_AT_40,
    STEPS_TO_80,
)
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.figures.frame import (
    INK,
    SMALL,
    agent_label,
    blank,
    counts,
    heading,
    p_axis,
    share_axis,
    step_axis,
    title,
)
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style, shifts, styles
from lockprobe.figures.primitives import dots, key, means, published, staircase
from lockprobe.formatting import minus

__all__ = [
    "draw_loops_against_success",
    "draw_loops_by_p",
    "draw_success_by_p",
    "draw_success_curves",
    "published_success",
]


def draw_success_curves(axes: Axes, result: StudySummary) -> None:
    """Cumulative success by number of interactions, one staircase per agent and modality at its lowest p (Fig. 3)."""
    shown = [
        (agent, style, condition)
        for agent, style in styles(result)
        if (condition := next((condition for condition in agent.conditions if condition.curve.n), None)) is not None
    ]
    if not shown:
        return blank(axes, "no trial has ended")
    alike = len({(condition.p, condition.curve.n) for _, _, condition in shown}) == 1
    for i, (agent, style, condition) in enumerate(shown):
        told = "" if alike else f",\n$p$ = {condition.p:g}, n = {condition.curve.n}"
        staircase(axes, condition.curve.share, style, label=agent_label(agent) + told, first=1 + i % 4)
    budget = max(len(condition.curve.share) - 1 for _, _, condition in shown)
    _, _, first = shown[0]
    if alike and first.p == 0:
        steps = sorted({REFERENCE_STEPS, *STEPS_TO_80.values()})
        published(axes, [(step, 0.8) for step in steps if step <= budget])
    step_axis(axes, budget, "success probability")
    return title(axes, f"flip rate {first.p:g}; {counts([first])} of each agent" if alike else "")


def draw_success_by_p(axes: Axes, result: StudySummary) -> None:
    """Success over flip probability with the second-order fit (Fig. 4).

    Dots are repetitions, markers the means. References, which the paper has not, are grey, without dots and fit.
    """
    if not any(condition.success.n for condition in result.conditions):
        return blank(axes, "no trial has ended")
    moved = shifts(result)
    said = [""]
    for agent, style in styles(result):
        counted = [condition for condition in agent.conditions if condition.success.n]
        shift = moved[agent.agent, agent.modality]
        if style.lead:
            dots(axes, agent, style, shift)
            said.append(_fit(axes, agent.success_fit, style))
        x = [condition.p + shift for condition in counted]
        means(axes, x, [condition.success for condition in counted], style, line=not (style.lead and said[-1]))
        if counted:
            key(axes, style, heading(agent).replace(", ", ",\n") if style.lead else agent_label(agent))
    published(axes, published_success(result.conditions))
    share_axis(axes, "success rate")
    p_axis(axes, result.conditions, max(map(abs, moved.values()), default=0.0))
    return title(
        axes, f"{counts(result.conditions)} per flip rate; dots: repetitions; markers: means", max(said, key=len)
    )


def draw_loops_against_success(axes: Axes, agent: AgentSummary) -> None:
    """Loop rate against success over repetitions, with the regression line and r (Fig. 5a)."""
    points = [point for point in (agent.conditions[0].points if agent.blind else agent.points) if point.n]
    if not points:
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    places = Counter((point.loop_rate, point.success) for point in points)
    axes.scatter(
        [loops for loops, _ in places],
        [share for _, share in places],
        s=[16 * count for count in places.values()],
        color=SUBJECTS[0],
        alpha=0.6,
        linewidth=0,
        zorder=3,
        clip_on=False,
    )
    found = agent.correlation
    if found.slope is not None and found.intercept is not None:
        ends = [min(point.loop_rate for point in points), max(point.loop_rate for point in points)]
        axes.plot(ends, [found.intercept + found.slope * x for x in ends], color=INK, linewidth=1.2, zorder=2)
    interval = "" if found.low is None else f" [{found.low:.2f}, {found.high:.2f}]"
    said = "r is not defined" if found.r is None else minus(f"r = {found.r:.2f}{interval}", zeros=True)
    title(axes, heading(agent), f"{said}; n = {found.n} repetitions")
    axes.set_xlim(-0.04, 1.04)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.set_xlabel("share of trials with an action loop", fontsize=SMALL + 1, color=INK)
    return share_axis(axes, "success rate")


def draw_loops_by_p(axes: Axes, agent: AgentSummary) -> None:
    """Loop rate over flip probability with the second-order fit (Fig. 5b)."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    style = Style(colour=ACCENT, marker="o", dash="-", lead=True)
    fitted = _fit(axes, agent.loop_fit, style)
    dots(axes, agent, style, loops=True)
    means(axes, [c.p for c in counted], [c.behaviour.loops for c in counted], style, line=not fitted)
    published(axes, _over_p(agent.conditions, LOOPS_AT_0, LOOPS_AT_40), "the paper, reconstructed")
    share_axis(axes, "action loop probability")
    p_axis(axes, agent.conditions)
    return title(axes, heading(agent), f"{counts(counted)} per flip rate; dots: repetitions; markers: means", fitted)


def published_success(conditions: Sequence[ConditionSummary]) -> list[tuple[float, float]]:
    """Flip rates for which the paper's text gives the share solved, with that share, as far as the study has them."""
    return _over_p(conditions, SOLVED_AT_0, SOLVED_AT_40)


def _over_p(conditions: Sequence[ConditionSummary], first: Proportion, peak: Proportion) -> list[tuple[float, float]]:
    """The paper's shares at p = 0 and at its peak, as far as the study has that p; none with a single p."""
    played = {condition.p for condition in conditions}
    places = [(0.0, first.value), (PEAK, peak.value)]
    return [place for place in places if len(played) > 1 and min(played) <= place[0] <= max(played)]


def _fit(axes: Axes, fit: TrendFit, style: Style) -> str:
    """The second-order fit with its band, where there is one; what was drawn, in words."""
    curve = fit.quadratic
    if curve is None:
        return ""
    axes.plot(curve.p, curve.value, color=style.colour, linestyle=style.dash, linewidth=1.6, zorder=3)
    if not curve.low:
        return "curve: second-order fit"
    axes.fill_between(curve.p, curve.low, curve.high, color=style.colour, alpha=0.14, linewidth=0, zorder=1)
    return "curve: second-order fit with 95 % bootstrap band"
