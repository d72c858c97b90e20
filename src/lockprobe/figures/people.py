"""People, models and strategies on the same boxes: success, and steps relative to the human median.

People stand first among the agents that the study is about, in their colour; where others lie to them is read off a
ratio axis, on which twice as many steps and half as many are equally far.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import INK, SMALL, agent_label, blank, p_axis, share_axis, title
from lockprobe.figures.palette import Style, shifts, styles
from lockprobe.figures.primitives import key, numbers
from lockprobe.figures.settings import own_settings
from lockprobe.rows import Cell, Course, Estimate, Results
from lockprobe.spec import PEOPLE

__all__ = ["people"]

_LOWER, _UPPER = "at least", "at most"
"""Notes of a ratio that is a bound."""

_ARROW = 1.22
"""How far the arrow of a bound reaches, as a factor."""

_EDGE = 1.12
"""Room beyond the farthest mark, as a factor."""

_LEAST = 2.2
"""The axis of ratios reaches at least from one over this to this."""

_TICKS = (0.1, 0.125, 0.2, 0.25, 0.33, 0.5, 0.67, 0.8, 1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0, 10.0)
_NAMED = 7
"""Ticks that the axis of ratios has room for."""


@own_settings()
def people(found: Results) -> Figure | None:
    """Success, and below it steps where an agent played a trial that people played; None without people."""
    if not found.where("people", agent=PEOPLE):
        return None
    compared = [_draw_relative_steps] if found.where("mean_steps_ratio", versus=PEOPLE) else []
    return sheet([found], _draw_success, *compared)


def _draw_success(axes: Axes, found: Results) -> None:
    """Share solved by flip probability; in the intervals of people trials of one person count together."""
    courses = found.courses()
    moved = shifts(courses)
    for agent, style in styles(courses):
        shift = moved[agent.agent, agent.modality]
        shares = [(cell.dose or 0.0, row) for cell in agent.cells if (row := _share(cell)) is not None]
        if not shares:
            continue
        low, value, high = (numbers(getattr(share, end) for _, share in shares) for end in ("low", "value", "high"))
        bars = [[b - a for a, b in zip(*ends, strict=True)] for ends in ((low, value), (value, high))]
        axes.errorbar(
            [p + shift for p, _ in shares],
            value,
            yerr=bars if style.lead else None,
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
            zorder=5 if agent.agent == PEOPLE else 4 if style.lead else 3,
        )
        key(axes, style, _name(agent))
    share_axis(axes, "success rate")
    p_axis(axes, _cells(courses), max(map(abs, moved.values()), default=0.0))
    everyone = found.one("people", agent=PEOPLE, modality="")
    fewest, most = (found.one("boxes_each", agent=PEOPLE, of=of).value for of in ("fewest", "most"))
    each = f"{fewest:g}" if fewest == most else f"{fewest:g} to {most:g}"
    return title(axes, f"{everyone.value:g} people with {each} boxes each; bars: 95 % intervals")


def _share(cell: Cell) -> Estimate | None:
    return cell.get("success", "by person" if cell.agent == PEOPLE else "")


def _cells(courses: Sequence[Course]) -> list[Cell]:
    return [cell for course in courses for cell in course.cells]


def _name(agent: Course) -> str:
    if agent.agent == PEOPLE:
        return f"people ({agent.shown})" if agent.shown else "people"
    return agent_label(agent)


def _draw_relative_steps(axes: Axes, found: Results) -> None:
    """Median steps over the human median by flip probability; above 1 an agent is slower than people.

    An arrow marks a bound: upwards where the agent's median lies beyond the budget, downwards where that of people
    does. A bar that runs to the edge is open.
    """
    rows = [row for row in found.where("steps_ratio", versus=PEOPLE) if row.condition]
    if not rows:
        return blank(axes, "neither people nor agents solved half of their trials, so there is no median")
    ends = [end for row in rows for end in (_beyond(row), row.low, row.high) if end is not None]
    reach = max(_LEAST, *(max(end, 1 / end) for end in ends)) * _EDGE
    courses = found.courses()
    moved = shifts(courses)
    for agent, style in styles(courses):
        own = [row for row in rows if (row.agent, row.modality) == (agent.agent, agent.modality)]
        _draw(axes, own, style, moved[agent.agent, agent.modality], reach)
        if agent.agent == PEOPLE:
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
    p_axis(axes, _cells(courses), max(map(abs, moved.values()), default=0.0))
    return title(axes, "steps on the same boxes; above 1: more than people", _bounds(rows))


def _beyond(row: Estimate) -> float:
    """Where the mark of a ratio ends, with the arrow of a bound."""
    value = row.value or math.nan
    return value * _ARROW if row.note == _LOWER else value / _ARROW if row.note == _UPPER else value


def _bounds(rows: Sequence[Estimate]) -> str:
    said = [
        "\N{UPWARDS ARROW} at least" if any(row.note == _LOWER for row in rows) else "",
        "\N{DOWNWARDS ARROW} at most" if any(row.note == _UPPER for row in rows) else "",
    ]
    bounds = ", ".join(filter(None, said))
    return bounds and f"{bounds}: a median exceeds the budget"


def _draw(axes: Axes, rows: Sequence[Estimate], style: Style, shift: float, reach: float) -> None:
    for row in rows:
        place, x = row.value or math.nan, row.doses["flip.p"] + shift
        low = row.low if row.low is not None else 1 / reach if row.high is not None or row.note == _UPPER else place
        high = row.high if row.high is not None else reach if row.low is not None or row.note == _LOWER else place
        if style.lead:
            axes.plot([x] * 2, [low, high], color=style.colour, linewidth=1.0, zorder=3, solid_capstyle="butt")
        axes.plot(
            [x],
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
        if row.note:
            axes.annotate(
                "",
                xy=(x, _beyond(row)),
                xytext=(x, place),
                arrowprops={"arrowstyle": "->", "color": style.colour, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0},
                zorder=3,
            )
    axes.plot(
        [row.doses["flip.p"] + shift for row in rows],
        numbers(None if row.note else row.value for row in rows),
        color=style.colour,
        linestyle=style.dash,
        linewidth=1.2 if style.lead else 0.8,
        zorder=3,
    )
