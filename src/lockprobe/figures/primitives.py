"""What is drawn on the axes of more than one figure: staircases, shares with bars, dots of repetitions, bands."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.published import PEAK
from lockprobe.figures.frame import BEYOND, INK
from lockprobe.figures.palette import Style
from lockprobe.rows import Cell, Course, Curve, Estimate

__all__ = [
    "band",
    "bars",
    "dots",
    "key",
    "means",
    "numbers",
    "published",
    "published_by_p",
    "second_order_fit",
    "staircase",
]


def staircase(
    axes: Axes, share: Sequence[float | None], style: Style, *, label: str | None = None, first: int = 2
) -> None:
    """A share by step from 0; the last stair is drawn a little beyond the budget, so that it can be seen.

    Args:
        axes: Where.
        share: By step 0, 1, ... up to the budget.
        style: How; an empty marker draws none.
        label: Its name in the legend.
        first: The step of the first marker; from there on every fourth has one.
    """
    axes.step(
        _steps(share),
        _longer(share),
        where="post",
        color=style.colour,
        linestyle=style.dash,
        linewidth=1.6 if style.lead else 0.9,
        marker=style.marker,
        markersize=4.2 if style.lead else 3.6,
        markerfacecolor=style.face,
        markeredgewidth=0.7,
        markevery=list(range(first, len(share), 4)),
        zorder=4 if style.lead else 3,
        label=label,
    )


def band(
    axes: Axes, low: Sequence[float | None], high: Sequence[float | None], style: Style, alpha: float = 0.16
) -> None:
    """The band about a staircase."""
    axes.fill_between(
        _steps(low), _longer(low), _longer(high), step="post", color=style.colour, alpha=alpha, linewidth=0, zorder=1
    )


def means(axes: Axes, x: Sequence[float], shares: Sequence[Estimate], style: Style, *, line: bool) -> None:
    """Pooled shares, joined by a line or not."""
    axes.plot(
        x,
        numbers(share.value for share in shares),
        color=style.colour,
        marker=style.marker,
        markersize=5.0 if style.lead else 3.6,
        markerfacecolor=style.face,
        markeredgecolor="white" if style.lead else style.colour,
        markeredgewidth=0.7,
        linestyle=style.dash if line else "none",
        linewidth=1.2 if style.lead else 0.8,
        zorder=4 if style.lead else 3,
    )


def bars(axes: Axes, x: Sequence[float], shares: Sequence[Estimate], style: Style, *, label: str | None = None) -> None:
    """Pooled shares with their intervals."""
    low, value, high = (numbers(getattr(share, end) for share in shares) for end in ("low", "value", "high"))
    axes.errorbar(
        x,
        value,
        yerr=[[b - a for a, b in zip(low, value, strict=True)], [b - a for a, b in zip(value, high, strict=True)]],
        fmt="",
        marker=style.marker,
        linestyle="none",
        color=style.colour,
        markersize=5.0,
        markeredgecolor="white",
        markeredgewidth=0.7,
        elinewidth=1.2,
        capsize=0,
        zorder=4,
        label=label,
    )


def dots(axes: Axes, course: Course, style: Style, shift: float = 0.0, *, loops: bool = False) -> None:
    """A faint dot for every repetition; a larger one for several at the same place."""
    points = [numbers((cell.dose, pair[loops].value)) for cell in course.cells for pair in cell.points]
    places = Counter((dose, value) for dose, value in points)
    axes.scatter(
        [p + shift for p, _ in places],
        [value for _, value in places],
        s=[9 * count for count in places.values()],
        color=style.colour,
        alpha=0.45,
        linewidth=0,
        zorder=2,
    )


def published(axes: Axes, places: Sequence[tuple[float, float]], label: str = "the paper") -> None:
    """Figures that the paper's text gives: stars that hide nothing, one entry in the legend, never joined by a line."""
    if places:
        axes.plot(
            [x for x, _ in places],
            [y for _, y in places],
            color=INK,
            marker="*",
            markersize=7.5,
            markerfacecolor="none",
            markeredgewidth=0.7,
            linestyle="none",
            zorder=5,
            label=label,
            gid="paper",
            clip_on=False,
        )


def key(axes: Axes, style: Style, label: str) -> None:
    """An entry of the legend: the style's line and marker."""
    axes.plot(
        [],
        [],
        color=style.colour,
        linestyle=style.dash,
        marker=style.marker,
        markersize=4.2 if style.lead else 3.6,
        markerfacecolor=style.face,
        markeredgewidth=0.7,
        linewidth=1.6 if style.lead else 0.9,
        label=label,
    )


def numbers(values: Iterable[float | None]) -> list[float]:
    """Numbers of results, where null is none."""
    return [math.nan if value is None else value for value in values]


def _steps(share: Sequence[float | None]) -> tuple[float, ...]:
    return (*range(len(share)), len(share) - 1 + BEYOND)


def _longer(share: Sequence[float | None]) -> list[float]:
    return numbers((*share, share[-1]))


def published_by_p(cells: Sequence[Cell], first: Proportion, peak: Proportion) -> list[tuple[float, float]]:
    """The paper's shares at p = 0 and at its peak, as far as the study has that p; none with a single p."""
    played = {cell.p for cell in cells if cell.p is not None}
    places = [(0.0, first.value), (PEAK, peak.value)]
    return [place for place in places if len(played) > 1 and min(played) <= place[0] <= max(played)]


def second_order_fit(axes: Axes, curve: Curve | None, style: Style) -> str:
    """The second-order fit with its band, where there is one; what was drawn, in words."""
    if curve is None:
        return ""
    axes.plot(curve.x, numbers(curve.value), color=style.colour, linestyle=style.dash, linewidth=1.6, zorder=3)
    if not curve.low:
        return "curve: second-order fit"
    low, high = numbers(curve.low), numbers(curve.high)
    axes.fill_between(curve.x, low, high, color=style.colour, alpha=0.14, linewidth=0, zorder=1)
    return "curve: second-order fit with 95 % bootstrap band"
