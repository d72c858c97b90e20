"""The figure of a report's first screen: success of every agent by flip rate or step, named where its line ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

from lockprobe.report.figures.compose import COLUMN, HEIGHT, sheet
from lockprobe.report.figures.frame import (
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
from lockprobe.report.figures.settings import FAINT, own_settings
from lockprobe.report.prose.readings import reading_name
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.published import SOLVED_AT_0, SOLVED_AT_40

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

_OF_STARS = "Zenkri & Brock"
"""Whose the stars are."""

_STAR, _STAR_NAME = 0.02, (0.19, 0.12)
"""How far beside a star its name begins, and the size of the name, in sizes of the axes, generously."""

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
    draw = partial(_by_p, beside=size != "column") if found.several_p else _by_step
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


def _by_p(found: Results, axes: Axes, shown: _Shown, *, beside: bool) -> None:
    """Shares with Wilson's intervals, beside random agents. Stars are named beside them, or at the edge."""
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
    if stars and not (beside and _name_stars(axes, stars)):
        labels.append((0.0, f"\N{WHITE STAR} {_OF_STARS}", FAINT))
    label_right(axes, labels)


def _name_stars(axes: Axes, stars: Sequence[tuple[float, float]]) -> bool:
    """Name the stars beside which a name crosses no line; whether there is such a one."""
    bars = [line for bar in axes.collections if isinstance(bar, LineCollection) for line in bar.get_segments()]
    drawn = [line.get_xydata() for line in axes.lines if line.get_linestyle() != "None"]
    lines = [Path(axes.transLimits.transform(line)) for line in (*bars, *drawn)]
    places = {star: next(_beside(axes.transLimits.transform(star).tolist(), lines), None) for star in stars}
    for star, place in places.items():
        if place:
            side, upright = place
            style: dict[str, Any] = {"textcoords": "offset points", "ha": "left" if side > 0 else "right"}
            style["path_effects"] = [withStroke(linewidth=1.4, foreground="white")]  # a patch would hide lines
            name = _OF_STARS.replace(" ", "\n", 1)
            axes.annotate(name, star, (6 * side, 0), va=upright, color=FAINT, zorder=6, **style)
    return any(places.values())


def _beside(star: Sequence[float], lines: Sequence[Path]) -> Iterator[tuple[int, str]]:
    """Where a name beside a star, in sizes of the axes, crosses no line: its side and how it stands to the star."""
    (x, y), (wide, high) = star, _STAR_NAME
    inwards = 1 if x < 0.5 else -1
    for (upright, below), side in product((("center", 0.5), ("bottom", 0.0), ("top", 1.0)), (inwards, -inwards)):
        left, right = sorted((x + side * _STAR, x + side * (_STAR + wide)))
        room = Bbox.from_extents(left, y - below * high, right, y + (1 - below) * high)
        if left >= 0.0 and right <= 1.0 and not any(line.intersects_bbox(room, filled=False) for line in lines):
            yield side, upright


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
