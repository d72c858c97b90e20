"""Success by step: the paper's Fig. 3, its companions with chance and the optimum, and one curve for each flip rate."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.axes import Axes

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.published import REFERENCE_STEPS, STEPS_TO_80
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
    step_axis,
    title,
)
from lockprobe.figures.palette import Style, styles
from lockprobe.figures.primitives import band, published, staircase
from lockprobe.formatting import minus

__all__ = [
    "draw_relative_success",
    "draw_success_curves",
    "draw_success_curves_by_p",
    "draw_success_curves_corrected",
    "relative_rows",
]

_NAMED = 11
"""Curves whose names fit at the right edge without overlap."""


def draw_success_curves(axes: Axes, result: StudySummary) -> None:
    """Cumulative success by number of interactions, one staircase per agent and modality at its lowest p (Fig. 3)."""
    shown = _at_the_lowest_p(result)
    if not shown:
        return blank(axes, "no trial has ended")
    alike = _staircases(axes, shown)
    budget = _budget(shown)
    _, _, first = shown[0]
    if all(condition.p == 0 for _, _, condition in shown):
        steps = sorted({REFERENCE_STEPS, *STEPS_TO_80.values()})
        published(axes, [(step, 0.8) for step in steps if step <= budget])
    step_axis(axes, budget, "success probability")
    return title(axes, f"flip rate {first.p:g}; {counts([first])} of each agent" if alike else "")


def draw_success_curves_corrected(axes: Axes, result: StudySummary) -> None:
    """Fig. 3 between chance and the optimum: one minus Kaplan-Meier with bands, exact blind agents, shortest plan.

    Every agent is shown at its lowest p; references have no band.
    """
    shown = _at_the_lowest_p(result)
    if not shown:
        return blank(axes, "no trial has ended")
    alike = _staircases(axes, shown)
    for _, style, condition in shown:
        if style.lead:
            band(axes, condition.curve.low, condition.curve.high, style)
    budget = _budget(shown)
    if result.reference is not None:
        _exact_curves(axes, result.reference, budget)
    step_axis(axes, budget, "solved by this step")
    _, _, first = shown[0]
    return title(
        axes,
        f"flip rate {first.p:g}; {counts([first])} of each agent" if alike else "",
        "1 \N{MINUS SIGN} Kaplan-Meier; shade: pointwise 95 % band",
    )


_Shown = Sequence[tuple[AgentSummary, Style, ConditionSummary]]
"""Agents with a curve, how each is drawn, and its condition."""


def _at_the_lowest_p(result: StudySummary) -> _Shown:
    return [
        (agent, style, condition)
        for agent, style in styles(result)
        if (condition := next((condition for condition in agent.conditions if condition.curve.n), None)) is not None
    ]


def _staircases(axes: Axes, shown: _Shown) -> bool:
    """One curve for each agent; whether all have the same p and number of trials, else each label names its own."""
    alike = len({(condition.p, condition.curve.n) for _, _, condition in shown}) == 1
    for i, (agent, style, condition) in enumerate(shown):
        told = "" if alike else f",\n$p$ = {condition.p:g}, n = {condition.curve.n}"
        staircase(axes, condition.curve.share, style, label=agent_label(agent) + told, first=1 + i % 4)
    return alike


def _budget(shown: _Shown) -> int:
    return max(len(condition.curve.share) - 1 for _, _, condition in shown)


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
