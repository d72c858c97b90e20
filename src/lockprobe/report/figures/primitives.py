"""What is drawn on the axes of more than one figure: numbers with their intervals, curves, dots of repetitions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from lockprobe.report.figures.frame import BEYOND
from lockprobe.report.figures.palette import Style
from lockprobe.report.figures.settings import INK
from lockprobe.report.rows import Cell, Curve, Estimate
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.published import PEAK


def numbers(values: Iterable[float | None]) -> list[float]:
    """Numbers of results, where null is none."""
    return [math.nan if value is None else value for value in values]


def estimates(
    axes: Axes,
    places: Sequence[float],
    found: Sequence[Estimate],
    style: Style,
    *,
    across: bool = False,
    **settings: Any,
) -> None:
    """Draw numbers as marks that no line joins, and their intervals as bars where both ends are known.

    Args:
        axes: Where.
        places: Where each stands on the other axis.
        found: The numbers.
        style: How.
        across: Whether the numbers run along the horizontal axis instead of the vertical one.
        settings: Further ones of ``Axes.errorbar``.
    """
    value, low, high = (np.array(numbers(getattr(one, end) for one in found)) for end in ("value", "low", "high"))
    x, y, ends = (value, places, "xerr") if across else (places, value, "yerr")
    reach = {ends: np.clip([value - low, high - value], 0.0, None)}
    axes.errorbar(x, y, **{**style.line, "linestyle": "none", "elinewidth": 1.2, **reach, **settings})


def by_dose(axes: Axes, cells: Iterable[Cell], quantity: str, style: Style, **settings: Any) -> None:
    """Draw a number of each cell at its dose, where it has one, like :func:`estimates`.

    A thin white edge keeps filled marks apart, however near to each other the doses are.
    """
    found = [(cell.dose or 0.0, row) for cell in cells if (row := cell.get(quantity))]
    edge: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5} if style.lead else {}
    estimates(axes, [dose for dose, _ in found], [row for _, row in found], style, **edge, **settings)


def staircase(axes: Axes, share: Sequence[float | None], style: Style, first: int) -> None:
    """A share by step from 0; the last stair is drawn a little beyond the budget, so that it can be seen.

    Every fourth step has a marker, from ``first`` on.
    """
    markers = list(range(first, len(share), 4))
    axes.step(_steps(share), _longer(share), where="post", markevery=markers, **style.line)


def band(axes: Axes, low: Sequence[float | None], high: Sequence[float | None], style: Style) -> None:
    """The band about a staircase."""
    _shade(axes, _steps(low), _longer(low), _longer(high), style, step="post")


def curve_with_band(axes: Axes, curve: Curve, style: Style) -> None:
    """A curve, and its band where it has one."""
    axes.plot(curve.x, numbers(curve.value), **{**style.line, "marker": "", "zorder": 3})
    if curve.low:
        _shade(axes, curve.x, numbers(curve.low), numbers(curve.high), style)


def _shade(
    axes: Axes, x: Sequence[float], low: Sequence[float], high: Sequence[float], style: Style, **how: Any
) -> None:
    axes.fill_between(x, low, high, color=style.colour, alpha=0.15, linewidth=0, zorder=1, **how)


def _steps(share: Sequence[float | None]) -> tuple[float, ...]:
    return (*range(len(share)), len(share) - 1 + BEYOND)


def _longer(share: Sequence[float | None]) -> list[float]:
    return numbers((*share, share[-1]))


def dots(axes: Axes, points: Iterable[tuple[float, float | None]], style: Style, size: float = 9.0) -> None:
    """A faint dot for every repetition; a larger one for several at the same place."""
    places = Counter((x, math.nan if y is None else y) for x, y in points)
    sizes = [size * count for count in places.values()]
    x, y = [x for x, _ in places], [y for _, y in places]
    axes.scatter(x, y, s=sizes, color=style.colour, alpha=0.5, linewidth=0, zorder=2, clip_on=False)


def published(axes: Axes, places: Sequence[tuple[float, float]]) -> None:
    """Figures that the paper's text gives: stars that hide nothing, one entry in the legend, never joined by a line."""
    hollow: dict[str, Any] = {"color": INK, "markerfacecolor": "none", "markersize": 7.5, "markeredgewidth": 0.7}
    if places:
        axes.plot(*zip(*places, strict=True), "*", label="the paper", gid="paper", clip_on=False, zorder=5, **hollow)


def published_by_p(cells: Sequence[Cell], first: Proportion, peak: Proportion) -> list[tuple[float, float]]:
    """The paper's shares at p = 0 and at its peak, as far as the study has that p; none with a single p."""
    played = {cell.p for cell in cells if cell.p is not None}
    places = [(0.0, first.value), (PEAK, peak.value)]
    return [place for place in places if len(played) > 1 and min(played) <= place[0] <= max(played)]
