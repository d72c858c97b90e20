"""A forest plot: one row per estimate, with its interval, its name above it and its numbers at the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes

from lockprobe.figures.frame import FAINT, INK, SMALL

__all__ = ["Row", "forest"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One estimate.

    Attributes:
        name: Set above it, left.
        said: Set above it, right.
        value: None draws no mark.
        low: Lower end of its interval; None draws none.
        high: Upper end.
        colour: Of mark and bar.
        marker: Of the estimate.
        face: Inside of the marker.
    """

    name: str
    said: str
    value: float | None
    low: float | None
    high: float | None
    colour: str
    marker: str = "o"
    face: str


def forest(axes: Axes, rows: Sequence[Row], limits: tuple[float, float], *, left: float = 0.0) -> None:
    """Draw the rows, the first on top. An estimate outside the limits is an arrow at the edge.

    Args:
        axes: Where.
        rows: What.
        limits: Of the horizontal axis.
        left: Where names begin, in widths of the axes; below 0 they begin left of them.
    """
    for i, row in enumerate(rows):
        if row.low is not None and row.high is not None:
            axes.plot([row.low, row.high], [i, i], color=row.colour, linewidth=1.3, zorder=3, solid_capstyle="butt")
        if row.value is not None:
            inside = limits[0] <= row.value <= limits[1]
            axes.plot(
                [min(max(row.value, limits[0]), limits[1])],
                [i],
                linestyle="none",
                marker=row.marker if inside else "<" if row.value < limits[0] else ">",
                color=row.colour,
                markersize=4.8,
                markerfacecolor=row.face,
                markeredgewidth=0.9,
                zorder=4,
                clip_on=inside,
            )
        places = ((left, row.name, "left", INK), (1.0, row.said, "right", FAINT if row.face == "white" else INK))
        for x, text, side, colour in places:
            axes.text(
                x,
                i - 0.18,
                text,
                transform=axes.get_yaxis_transform(),
                ha=side,
                va="bottom",
                fontsize=SMALL,
                color=colour,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
                zorder=2,
            )
    axes.set_xlim(*limits)
    axes.set_ylim(len(rows) - 0.6, -0.7)
    axes.set_yticks([])
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.spines["bottom"].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)
