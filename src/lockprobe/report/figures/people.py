"""People, models and strategies on the same boxes: success.

Over flip rates alone the axis is the rate. With other conditions every condition has a group of rows, a row for each
agent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.figures.compose import HEIGHT, sheet
from lockprobe.report.figures.frame import agent_label, p_axis, safe_name, shortened, title
from lockprobe.report.figures.palette import Style, shifts, styles
from lockprobe.report.figures.primitives import key, numbers
from lockprobe.report.figures.settings import INK, SMALL, own_settings
from lockprobe.report.rows import Cell, Course, Estimate, Results

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
    """Success of people and of agents beside them; None without people."""
    if not found.where("people", agent=PEOPLE):
        return None
    places = _rows(found) if found.beside_flips else _rates(found)
    height = HEIGHT if places.upright else places.height + _FRAME
    return sheet([found], partial(_draw_success, places=places), heights=[height])


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


def _place(of: Cell) -> tuple[str, str, str]:
    return of.agent, of.modality, of.condition


def _share(cell: Cell) -> Estimate | None:
    return cell.get("success", "by person" if cell.agent == PEOPLE else "")


def _draw_success(axes: Axes, found: Results, places: _Places) -> None:
    """Share solved by condition; in the intervals of people trials of one person count together."""
    for agent, style in places.agents:
        marks = [
            (places.at[_place(cell)], *numbers([row.value, row.low, row.high]))
            for cell in agent.cells
            if (row := _share(cell)) is not None
        ]
        _draw(axes, marks, style, upright=places.upright)
        if marks:
            key(axes, style, agent_label(agent))
    ticks = {tick / 4: f"{25 * tick} %" if tick else "0" for tick in range(5)}
    _value_axis(axes, places, ticks)
    _place_axis(axes, places)
    everyone = found.one("people", agent=PEOPLE, modality="")
    fewest, most = (found.one("boxes_each", agent=PEOPLE, of=of).value for of in ("fewest", "most"))
    boxes = "1 box" if most == 1 else f"{fewest:g} boxes" if fewest == most else f"{fewest:g} to {most:g} boxes"
    who = "1 person" if everyone.value == 1 else f"{everyone.value:g} people"
    return title(axes, f"{who} with {boxes} each; bars: 95 % intervals")


def _draw(axes: Axes, marks: Sequence[tuple[float, ...]], style: Style, *, upright: bool) -> None:
    """Marks of one agent (place, share, low, high): with intervals if the study is about it, joined over flip rates."""

    def turned(at: list[float], values: list[float]) -> tuple[list[float], list[float]]:
        return (at, values) if upright else (values, at)

    for at, value, low, high in marks:
        if style.lead:
            bar = turned([at] * 2, [low, high])
            axes.plot(*bar, color=style.colour, linewidth=1.0, zorder=3, solid_capstyle="butt")
        axes.plot(
            *turned([at], [value]),
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
        width = 1.2 if style.lead else 0.8
        places, values = [mark[0] for mark in marks], [mark[1] for mark in marks]
        axes.plot(places, values, color=style.colour, linestyle=style.dash, linewidth=width, zorder=3)


def _value_axis(axes: Axes, places: _Places, ticks: Mapping[float, str]) -> None:
    """The axis of shares: the vertical one over flip rates, the horizontal one below rows."""
    name: Literal["x", "y"] = "y" if places.upright else "x"
    axis = axes.yaxis if places.upright else axes.xaxis
    axes.set(**{f"{name}lim": (-0.03, 1.03)})
    axis.set_ticks(list(ticks), list(ticks.values()))
    axis.set_label_text("success rate", fontsize=SMALL, color=INK)
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
