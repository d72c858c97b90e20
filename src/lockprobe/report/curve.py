"""The figure of the first screen: success of up to three agents by dose, named where their lines end.

Hollow and ink: the control. Filled and accent: every other dose. Marker and dash tell agents apart. It is drawn twice,
wide and narrow, so that text keeps its size on a phone; colours are those of the page, which knows light and dark.
This file says where everything stands, in pixels; ``templates/curve.html.jinja`` draws it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.terminal_text import printable
from lockprobe.report.rendering import own_markup, rendered
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.published import PEAK, SOLVED

MOST = 3
"""Lines that can be told apart and named; of more agents a list says more than a figure."""

_APART = 24
"""Least distance of two names, in pixels: a line of text."""

_BESIDE = 12
"""Distance of agents at one dose, in pixels."""

_BEYOND = 40
"""How far the axes reach beyond the first and the last dose, in pixels."""

_LONG = 28
"""Characters of a name at the end of a line."""


def drawable(found: Results) -> list[Course]:
    """The agents that the figure shows; none where there are more than it can name, or a single dose.

    Random agents are its band. Another agent that plays alike whatever it is told is a line of equal shares.
    """
    courses = found.courses(found.main_axis)
    shown = [one for one in courses if len(one.played) > 1 and one.agent not in ("random", "random-no-repeat")]
    return shown if len(shown) <= MOST else []


def curve_figure(found: Results, *, wide: bool) -> Markup:
    """The figure of at least one agent as an SVG element.

    Args:
        found: The results.
        wide: For a column of 880 pixels, with names at the ends of lines; else for 358 pixels, with names above.
    """
    courses = drawable(found)
    doses = sorted({cell.dose or 0.0 for one in courses for cell in one.played})
    left, right, top, bottom = (96, 596, 16, 360) if wide else (88, 280, 16 + _APART * len(courses), 320)
    x = [left + (dose - doses[0]) / (doses[-1] - doses[0]) * (right - left) for dose in doses]
    shift = [(i - (len(courses) - 1) / 2) * _BESIDE for i in range(len(courses))]

    def y(share: float | None) -> float:
        return bottom - (share or 0.0) * (bottom - top)

    lines: list[list[dict[str, Any]]] = [
        [
            {
                "x": x[doses.index(cell.dose or 0.0)] + beside,
                "y": y(cell.value("success")),
                "ends": None if row is None or row.low is None or row.high is None else (y(row.low), y(row.high)),
                "kind": "told" if cell.dose == doses[0] else "false",
            }
            for cell in course.played
            for row in [cell.get("success")]
        ]
        for course, beside in zip(courses, shift, strict=True)
    ]
    chance, edge = [curve.value[-1] or 0.0 for curve in found.random_play], right + _BEYOND
    ends, levels = [line[-1]["y"] for line in lines], [*map(y, chance)]
    if wide:
        heights = placed([*ends, *levels], top, bottom, _APART)
    else:
        heights = [*(_APART * (i + 0.5) for i in range(len(lines))), *placed(levels, top, bottom, _APART)]
    names = list[dict[str, Any]]()
    for course, line, height in zip(courses, lines, heights, strict=False):  # what it is called, and where that stands
        cell, name = course.played[-1], printable(" ".join(course.label.split()))
        at = "" if cell.dose == doses[-1] else f" at {cell.dose:g}"
        short = name if len(name) <= _LONG else f"{name[:_LONG]}…"
        text = f"{short} {100 * (cell.value('success') or 0.0):.0f} %{at}"
        start = line[-1]["x"] + 10 if at else right + shift[-1] + 18
        names.append({"text": text, "y": height, "from": (start, line[-1]["y"])})
    for share, level, height in zip(chance, levels, heights[len(lines) :], strict=True):
        text = f"{'chance ' * wide}{100 * share:.0f} %"
        names.append({"text": text, "y": height, "from": (edge, level)})
    paper = zip((0.0, PEAK), SOLVED, strict=True) if courses[0].axis == "flip rate" and doses[0] == 0 else ()
    values = {
        "size": (880 if wide else 358, bottom + 56),
        "wide": wide,
        "names": names,
        "edge": edge,
        "dose": courses[0].name,
        "left": left - _BEYOND,
        "shares": [(y(share), f"{100 * share:.0f}{' %' * (share == 1)}") for share in (0, 0.25, 0.5, 0.75, 1)],
        "doses": list(zip(x, map("{:g}".format, doses), strict=True))[:: max(1, -(-len(doses) // 6))],
        "bottom": bottom,
        "lines": lines,
        "band": sorted(levels),
        "stars": [(x[doses.index(dose)] + shift[0] - 16, y(one.value) - 6) for dose, one in paper if dose in doses],
    }
    return own_markup(rendered("curve", **values))


def placed(wanted: Sequence[float], low: float, high: float, apart: float) -> list[float]:
    """Heights of names near those of what they name: none closer to another than ``apart``, all within the axes.

    Neighbours that are too close become a block around their mean; blocks that meet become one.

    >>> placed([100, 104, 300], 0, 400, 24), placed([395, 396], 0, 400, 24), placed([], 0, 1, 24)
    ([90.0, 114.0, 300.0], [376.0, 400.0], [])
    """
    order = sorted(range(len(wanted)), key=lambda i: (wanted[i], i))
    blocks: list[tuple[list[int], float]] = []  # names from the top, and the height of the first
    for i in order:
        blocks.append(([i], min(max(wanted[i], low), high)))
        while len(blocks) > 1 and blocks[-1][1] < blocks[-2][1] + apart * len(blocks[-2][0]):
            (above, _), (below, _) = blocks[-2:]
            names = above + below
            tall = apart * (len(names) - 1)
            first = sum(wanted[name] for name in names) / len(names) - tall / 2
            blocks[-2:] = [(names, max(low, min(first, high - tall)))]
    found = {name: first + apart * i for names, first in blocks for i, name in enumerate(names)}
    return [float(found[i]) for i in range(len(wanted))]
