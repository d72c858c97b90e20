"""The paper's figures, drawn. Every number comes from a summary; nothing is computed here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.axes import Axes

from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.summary import AgentSummary, ConditionSummary, StudySummary
from lockprobe.figures.frame import (
    BEYOND,
    FAINT,
    LABEL_GAP,
    SUBJECTS,
    Style,
    agent_label,
    counts,
    label_right,
    p_axis,
    share_axis,
    shifts,
    step_axis,
    styles,
    title,
)

__all__ = [
    "draw_loops_against_success",
    "draw_loops_by_p",
    "draw_success_by_p",
    "draw_success_curves",
    "draw_success_curves_by_p",
]


def draw_success_by_p(axes: Axes, result: StudySummary) -> None:
    """Success by flip probability (paper, Fig. 4).

    Dots are repetitions, markers the pooled share with its 95 % Wilson interval, the line the second-order fit of
    agents that the study is about, the shade its bootstrap band. References are grey and have no fit.
    """
    moved = shifts(result)
    labels: list[tuple[float, str, str]] = []
    for agent, style in styles(result):
        end = _success_of(axes, agent, style, moved[agent.agent, agent.modality])
        if end is not None:
            labels.append((end, agent_label(agent), style.ink))
    share_axis(axes, "success rate")
    p_axis(axes, result.conditions, max(map(abs, moved.values()), default=0.0))
    title(axes, f"{counts(result.conditions)} per agent and p; bars are 95 % Wilson intervals, dots repetitions")
    label_right(axes, labels)


def _success_of(axes: Axes, agent: AgentSummary, style: Style, shift: float) -> float | None:
    """One agent of Fig. 4; the height at which its line ends."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return None
    x = [condition.p + shift for condition in counted]
    shares = [condition.success for condition in counted]
    fit = agent.success_fit.quadratic if style.lead else None
    if style.lead:
        _repetitions(axes, agent, style.colour, shift)
    if fit is not None:
        axes.plot(fit.p, fit.value, color=style.colour, linewidth=1.8, zorder=2)
        if fit.low:
            axes.fill_between(fit.p, fit.low, fit.high, color=style.colour, alpha=0.13, linewidth=0, zorder=1)
    else:
        axes.plot(x, [share.value for share in shares], color=style.colour, linewidth=1.0, linestyle=style.dash)
    _bars(axes, x, shares, style)
    return fit.value[-1] if fit is not None else shares[-1].value


def draw_success_curves(axes: Axes, result: StudySummary) -> None:
    """Cumulative success by step, one line per agent at its lowest p (paper, Fig. 3).

    The shade is the pointwise 95 % Wilson band; references are drawn without one.
    """
    labels: list[tuple[float, str, str]] = []
    for agent, style in styles(result):
        condition = next((condition for condition in agent.conditions if condition.curve.n), None)
        if condition is None:
            continue
        _curve(axes, condition, style, band=0.15 if style.lead else 0.0)
        name = f"{agent_label(agent)}\n(p = {condition.p:g}, n = {condition.curve.n})"
        labels.append((condition.curve.share[-1], name, style.ink))
    step_axis(axes, result.conditions)
    label_right(axes, labels, gap=1.9 * LABEL_GAP)


def draw_success_curves_by_p(axes: Axes, agent: AgentSummary) -> None:
    """Cumulative success by step of one agent, one line per p; bands for the two p of its contrast."""
    counted = [condition for condition in agent.conditions if condition.curve.n]
    said = f"{counts(counted)} per p"
    if agent.blind:
        counted, said = counted[:1], f"{counts(counted)}, the same at every p"
    banded = (agent.contrast.baseline, agent.contrast.other) if agent.contrast else tuple(counted[:1])
    colours = mpl.colormaps["viridis"]
    labels: list[tuple[float, str, str]] = []
    for i, condition in enumerate(counted):
        colour = mpl.colors.to_hex(colours(0.84 * i / max(1, len(counted) - 1)))
        style = Style(colour=colour, ink=colour, marker="o", dash="-", lead=True)
        _curve(axes, condition, style, band=0.13 if condition in banded else 0.0)
        labels.append((condition.curve.share[-1], "every p" if agent.blind else f"p = {condition.p:g}", colour))
    step_axis(axes, agent.conditions)
    title(axes, f"{agent_label(agent)}\n{said}")
    label_right(axes, labels)


def _curve(axes: Axes, condition: ConditionSummary, style: Style, *, band: float) -> None:
    """A staircase; the last stair is drawn a little beyond the budget, so that it can be seen."""
    curve = condition.curve
    steps = (*curve.steps, len(curve.share) - 1 + BEYOND)
    share, low, high = ((*values, values[-1]) for values in (curve.share, curve.low, curve.high))
    axes.step(
        steps,
        share,
        where="post",
        color=style.colour,
        linewidth=1.9 if style.lead else 1.1,
        linestyle=style.dash,
        zorder=3 if style.lead else 2,
    )
    if band:
        axes.fill_between(steps, low, high, step="post", color=style.colour, alpha=band, linewidth=0)


def draw_loops_against_success(axes: Axes, agent: AgentSummary) -> None:
    """Loop rate against success over repetitions (paper, Fig. 5a). Larger dots are several equal points."""
    points = [point for point in (agent.conditions[0].points if agent.blind else agent.points) if point.n]
    places = Counter((point.loop_rate, point.success) for point in points)
    axes.scatter(
        [loops for loops, _ in places],
        [share for _, share in places],
        s=[34 * count for count in places.values()],
        color=SUBJECTS[0],
        alpha=0.55,
        linewidth=0,
        zorder=3,
        clip_on=False,
    )
    found = agent.correlation
    if agent.blind:
        said = f"the same at every p; {found.n} repetitions"
    elif found.r is None:
        said = f"r undefined; {found.n} points"
    else:
        said = f"r = {found.r:.2f} [{found.low:.2f}, {found.high:.2f}], n = {found.n} points".replace(
            "-", "\N{MINUS SIGN}"
        )
    title(axes, f"{agent_label(agent)}\n{said}")
    axes.set_xlabel("share of trials with an action loop")
    axes.set_xlim(-0.04, 1.04)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    share_axis(axes, "success rate")


def draw_loops_by_p(axes: Axes, agent: AgentSummary) -> None:
    """Loop rate by flip probability with 95 % Wilson intervals (paper, Fig. 5b), and its chance level.

    The chance lines are what random actions would show in trials of exactly these lengths.
    """
    counted = [condition for condition in agent.conditions if condition.success.n]
    x = [condition.p for condition in counted]
    uniform = [condition.behaviour.chance_uniform or 0.0 for condition in counted]
    no_repeat = [condition.behaviour.chance_no_repeat or 0.0 for condition in counted]
    if len(x) > 1:
        axes.fill_between(x, uniform, no_repeat, color="#999999", alpha=0.18, linewidth=0, zorder=1)
    for chance, dash, marker, name in ((uniform, ":", "x", "uniform"), (no_repeat, "--", "+", "no immediate repeat")):
        axes.plot(
            x,
            chance,
            marker=marker if len(x) == 1 else "",
            linestyle=dash,
            color=FAINT,
            linewidth=1.1,
            label=f"chance, {name}",
        )
    style = Style(colour=SUBJECTS[1], ink=SUBJECTS[1], marker="o", dash="-", lead=True)
    loops = [condition.behaviour.loops for condition in counted]
    _repetitions(axes, agent, style.colour, 0.0, loops=True)
    axes.plot(x, [share.value for share in loops], color=style.colour, linewidth=1.4, zorder=3)
    _bars(axes, x, loops, style, label="observed")
    title(axes, f"{agent_label(agent)}\n{counts(counted)} per p")
    share_axis(axes, "share of trials with an action loop")
    p_axis(axes, agent.conditions)


def _repetitions(axes: Axes, agent: AgentSummary, colour: str, shift: float, *, loops: bool = False) -> None:
    """A faint dot for every repetition, beside the pooled marker."""
    points = [point for point in agent.points if point.n]
    if len({point.repetition for point in points}) < 2:
        return
    places = Counter((point.p, point.loop_rate if loops else point.success) for point in points)
    axes.scatter(
        [p + shift for p, _ in places],
        [value for _, value in places],
        s=[16 * count for count in places.values()],
        color=colour,
        alpha=0.3,
        linewidth=0,
        zorder=2,
    )


def _bars(
    axes: Axes, x: Sequence[float], shares: Sequence[Proportion], style: Style, *, label: str | None = None
) -> None:
    """Pooled shares with their intervals; references smaller."""
    below = [share.value - share.low for share in shares]
    above = [share.high - share.value for share in shares]
    axes.errorbar(
        x,
        [share.value for share in shares],
        yerr=[below, above],
        fmt=style.marker,
        color=style.colour,
        markersize=6.0 if style.lead else 4.0,
        markeredgecolor="white",
        markeredgewidth=0.8 if style.lead else 0.0,
        elinewidth=1.4 if style.lead else 0.8,
        capsize=0,
        zorder=4,
        label=label,
    )
