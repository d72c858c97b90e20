"""Loops: the paper's Figs. 5a and 5b, and companions with chance levels, onset, and success after a loop."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from lockprobe.analysis.inference.hazard import LoopEffect
from lockprobe.analysis.inference.logrank import EventGroup
from lockprobe.analysis.published import LOOPS_AT_0, LOOPS_AT_40
from lockprobe.analysis.summary import AgentSummary
from lockprobe.figures.forest import ForestRow, forest
from lockprobe.figures.frame import (
    EXACT,
    FAINT,
    INK,
    SMALL,
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
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.figures.primitives import band, bars, dots, means, published, published_by_p, second_order_fit, staircase
from lockprobe.formatting import minus, p_value

__all__ = [
    "draw_loop_harm",
    "draw_loop_onset",
    "draw_loops_against_success",
    "draw_loops_by_p",
    "draw_loops_with_chance",
    "odds_reach",
]

_WIDEST = 1000.0
"""Odds ratios beyond this, or below one over it, are arrows at the edge."""


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
    fitted = second_order_fit(axes, agent.loop_fit, style)
    dots(axes, agent, style, loops=True)
    means(axes, [c.p for c in counted], [c.behaviour.loops for c in counted], style, line=not fitted)
    published(axes, published_by_p(agent.conditions, LOOPS_AT_0, LOOPS_AT_40), "the paper, reconstructed")
    share_axis(axes, "action loop probability")
    p_axis(axes, agent.conditions)
    return title(axes, heading(agent), f"{counts(counted)} per flip rate; dots: repetitions; markers: means", fitted)


def odds_reach(agents: Sequence[AgentSummary]) -> float:
    """How far an axis around an odds ratio of 1 has to go for all of these agents, as a factor."""
    known = [3.0]
    for agent in agents:
        known += [value for row in _odds_rows(agent) for value in (row.value, row.low, row.high) if value]
        effects = (agent.inference.hazard, agent.inference.landmark)
        known += [effect.blind.odds_ratio for effect in effects if effect.blind]
    return min(_WIDEST, 1.3 * max([*known, *(1 / value for value in known)]))


def _odds_rows(agent: AgentSummary) -> list[ForestRow]:
    found = agent.inference
    return [
        _effect("step by step", found.hazard),
        _effect("after step 10", found.landmark),
        ForestRow(
            name="naive: whole trials",
            said=_said(found.whole.odds_ratio, None, None, found.whole.p_value),
            value=found.whole.odds_ratio,
            low=None,
            high=None,
            colour=FAINT,
            face="white",
        ),
    ]


def draw_loop_harm(axes: Axes, agent: AgentSummary, reach: float | None = None) -> None:
    """In place of Fig. 5a: odds of solving after a loop over odds before. The naive ratio, hollow, is no evidence.

    Where the box is known a tick is the odds ratio of a blind agent with the same action habits.

    Args:
        axes: Where.
        agent: Whose odds.
        reach: Where the axis ends, as a factor around 1; as far as this agent needs if None.
    """
    found = agent.inference
    if not any(condition.success.n for condition in agent.conditions):
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    rows, widest = _odds_rows(agent), reach or odds_reach([agent])
    axes.set_xscale("log")
    forest(axes, rows, (1 / widest, widest), levels=((1.0, INK, "-"),))
    for i, effect in enumerate((found.hazard, found.landmark)):
        if effect.blind:
            axes.plot([effect.blind.odds_ratio], [i], marker="|", color=ACCENT, markersize=11, markeredgewidth=1.6)
    ticks = [tick for tick in (0.001, 0.01, 0.1, 0.3, 1, 3, 10, 100, 1000) if 1 / widest <= tick <= widest]
    ticks = [tick for tick in ticks if widest < 30 or tick not in {0.3, 3}]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(which="minor", length=0)
    axes.set_xlabel("odds ratio of solving, after over before a loop", fontsize=SMALL, color=INK)
    n = sum(condition.success.n for condition in (agent.conditions[:1] if agent.blind else agent.conditions))
    blind = "|: a blind agent with the same habits" if found.hazard.blind else ""
    return title(axes, heading(agent), f"n = {n} trials; bars: 95 % intervals", blind)


def _effect(name: str, found: LoopEffect) -> ForestRow:
    return ForestRow(
        name=name,
        said=_said(found.odds_ratio, found.low, found.high, found.p_value),
        value=found.odds_ratio,
        low=found.low,
        high=found.high,
        colour=SUBJECTS[0],
        face=SUBJECTS[0],
    )


def _said(value: float | None, low: float | None, high: float | None, p: float | None) -> str:
    if value is None:
        return "not defined" if p is None else f"not defined, {p_value(p, '$P$')}"
    interval = "" if low is None or high is None else f" [{_short(low)}, {_short(high)}]"
    return f"{_short(value)}{interval}, {p_value(p, '$P$')}"


def _short(ratio: float) -> str:
    return f"{ratio:.0f}" if 10 <= ratio <= _WIDEST else f"{ratio:.2g}"


def draw_loops_with_chance(axes: Axes, agent: AgentSummary) -> None:
    """Fig. 5b with Wilson's intervals and what chance alone gives in trials of exactly these lengths."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return blank(axes, f"{agent_label(agent)}: no trial has ended")
    x, found = [condition.p for condition in counted], [condition.behaviour for condition in counted]
    style = Style(colour=ACCENT, marker="o", dash="-", lead=True)
    bars(axes, x, [behaviour.loops for behaviour in found], style)
    share_axis(axes, "share of trials with a loop")
    p_axis(axes, agent.conditions, axis=agent.axis)
    low, high = axes.get_xlim()
    _blind_agents(axes, x, [b.chance_uniform for b in found], [b.chance_no_repeat for b in found])
    for side, marker, levels in (
        (-1, "x", [b.chance_markov for b in found]),
        (1, "+", [b.chance_permutation for b in found]),
    ):
        axes.plot(
            [p + side * 0.028 * (high - low) for p in x],
            _known(levels),
            linestyle="none",
            marker=marker,
            markersize=4.2,
            markeredgewidth=0.9,
            color=INK,
            zorder=3,
        )
    return title(
        axes,
        heading(agent),
        f"{counts(counted)} per {agent.axis.name}; bars: 95 % Wilson intervals",
        "chance: grey; \N{MULTIPLICATION SIGN}: same transitions; +: shuffled",
    )


def _blind_agents(
    axes: Axes, x: Sequence[float], uniform: Sequence[float | None], no_repeat: Sequence[float | None]
) -> None:
    """Between the two blind agents; a single p is given some width to be seen."""
    low, high = axes.get_xlim()
    reach = 0.04 * (high - low)
    ends = x if len(x) > 1 else [x[0] - reach, x[0] + reach]
    first, second = (_known(levels) * (len(ends) // len(x)) for levels in (uniform, no_repeat))
    axes.fill_between(ends, first, second, color="#999999", alpha=0.2, linewidth=0, zorder=1)
    for levels, name in ((first, "random"), (second, "no-repeat")):
        axes.plot(ends, levels, linestyle=EXACT[name], color=FAINT, linewidth=0.9, zorder=2)
    label_right(axes, [(first[-1], "random", FAINT), (second[-1], "no-repeat", FAINT)])


def _known(levels: Sequence[float | None]) -> list[float]:
    return [float("nan") if level is None else level for level in levels]


def draw_loop_onset(axes: Axes, agent: AgentSummary) -> None:
    """When the first loop is complete: the lowest p against all higher ones, one minus Kaplan-Meier."""
    found = agent.inference.onset.primary
    if found is None:
        why = "the same at every flip rate" if agent.blind else "fewer than two flip rates with trials"
        return blank(axes, f"{agent_label(agent)}: no comparison of loop onsets ({why})")
    groups = (
        (found.lowest, Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True)),
        (found.higher, Style(colour=ACCENT, marker="s", dash=(0, (5, 1.5)), lead=True)),
    )
    for i, (group, style) in enumerate(groups):
        staircase(axes, group.curve.share, style, first=1 + 2 * i)
        band(axes, group.curve.low, group.curve.high, style)
    step_axis(axes, max(len(group.curve.share) - 1 for group, _ in groups), "looped by this step")
    label_right(axes, [(group.curve.share[-1], _group(group), style.colour) for group, style in groups], gap=0.2)
    ratio = "hazard ratio not defined" if found.hazard_ratio is None else f"hazard ratio {found.hazard_ratio:.2f}"
    return title(
        axes,
        agent_label(agent),
        f"{ratio}, log-rank: {p_value(found.p_value, '$P$')}",
        "1 \N{MINUS SIGN} Kaplan-Meier, censored at success; 95 % bands",
    )


def _group(group: EventGroup) -> str:
    p = f"{group.p[0]:g}" if len(group.p) == 1 else f"{group.p[0]:g} to {group.p[-1]:g}"
    return f"$p$ = {p}\nn = {group.n}"
