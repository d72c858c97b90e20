"""The figure of the first screen: success of up to three agents by dose, named where their lines end.

Hollow and ink: the control. Filled and accent: every other dose. Marker and dash tell agents apart. It is drawn twice,
wide and narrow, so that text keeps its size on a phone; colours are those of the page, which knows light and dark.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.terminal_text import printable
from lockprobe.report.labels import placed
from lockprobe.report.rows import Cell, Course, Results
from lockprobe.statistics.published import PEAK, SOLVED_AT_0, SOLVED_AT_40

MOST = 3
"""Lines that can be told apart and named; of more agents a list says more than a figure."""

_APART = 24
"""Least distance of two names, in pixels: a line of text."""

_BESIDE = 12
"""Distance of agents at one dose, in pixels."""

_LONG, _LINE = 28, 18
"""Characters of a name and its share at the end of a line, and the height of a second line of these in pixels."""

_DASHES = ("", "6 3", "2 3")

_STAR = "M{x} {top}l1.7 4.6 5 .2-3.9 3.1 1.3 4.8-4.1-2.8-4.1 2.8 1.3-4.8-3.9-3.1 5-.2z"
"""The paper's own points."""


@dataclass(frozen=True, slots=True)
class _Place:
    """Where doses and shares are drawn, in pixels."""

    doses: Sequence[float]
    left: float
    right: float
    top: float = 16
    bottom: float = 360

    def x(self, dose: float) -> float:
        low, high = self.doses[0], self.doses[-1]
        return self.left + (dose - low) / (high - low) * (self.right - self.left)

    def y(self, share: float) -> float:
        return self.bottom - share * (self.bottom - self.top)


def drawable(found: Results) -> list[Course]:
    """The agents that the figure shows; none where there are more than it can name, or a single dose.

    Random agents are its band. Another agent that plays alike whatever it is told is a line of equal shares.
    """
    axes = [] if found.several_p else [axis for axis in found.design.axes if not axis.of_flips][:1]
    courses = found.courses(axes[0]) if axes else found.courses()
    shown = [one for one in courses if len(one.played) > 1 and one.agent not in ("random", "random-no-repeat")]
    return shown if len(shown) <= MOST else []


def curve_figure(found: Results, *, wide: bool) -> Any:
    """The figure as an SVG element; empty markup where there is nothing to draw.

    Args:
        found: The results.
        wide: For a column of 880 pixels, with names at the ends of lines; else for 358 pixels, with names above.
    """
    courses = drawable(found)
    if not courses:
        return Markup("")
    doses = sorted({cell.dose or 0.0 for one in courses for cell in one.played})
    place = _Place(doses, 96, 628) if wide else _Place(doses, 88, 318, 16 + _APART * len(courses), 320)
    size = (880, place.bottom + 72) if wide else (358, place.bottom + 72)
    parts = [*_axes(found, place, courses), *_lines(courses, place), *_names(courses, place, wide=wide)]
    if courses[0].axis == "flip rate" and doses[0] == 0:
        parts += _paper(place, courses)
    names = ", ".join(map(_name, courses))
    svg = Markup('<svg class="{}" viewBox="0 0 {:g} {:g}" width="{:g}" height="{:g}" role="img" aria-label="{}">')
    shell = svg.format(
        "wide" if wide else "narrow", *size, *size, f"Share of trials solved by {courses[0].name}: {names}"
    )
    return shell + Markup("").join(parts) + Markup("</svg>")


def _name(course: Course) -> str:
    """Its name on one line, without characters that hide or reorder others."""
    return printable(" ".join(course.label.split()))


def _axes(found: Results, place: _Place, courses: Sequence[Course]) -> Iterator[Any]:
    left, right = place.left - 40, place.right + 40
    random = [found.curve("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat")]
    if chance := [curve.value[-1] or 0.0 for curve in random if curve]:
        low, high = place.y(min(chance)), place.y(max(chance))
        yield Markup('<rect class="band" x="{}" y="{:.1f}" width="{}" height="{:.1f}"/>').format(
            left, high, right - left, low - high
        )
        if low - high > _APART:
            middle = (place.x(place.doses[-2]) + place.x(place.doses[-1])) / 2  # where no interval stands
            ends = ([place.y(cell.value("success") or 0.0) for cell in one.played[-2:]] for one in courses)
            lines = [sum(end) / len(end) for end in ends]
            clear = max((low - 8, high + 18), key=lambda y: min(abs(y - 5 - line) for line in lines))
            yield _text(middle, clear, "random play", "q onband")
    for share in (0, 0.25, 0.5, 0.75, 1):
        y = place.y(share)
        yield Markup('<line class="grid" x1="{}" x2="{}" y1="{:.1f}" y2="{:.1f}"/>').format(left, right, y, y)
        yield _text(left - 8, y + 5, f"{100 * share:.0f}{' %' * (share == 1)}", "q", "end")
    every = max(1, -(-len(place.doses) // 6))
    for dose in place.doses[::every]:
        yield _text(place.x(dose), place.bottom + 24, f"{dose:g}", "", "middle")
    middle, said = (place.left + place.right) / 2, courses[0].name
    yield _text(middle, place.bottom + 48, f"{said}: how often a report is false" if said == "flip rate" else said, "q")


def _at(course: int, of: int) -> float:
    """How far beside a dose the points of an agent stand."""
    return (course - (of - 1) / 2) * _BESIDE


def _lines(courses: Sequence[Course], place: _Place) -> Iterator[Any]:
    for i, course in enumerate(courses):
        shift = _at(i, len(courses))
        points = [(place.x(cell.dose or 0.0) + shift, cell) for cell in course.played]
        path = "L".join(f"{x:.1f} {place.y(cell.value('success') or 0.0):.1f}" for x, cell in points)
        yield Markup('<path class="line" d="M{}" stroke-dasharray="{}"/>').format(path, _DASHES[i])
        for x, cell in points:
            row = cell.get("success")
            if row and row.low is not None and row.high is not None:
                yield Markup('<line class="{}" x1="{:.1f}" x2="{:.1f}" y1="{:.1f}" y2="{:.1f}"/>').format(
                    _kind(cell, place), x, x, place.y(row.low), place.y(row.high)
                )
            yield marker(x, place.y(cell.value("success") or 0.0), i, _kind(cell, place))


def _kind(cell: Cell, place: _Place) -> str:
    """Ink at the control, accent elsewhere."""
    return "told" if cell.dose == place.doses[0] else "false"


def marker(x: float, y: float, shape: int, kind: str) -> Any:
    """A point: circle, square or diamond by the agent; hollow for the control (``told``), filled elsewhere."""
    if shape == 0:
        return Markup('<circle class="{}" cx="{:.1f}" cy="{:.1f}" r="5"/>').format(kind, x, y)
    square = Markup(
        '<rect class="{}" x="{:.1f}" y="{:.1f}" width="9" height="9" transform="rotate({} {:.1f} {:.1f})"/>'
    )
    return square.format(kind, x - 4.5, y - 4.5, 45 if shape == 2 else 0, x, y)


def _names(courses: Sequence[Course], place: _Place, *, wide: bool) -> Iterator[Any]:
    ends = [course.played[-1] for course in courses]
    last = [cell.value("success") or 0.0 for cell in ends]
    at = ["" if cell.dose == place.doses[-1] else f" at {cell.dose:g}" for cell in ends]
    most = 2 * _LONG - 8 if wide else _LONG + 8
    names = [name if len(name) <= most else f"{name[:most]}…" for name in map(_name, courses)]
    told = [f"{name} {100 * share:.0f} %{dose}" for name, share, dose in zip(names, last, at, strict=True)]
    if not wide:
        for i, said in enumerate(told):
            yield marker(24, _APART * i + 12, i, "false") + _text(40, _APART * i + 17, said, "n2", "start")
        return
    broken = [[said] if len(said) <= _LONG else _in_two(name, said) for name, said in zip(names, told, strict=True)]
    apart = _APART + _LINE * (max(map(len, broken)) - 1)
    heights = placed([place.y(share) for share in last], place.top, place.bottom, apart)
    edge = place.right + _at(len(courses) - 1, len(courses)) + 10
    for i, (share, lines, height) in enumerate(zip(last, broken, heights, strict=True)):
        from_y, from_x = place.y(share), place.x(ends[i].dose or 0.0) + _at(i, len(courses)) + 10 if at[i] else edge
        if abs(height - from_y) > 1 or len(courses) > 1:
            yield Markup('<path class="lead" d="M{:.1f} {:.1f}L{:.1f} {:.1f}H{:.1f}"/>').format(
                from_x, from_y, edge + 16, height, edge + 24
            )
        for row, line in enumerate(lines):
            yield _text(edge + 30, height + 5 + (row - (len(lines) - 1) / 2) * _LINE, line, "n2", "start")


def _in_two(name: str, said: str) -> list[str]:
    """A name over two lines, with what is said of it behind the second."""
    first = wrap(name, _LONG, break_on_hyphens=False)[0]
    return [first, said.removeprefix(first).strip()]


def _paper(place: _Place, courses: Sequence[Course]) -> Iterator[Any]:
    """The two rates that the paper reports, left of the agents' points."""
    for dose, share in ((0.0, SOLVED_AT_0), (PEAK, SOLVED_AT_40)):
        if dose in place.doses:
            x, y = place.x(dose) + _at(0, len(courses)) - 16, place.y(share.value)
            yield Markup('<path class="star" d="{}"/>').format(_STAR.format(x=f"{x:.1f}", top=f"{y - 6:.1f}"))


def _text(x: float, y: float, said: str, style: str = "", anchor: str = "middle") -> Any:
    return Markup('<text class="{}" x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>').format(style, x, y, anchor, said)
