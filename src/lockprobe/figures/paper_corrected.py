"""Companions of the paper's Figs. 3 and 4 that support conclusions about success."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes

from lockprobe.analysis.reference import Reference
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.figures.forest import ForestRow, forest
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
    step_axis,
    title,
)
from lockprobe.figures.palette import SUBJECTS, Style, styles
from lockprobe.figures.primitives import band, bars, staircase
from lockprobe.formatting import minus, p_value, percent

__all__ = [
    "draw_relative_success",
    "draw_success_by_p_corrected",
    "draw_success_curves_by_p",
    "draw_success_curves_corrected",
    "relative_rows",
]

_NAMED = 11
"""Curves whose names fit beside each other at the right edge."""


def draw_success_curves_corrected(axes: Axes, result: StudySummary) -> None:
    """Fig. 3 between chance and the optimum: one minus Kaplan-Meier with bands, exact blind agents, shortest plan.

    Every agent is shown at its lowest p; references have no band.
    """
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
        if style.lead:
            band(axes, condition.curve.low, condition.curve.high, style)
    budget = max(len(condition.curve.share) - 1 for _, _, condition in shown)
    if result.reference is not None:
        _exact_curves(axes, result.reference, budget)
    step_axis(axes, budget, "solved by this step")
    _, _, first = shown[0]
    return title(
        axes,
        f"flip rate {first.p:g}; {counts([first])} of each agent" if alike else "",
        "1 \N{MINUS SIGN} Kaplan-Meier; shade: pointwise 95 % band",
    )


def _exact_curves(axes: Axes, reference: Reference, budget: int) -> None:
    for name, share in (("random", reference.random), ("no-repeat", reference.no_repeat)):
        style = Style(colour=FAINT, marker="", dash=EXACT[name], lead=False)
        staircase(axes, share[: budget + 1], style, label=f"{name} (exact)")
    if reference.optimum is not None:
        axes.axvline(
            reference.optimum,
            color=INK,
            linewidth=0.7,
            linestyle=(0, (8, 3)),
            zorder=1,
            label=f"shortest plan: {reference.optimum} steps",
        )


def relative_rows(result: StudySummary) -> list[ForestRow]:
    """Every agent's area at its lowest p."""
    rows = []
    for agent, style in styles(result):
        condition = next((condition for condition in agent.conditions if condition.curve.n), None)
        found = condition.relative if condition else None
        said = minus(f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]", zeros=True) if found else "not defined"
        rows.append(
            ForestRow(
                name=agent_label(agent),
                said=said,
                value=found.value if found else None,
                low=found.low if found else None,
                high=found.high if found else None,
                colour=style.colour,
                marker=style.marker,
                face=style.face,
            )
        )
    return rows


def draw_relative_success(axes: Axes, result: StudySummary) -> None:
    """How far every agent's curve at its lowest p lies from chance (0) to the shortest plan (1), by area."""
    rows = relative_rows(result)
    ends = [end for row in rows if row.low is not None and row.high is not None for end in (row.low, row.high)]
    if not ends:
        return blank(axes, "no area between chance and the shortest plan")
    levels = ((0.0, FAINT, EXACT["random"]), (1.0, INK, (0, (8, 3))))
    forest(axes, rows, (min([*ends, 0.0]) - 0.05, max([*ends, 1.0]) + 0.05), left=-0.2, levels=levels)
    axes.set_xticks([0, 0.5, 1], ["0\nrandom", "0.5", "1\nshortest plan"])
    return title(axes, "area under the curve; bars: 95 % intervals")


def draw_success_curves_by_p(axes: Axes, agent: AgentSummary) -> None:
    """Cumulative success by step of one agent, one line per p; bands for the two p of its contrast.

    Of more than eleven p only those two, the lowest and the highest are named; colours run from the lowest up.
    """
    counted = [condition for condition in agent.conditions if condition.curve.n]
    if not counted:
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    if agent.blind:
        counted = counted[:1]
    banded = (agent.contrast.baseline, agent.contrast.other) if agent.contrast else tuple(counted[:1])
    named = counted if len(counted) <= _NAMED else [counted[0], counted[-1], *banded]
    colours = mpl.colormaps["viridis"]
    labels: list[tuple[float, str, str]] = []
    for i, condition in enumerate(counted):
        colour = mpl.colors.to_hex(colours(0.84 * i / max(1, len(counted) - 1)))
        style = Style(colour=colour, marker="", dash="-", lead=True)
        staircase(axes, condition.curve.share, style)
        if condition in banded:
            band(axes, condition.curve.low, condition.curve.high, style)
        if condition in named:
            labels.append((condition.curve.share[-1], "all $p$" if agent.blind else f"$p$ = {condition.p:g}", colour))
    step_axis(axes, len(counted[0].curve.share) - 1, "solved by this step")
    title(axes, heading(agent), f"{counts(counted)} per {agent.axis.name}; shade: pointwise 95 % band")
    return label_right(axes, labels)


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
    found = agent.inference.lines.p_value
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
