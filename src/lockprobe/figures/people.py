"""People, models and strategies on the same boxes: success, and steps relative to the human median.

People stand first among the agents that the study is about, in their colour; where others lie to them is read off a
ratio axis, on which twice as many steps and half as many are equally far.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator

from lockprobe.analysis.clustered import ClusteredProportion
from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.relative_steps import RelativeSteps
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.figures.frame import INK, SMALL, agent_label, blank, p_axis, share_axis, title
from lockprobe.figures.palette import Style, shifts, styles
from lockprobe.figures.primitives import key

__all__ = ["compared", "draw_people", "draw_relative_steps"]

_ARROW = 1.22
"""How far the arrow of a bound reaches, as a factor."""

_EDGE = 1.12
"""Room beyond the farthest mark, as a factor."""

_LEAST = 2.2
"""The axis of ratios reaches at least from one over this to this."""

_TICKS = (0.1, 0.125, 0.2, 0.25, 0.33, 0.5, 0.67, 0.8, 1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0, 10.0)
_NAMED = 7
"""Ticks that the axis of ratios has room for."""


def compared(result: StudySummary) -> bool:
    """Whether any agent played a trial that people played."""
    return result.people is not None and bool(result.people.relative)


def draw_people(axes: Axes, result: StudySummary) -> None:
    """Share solved by flip probability; in the intervals of people trials of one person count together."""
    if result.people is None:
        return blank(axes, "no trial of people has ended")
    moved = shifts(result)
    for agent, style in styles(result):
        shift = moved[agent.agent, agent.modality]
        found = _shares(result, agent)
        if not found:
            continue
        axes.errorbar(
            [p + shift for p, _ in found],
            [share.value for _, share in found],
            yerr=[[s.value - s.low for _, s in found], [s.high - s.value for _, s in found]] if style.lead else None,
            fmt="",
            marker=style.marker,
            color=style.colour,
            markersize=5.0 if style.lead else 3.6,
            markerfacecolor=style.face,
            markeredgecolor="white" if style.lead else style.colour,
            markeredgewidth=0.7,
            linestyle=style.dash,
            linewidth=1.2 if style.lead else 0.8,
            elinewidth=1.0,
            capsize=0,
            zorder=5 if agent.invited else 4 if style.lead else 3,
        )
        key(axes, style, _name(result, agent))
    share_axis(axes, "success rate")
    p_axis(axes, result.conditions, max(map(abs, moved.values()), default=0.0))
    each = (
        f"{result.people.fewest}"
        if result.people.fewest == result.people.most
        else (f"{result.people.fewest} to {result.people.most}")
    )
    return title(
        axes,
        f"{result.people.people} people with {each} boxes each; bars: 95 % intervals",
    )


def _shares(result: StudySummary, agent: AgentSummary) -> Sequence[tuple[float, Proportion | ClusteredProportion]]:
    if agent.invited and result.people is not None:
        return [
            (one.p, one.success) for one in result.people.at if one.modality == agent.modality and one.p is not None
        ]
    return [(condition.p, condition.success) for condition in agent.conditions if condition.success.n]


def _name(result: StudySummary, agent: AgentSummary) -> str:
    if agent.invited:
        return f"people ({agent.shown})" if agent.shown else "people"
    return agent_label(agent)


def draw_relative_steps(axes: Axes, result: StudySummary) -> None:
    """Median steps over the human median by flip probability; above 1 an agent is slower than people.

    An arrow marks a bound: upwards where the agent's median lies beyond the budget, downwards where that of people
    does. A bar that runs to the edge is open.
    """
    rows = [] if result.people is None else [one for one in result.people.relative if one.p is not None and _drawn(one)]
    if not rows:
        return blank(axes, "neither people nor agents solved half of their trials, so there is no median")
    ends = [end for one in rows for end in (one.ratio, one.low, one.high) if end is not None]
    ends += [end * _ARROW for one in rows if (end := one.least) is not None]
    ends += [end / _ARROW for one in rows if (end := one.most) is not None]
    reach = max(_LEAST, *(max(end, 1 / end) for end in ends)) * _EDGE
    moved = shifts(result)
    for agent, style in styles(result):
        own = [one for one in rows if (one.agent, one.modality) == (agent.agent, agent.modality)]
        _draw(axes, own, style, moved[agent.agent, agent.modality], reach)
        if agent.invited:
            axes.axhline(1, color=style.colour, linewidth=1.2, linestyle=style.dash, zorder=2)
    axes.set_yscale("log")
    axes.set_ylim(1 / reach, reach)
    ticks = [tick for tick in _TICKS if 1 / reach <= tick <= reach]
    ticks = ticks if len(ticks) <= _NAMED else [tick for tick in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0) if tick in ticks]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_ylabel("steps / human median", fontsize=SMALL, color=INK)
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.6, zorder=0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)
    p_axis(axes, result.conditions, max(map(abs, moved.values()), default=0.0))
    return title(axes, "steps on the same boxes; above 1: more than people", _bounds(rows))


def _drawn(one: RelativeSteps) -> bool:
    return _place(one) is not None


def _place(one: RelativeSteps) -> float | None:
    return next((value for value in (one.ratio, one.least, one.most) if value is not None), None)


def _bounds(rows: Sequence[RelativeSteps]) -> str:
    said = [
        "\N{UPWARDS ARROW} at least" if any(one.least is not None for one in rows) else "",
        "\N{DOWNWARDS ARROW} at most" if any(one.most is not None for one in rows) else "",
    ]
    bounds = ", ".join(filter(None, said))
    return bounds and f"{bounds}: a median exceeds the budget"


def _draw(axes: Axes, rows: Sequence[RelativeSteps], style: Style, shift: float, reach: float) -> None:
    for one in rows:
        place = _place(one)
        assert place is not None
        assert one.p is not None
        low = one.low if one.low is not None else 1 / reach if one.high is not None or one.most is not None else place
        high = one.high if one.high is not None else reach if one.low is not None or one.least is not None else place
        if style.lead:
            axes.plot(
                [one.p + shift] * 2, [low, high], color=style.colour, linewidth=1.0, zorder=3, solid_capstyle="butt"
            )
        axes.plot(
            [one.p + shift],
            [place],
            linestyle="none",
            marker=style.marker,
            color=style.colour,
            markersize=5.0 if style.lead else 3.6,
            markerfacecolor=style.face,
            markeredgecolor="white" if style.lead else style.colour,
            markeredgewidth=0.7,
            zorder=4,
        )
        if one.ratio is None:
            beyond = place * _ARROW if one.least is not None else place / _ARROW
            axes.annotate(
                "",
                xy=(one.p + shift, beyond),
                xytext=(one.p + shift, place),
                arrowprops={"arrowstyle": "->", "color": style.colour, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0},
                zorder=3,
            )
    points = [(one.p, one.ratio) for one in rows if one.p is not None]
    axes.plot(
        [p + shift for p, _ in points],
        [math.nan if ratio is None else ratio for _, ratio in points],
        color=style.colour,
        linestyle=style.dash,
        linewidth=1.2 if style.lead else 0.8,
        zorder=3,
    )
