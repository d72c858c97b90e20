"""The figure of a report's first screen: success of every agent by flip rate or step, named where its line ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from statistics import fmean
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from lockprobe.report.figures.compose import COLUMN, HEIGHT, sheet
from lockprobe.report.figures.frame import (
    FAINT,
    agent_label,
    label_in_lines,
    label_right,
    p_axis,
    share_axis,
    shortened,
    step_axis,
)
from lockprobe.report.figures.palette import Dash, Style, of_agent, styles
from lockprobe.report.figures.primitives import by_dose, published, published_by_p, staircase
from lockprobe.report.figures.settings import own_settings
from lockprobe.report.prose.readings import reading_name
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.published import SOLVED_AT_0, SOLVED_AT_40

__all__ = ["draw_overview"]

_SIZES = {"screen": (5.6, 3.15), "column": (COLUMN, HEIGHT), "print": (6.9, 3.0)}
"""Sizes in inches; that of the first screen is as wide for its height as a slide, that of print two columns wide."""

_TICKS = 3
"""Ticks of the figure in a column."""

_MOST = 8
"""Agents that are drawn: those that the study is about first."""

_NAME = 28
"""Characters of a name at the right edge."""

_FEW = 4
"""Agents whose names have room for two lines."""

_SHORT = 16
"""Characters of a name before the name of a kind of false reports."""

_IN_COLUMN = 27
"""Characters of a name and its modality in a column."""

_CHANCE: dict[str, Any] = {"color": FAINT, "alpha": 0.13, "linewidth": 0, "zorder": 0}
"""How the range of random agents is drawn."""

_RANDOM = "random agents, exact"
"""What that range is called, beside agents that were played."""

_BESIDE_STAR, _NEAR_STAR = 0.1, 0.13
"""How far beside a star its name is, of the width of the axes, and how near in height a line would cross the name."""

_OTHER: Dash = (0, (1, 1.2))
"""The line of an agent under another reading of a false report."""

_LIGHTER = 0.3
"""How much white is mixed into its colour."""

_STAYS = {"others=kept": "lies stay"}
"""What readings are called where there is little room."""

_Shown = Sequence[tuple[Course, Style]]


@own_settings()
def draw_overview(found: Results, size: Literal["screen", "column", "print"] = "screen") -> Figure | None:
    """Success by flip rate, or by step where there is only one, with chance and the paper's points.

    Args:
        found: The results; nothing is drawn before a trial has ended.
        size: That of the first screen, of a column of print, or of two.
    """
    shown = [(course, style) for course, style in styles(found.courses()) if course.played][:_MOST]
    draw = partial(_by_p, stars_named=size != "column") if found.several_p else _by_step
    width, height = _SIZES[size]
    figure = sheet([shown] if shown else [], partial(draw, found), heights=(height,), width=width)
    if figure and size == "column":  # the names of agents take half of it
        (axes,) = figure.axes
        every = -(-len(axes.get_xticks()) // _TICKS)
        labels = [label.get_text() for label in axes.get_xticklabels()]
        axes.set_xticks(axes.get_xticks()[::every], labels[::every])
        for text in axes.texts:
            text.set_text("\n".join(shortened(line, _IN_COLUMN) for line in text.get_text().split("\n")))
    return figure


def _by_p(found: Results, axes: Axes, shown: _Shown, *, stars_named: bool) -> None:
    """Shares with Wilson's intervals, beside the range of random agents. In a column the caption names the stars."""
    courses = found.courses()
    labels = []
    cells = [cell for course in courses for cell in course.cells]
    for course, style in shown:
        by_dose(axes, course.played, "success", style, linestyle=style.dash)
        labels.append((course.played[-1].value("success") or 0.0, _named(course, shown), style.colour))
    own = {(course.agent, course.modality): style.colour for course, style in shown}
    for course, style, words in _other_readings(found, shown):
        by_dose(axes, course.played, "success", style, bars=False, linestyle=style.dash)
        named = f"{agent_label(course, _SHORT)}: {words}"
        labels.append((course.played[-1].value("success") or 0.0, named, own[course.agent, course.modality]))
    share_axis(axes, "trials solved")
    p_axis(axes, cells)
    if chance := _chance(found):
        low, high = (share[_budget(shown)] for share in chance)
        axes.axhspan(low, high, **_CHANCE)
        labels.append(((low + high) / 2, _RANDOM, FAINT))
    stars = published_by_p(cells, SOLVED_AT_0, SOLVED_AT_40)
    published(axes, stars, label="")
    for place in stars if stars_named else ():
        _name_star(axes, place, [line for xy in axes.lines if len(line := np.asarray(xy.get_xydata())) > 1])
    label_right(axes, labels)


def _name_star(axes: Axes, place: tuple[float, float], lines: Sequence[Any]) -> None:
    """Name a star beside it, above or below it where a line passes there."""
    left, right = axes.get_xlim()
    side = 1 if place[0] < (left + right) / 2 else -1
    there = place[0] + side * _BESIDE_STAR * (right - left)
    passing = [y for y in (np.interp(there, *line.T) for line in lines) if abs(y - place[1]) < _NEAR_STAR]
    style: dict[str, Any] = {"textcoords": "offset points", "ha": "left" if side > 0 else "right"}
    style["va"] = "center" if not passing else "bottom" if fmean(passing) <= place[1] else "top"
    style["path_effects"] = [withStroke(linewidth=1.4, foreground="white")]  # a patch would hide lines
    axes.annotate("Zenkri\n& Brock", place, (6 * side, 0), color=FAINT, zorder=6, **style)


def _named(course: Course, shown: _Shown) -> str:
    """The name at the end of a line, in two lines if it is long and there is room for them."""
    return label_in_lines(course, _NAME) if len(shown) <= _FEW else agent_label(course, _NAME)


def _other_readings(found: Results, shown: _Shown) -> Iterator[tuple[Course, Style, str]]:
    """The agents that heed reports under the other readings of a false report, paler, with what these are."""
    looks = {(course.agent, course.modality): style for course, style in shown if not course.blind}
    usual = found.readings[0][1] if found.readings else ""
    for axis, options in found.readings:
        for course in found.courses(axis) if options != usual else ():
            own = (course.agent, course.modality)
            if own in looks and len(course.played) > 1:
                style = of_agent(course, replace(looks[own], dash=_OTHER, lead=False), _LIGHTER)
                yield course, style, _STAYS.get(options, reading_name(options))


def _by_step(found: Results, axes: Axes, shown: _Shown) -> None:
    """Shares solved by each step, beside the range of random agents."""
    labels, budget = [], _budget(shown)
    for i, (course, style) in enumerate(shown):
        curve = course.played[0].curve("success_by_step")
        share = curve.value if curve else ()
        staircase(axes, share, style, label="", first=1 + i % 4)
        labels.append((share[-1] or 0.0, _named(course, shown), style.colour))
    if chance := _chance(found):
        low, high = (share[: budget + 1] for share in chance)
        axes.fill_between(range(budget + 1), low, high, step="post", **_CHANCE)
        labels.append(((low[-1] + high[-1]) / 2, _RANDOM, FAINT))
    step_axis(axes, budget, "solved by this step")
    label_right(axes, labels)


def _budget(shown: _Shown) -> int:
    """Steps of the longest curve."""
    curves = (cell.curve("success_by_step") for course, _ in shown for cell in course.played)
    return max((len(curve.x) - 1 for curve in curves if curve), default=0)


def _chance(found: Results) -> list[list[float]]:
    """What random agents with and without immediate repeats solve by each step; empty if it is not known."""
    curves = [found.curve("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat")]
    return [[value or 0.0 for value in curve.value] for curve in curves if curve]
