"""People, models and strategies on the same boxes: success, and steps relative to the human median.

Over flip rates alone the axis is the rate. With other conditions every condition has a group of rows, a row for each
agent. A ratio has an axis on which twice as many steps and half as many are equally far.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.figures.compose import HEIGHT, sheet
from lockprobe.report.figures.frame import INK, SMALL, agent_label, blank, p_axis, safe_name, shortened, title
from lockprobe.report.figures.palette import Style, shifts, styles
from lockprobe.report.figures.primitives import key, numbers
from lockprobe.report.figures.settings import own_settings
from lockprobe.report.rows import Cell, Course, Estimate, Results

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

_NAME, _ROW, _BETWEEN, _FRAME = 0.2, 0.13, 0.06, 0.95
"""Heights in inches: the name of a condition, the row of an agent, between conditions, and all around the rows."""

_LONGEST = 44
"""Characters of the name of a condition."""


@dataclass(frozen=True, slots=True)
class _Places:
    """Where the numbers of agents under conditions stand.

    Attributes:
        agents: The agents with their looks, people first.
        at: Agent, modality and condition -> the place: a flip rate, or the height of a row in inches from the top.
        names: Condition -> the height of its name; empty over flip rates.
        height: Of all rows.
    """

    agents: Sequence[tuple[Course, Style]]
    at: Mapping[tuple[str, str, str], float]
    names: Mapping[str, float]
    height: float = 0.0

    @property
    def upright(self) -> bool:
        """Whether places are on the horizontal axis, and values above them."""
        return not self.names


@own_settings()
def people(found: Results) -> Figure | None:
    """Success, and below it steps where an agent played a trial that people played; None without people."""
    if not found.where("people", agent=PEOPLE):
        return None
    places = _rows(found) if found.beside_flips else _rates(found)
    draws = [_draw_success, *([_draw_ratios] if found.where("mean_steps_ratio", versus=PEOPLE) else [])]
    heights = [HEIGHT if places.upright else places.height + _FRAME] * len(draws)
    return sheet([found], *(partial(draw, places=places) for draw in draws), heights=heights)


def _rates(found: Results) -> _Places:
    """Places over flip rates, moved sideways so that marks of several agents stay apart."""
    courses = found.courses()
    moved = shifts(courses)
    at = {_place(cell): (cell.dose or 0.0) + moved[cell.agent, cell.modality] for one in courses for cell in one.cells}
    return _Places(_people_first(courses), at, {})


def _rows(found: Results) -> _Places:
    """Places in rows by condition, in the order of the study."""
    courses = [
        Course(found=found, player=player, axis="", name="condition", cells=tuple(cells))
        for player in found.design.players
        if (cells := [one for one in found.cells if (one.agent, one.modality) == (player.agent, player.modality)])
    ]
    agents, at, names, y = _people_first(courses), dict[tuple[str, str, str], float](), dict[str, float](), 0.0
    for condition in (one.name for one in found.design.conditions):
        rows = [cell for agent, _ in agents for cell in agent.cells if cell.condition == condition and _share(cell)]
        if rows:
            names[condition] = y
            at |= {_place(cell): y + _NAME + _ROW * (i + 0.5) for i, cell in enumerate(rows)}
            y += _NAME + _ROW * len(rows) + _BETWEEN
    return _Places(agents, at, names, y)


def _people_first(courses: Sequence[Course]) -> list[tuple[Course, Style]]:
    return sorted(styles(courses), key=lambda one: one[0].agent != PEOPLE)


def _place(of: Cell | Estimate) -> tuple[str, str, str]:
    return of.agent, of.modality, of.condition


def _share(cell: Cell) -> Estimate | None:
    return cell.get("success", "by person" if cell.agent == PEOPLE else "")


def _draw_success(axes: Axes, found: Results, places: _Places) -> None:
    """Share solved by condition; in the intervals of people trials of one person count together."""
    for agent, style in places.agents:
        marks = [
            _Mark(places.at[_place(cell)], *numbers([row.value, row.low, row.high]))
            for cell in agent.cells
            if (row := _share(cell)) is not None
        ]
        _draw(axes, marks, style, upright=places.upright)
        if marks:
            key(axes, style, agent_label(agent))
    ticks = {tick / 4: f"{25 * tick} %" if tick else "0" for tick in range(5)}
    _value_axis(axes, places, (-0.03, 1.03), ticks, "success rate")
    _place_axis(axes, places)
    everyone = found.one("people", agent=PEOPLE, modality="")
    fewest, most = (found.one("boxes_each", agent=PEOPLE, of=of).value for of in ("fewest", "most"))
    boxes = "1 box" if most == 1 else f"{fewest:g} boxes" if fewest == most else f"{fewest:g} to {most:g} boxes"
    who = "1 person" if everyone.value == 1 else f"{everyone.value:g} people"
    return title(axes, f"{who} with {boxes} each; bars: 95 % intervals")


def _draw_ratios(axes: Axes, found: Results, places: _Places) -> None:
    """Median steps over the human median by condition; above 1 an agent is slower than people.

    An arrow marks a bound: towards more where the agent's median lies beyond the budget, towards fewer where that of
    people does. A bar that runs to the edge is open.
    """
    rows = [row for row in found.where("steps_ratio", versus=PEOPLE) if row.condition]
    if not rows:
        return blank(axes, "neither people nor agents solved half of their trials, so there is no median")
    ends = [end for row in rows for end in (_beyond(row), row.low, row.high) if end is not None]
    reach = max(_LEAST, *(max(end, 1 / end) for end in ends)) * _EDGE
    for agent, style in places.agents:
        own = [row for row in rows if (row.agent, row.modality) == (agent.agent, agent.modality)]
        _draw(axes, [_ratio(row, places, reach) for row in own], style, upright=places.upright)
        if agent.agent == PEOPLE:
            line = axes.axhline if places.upright else axes.axvline
            line(1, color=style.colour, linewidth=1.2, linestyle=style.dash, zorder=2)
    ticks = [tick for tick in _TICKS if 1 / reach <= tick <= reach]
    ticks = ticks if len(ticks) <= _NAMED else [tick for tick in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0) if tick in ticks]
    named = {tick: f"{tick:g}" for tick in ticks}
    _value_axis(axes, places, (1 / reach, reach), named, "steps / human median", scale="log")
    _place_axis(axes, places)
    return title(axes, "steps on the same boxes; above 1: more than people", _bounds(rows, upright=places.upright))


def _beyond(row: Estimate) -> float:
    """Where the mark of a ratio ends, with the arrow of a bound."""
    value = row.value or math.nan
    return value * _ARROW if row.note == _LOWER else value / _ARROW if row.note == _UPPER else value


def _bounds(rows: Sequence[Estimate], *, upright: bool) -> str:
    up, down = "\N{UPWARDS ARROW}\N{DOWNWARDS ARROW}" if upright else "\N{RIGHTWARDS ARROW}\N{LEFTWARDS ARROW}"
    said = [
        f"{up} at least" if any(row.note == _LOWER for row in rows) else "",
        f"{down} at most" if any(row.note == _UPPER for row in rows) else "",
    ]
    bounds = ", ".join(filter(None, said))
    return bounds and f"{bounds}: a median exceeds the budget"


@dataclass(frozen=True, slots=True)
class _Mark:
    """One number of an agent: its place, the number, its interval, and where the arrow of a bound ends."""

    at: float
    value: float
    low: float
    high: float
    arrow: float | None = None


def _ratio(row: Estimate, places: _Places, reach: float) -> _Mark:
    """The mark of a ratio; an open end of its interval is at the edge."""
    value = row.value or math.nan
    low = row.low if row.low is not None else 1 / reach if row.high is not None or row.note == _UPPER else value
    high = row.high if row.high is not None else reach if row.low is not None or row.note == _LOWER else value
    return _Mark(places.at[_place(row)], value, low, high, _beyond(row) if row.note else None)


def _draw(axes: Axes, marks: Sequence[_Mark], style: Style, *, upright: bool) -> None:
    """Marks of one agent: with intervals if the study is about it, joined by a line over flip rates."""
    turned = partial(_turned, upright=upright)
    for mark in marks:
        if style.lead:
            bar = turned([mark.at] * 2, [mark.low, mark.high])
            axes.plot(*bar, color=style.colour, linewidth=1.0, zorder=3, solid_capstyle="butt")
        if mark.arrow is not None:
            axes.annotate(
                "",
                xy=_point(mark.at, mark.arrow, upright=upright),
                xytext=_point(mark.at, mark.value, upright=upright),
                arrowprops={"arrowstyle": "->", "color": style.colour, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0},
                zorder=3,
            )
        axes.plot(
            *turned([mark.at], [mark.value]),
            linestyle="none",
            marker=style.marker,
            color=style.colour,
            markersize=5.0 if style.lead else 3.6,
            markerfacecolor=style.face,
            markeredgecolor="white" if style.lead else style.colour,
            markeredgewidth=0.7,
            zorder=5,
        )
    if upright:
        exact = numbers(None if mark.arrow is not None else mark.value for mark in marks)
        width = 1.2 if style.lead else 0.8
        axes.plot(
            [mark.at for mark in marks], exact, color=style.colour, linestyle=style.dash, linewidth=width, zorder=3
        )


def _turned(at: list[float], values: list[float], *, upright: bool) -> tuple[list[float], list[float]]:
    """The coordinates of places and values."""
    return (at, values) if upright else (values, at)


def _point(at: float, value: float, *, upright: bool) -> tuple[float, float]:
    return (at, value) if upright else (value, at)


def _value_axis(
    axes: Axes,
    places: _Places,
    limits: tuple[float, float],
    ticks: Mapping[float, str],
    label: str,
    scale: str = "linear",
) -> None:
    """The axis of the numbers: the vertical one over flip rates, the horizontal one below rows."""
    name: Literal["x", "y"] = "y" if places.upright else "x"
    axis = axes.yaxis if places.upright else axes.xaxis
    axes.set(**{f"{name}scale": scale, f"{name}lim": limits})
    axis.set_ticks([], minor=True)
    axis.set_ticks(list(ticks), list(ticks.values()))
    axis.set_label_text(label, fontsize=SMALL, color=INK)
    axes.grid(axis=name, color="#e6e6e6", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)


def _place_axis(axes: Axes, places: _Places) -> None:
    """The axis of flip rates, or the names of conditions above their rows."""
    if places.upright:
        cells = [cell for agent, _ in places.agents for cell in agent.cells]
        p_axis(axes, cells)
        moved, (low, high) = max(abs(places.at[_place(cell)] - (cell.dose or 0.0)) for cell in cells), axes.get_xlim()
        axes.set_xlim(low - moved, high + moved)  # marks that stand beside their dose have room too
        return
    axes.set_ylim(places.height, 0)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    for condition, y in places.names.items():
        axes.text(
            0.0,
            y + 0.8 * _NAME,
            safe_name(shortened(condition, _LONGEST)),
            transform=axes.get_yaxis_transform(),
            va="bottom",
            fontsize=SMALL,
            color=INK,
            zorder=4,
            bbox={"facecolor": "white", "linewidth": 0, "pad": 0.4},
        )
