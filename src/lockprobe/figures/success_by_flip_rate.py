"""Success by flip rate: the paper's Fig. 4, and its companion with intervals, chance and the best flip rates."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.published import SOLVED_AT_0, SOLVED_AT_40
from lockprobe.analysis.reference import Reference
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.figures.frame import (
    EXACT,
    FAINT,
    INK,
    agent_label,
    blank,
    counts,
    heading,
    label_right,
    p_axis,
    share_axis,
    title,
)
from lockprobe.figures.palette import SUBJECTS, Style, shifts, styles
from lockprobe.figures.primitives import bars, dots, key, means, published, published_by_p, second_order_fit
from lockprobe.formatting import p_value, percent

__all__ = ["draw_success_by_p", "draw_success_by_p_corrected", "published_success"]


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
            said.append(second_order_fit(axes, agent.success_fit, style))
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


def published_success(conditions: Sequence[ConditionSummary]) -> list[tuple[float, float]]:
    """Flip rates for which the paper's text gives the share solved, with that share, as far as the study has them."""
    return published_by_p(conditions, SOLVED_AT_0, SOLVED_AT_40)


def draw_success_by_p_corrected(axes: Axes, agent: AgentSummary, reference: Reference | None = None) -> None:
    """Fig. 4 by counts: Wilson's intervals, a binomial model of the order that AICc prefers, chance, and the peak.

    Triangles under the shares stand at the values of p that may be the best (95 % set); the diamond is the highest
    share less what it owes to having been chosen.
    """
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    style = Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True)
    bars(
        axes,
        [c.p for c in counted],
        [c.success for c in counted],
        style,
        label="share solved with 95 % Wilson interval",
    )
    found, several = agent.inference.orders, len(agent.peak.candidates) > 1
    curve = found.curve if several else None
    if curve is not None:
        axes.plot(
            curve.p, curve.value, color=style.colour, linewidth=1.4, zorder=3, label="binomial model with 95 % band"
        )
        axes.fill_between(curve.p, curve.low, curve.high, color=style.colour, alpha=0.14, linewidth=0, zorder=1)
    share_axis(axes, "success rate")
    p_axis(axes, agent.conditions, axis=agent.axis)
    if several:
        _peak(axes, agent)
    if reference is not None:
        budget = len(counted[0].curve.share) - 1
        levels = (("random", reference.random[budget]), ("no-repeat", reference.no_repeat[budget]))
        for name, level in levels:
            axes.axhline(level, color=FAINT, linewidth=0.9, linestyle=EXACT[name], zorder=2)
        label_right(axes, [(level, f"{name}\n{percent(level)}", FAINT) for name, level in levels], gap=0.2)
    return title(
        axes,
        heading(agent),
        f"{counts(counted)} per {agent.axis.name}" + (f"; model of order {found.order} (AICc)" if curve else ""),
        _rises_and_falls(agent) if several else "",
    )


def _rises_and_falls(agent: AgentSummary) -> str:
    """Whether success rises and then falls, by the test that is concluded from."""
    found = next(
        (test.p_value for test in agent.inference.tests if test.question == "shape" and test.recommended), None
    )
    if found is None:
        return f"rise and fall: not tested, needs three {agent.axis.name}s"
    return f"rise and fall, two-lines test: {p_value(found, '$P$')}"


def _peak(axes: Axes, agent: AgentSummary) -> None:
    found = agent.peak
    members = [candidate.p for candidate in found.candidates if candidate.in_set]
    if members:
        axes.set_ylim(-0.13, 1.03)
        axes.plot(
            members,
            [-0.07] * len(members),
            linestyle="none",
            marker="^",
            markersize=4.5,
            color=INK,
            zorder=3,
            label=f"95 % set of the best {agent.axis.name}",
        )
    if found.best is not None and found.honest is not None:
        low, high = axes.get_xlim()
        axes.plot(
            [found.best + 0.025 * (high - low)],
            [found.honest],
            linestyle="none",
            marker="D",
            markersize=4.5,
            color=INK,
            markerfacecolor="white",
            markeredgewidth=0.9,
            zorder=5,
            label="highest share, corrected for selection",
        )
