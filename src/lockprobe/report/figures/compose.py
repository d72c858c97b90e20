"""Whole pictures made of axes, and files made of pictures. Nothing here touches global state."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeVar

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from PIL import Image

from lockprobe.report.figures.settings import DPI, FAINT, SMALL, own_settings

COLUMN = 3.5
"""Width of a panel in inches."""

HEIGHT = 2.05
"""Height of its axes in inches."""

CELLS = "cells"
"""Keyword of a picture whose colours a dark page keeps."""

_EDGE, _BETWEEN = 0.06, 0.14
"""Room at the edges of a picture and a panel, and between rows of axes, in inches."""

_WITHIN, _NEAR = 0.75, 0.5 * DPI
"""Part of a panel that its axes take, about, before it is laid out; pixels from their side at which texts may reach
out."""

_CHARACTER, _LINE = 0.077, 0.165
"""Width of a character of the small text and height of a line, in inches, generously."""

_COMPRESSION = 3
"""Of PNG files: a third less time than the usual 6, for 6 % more bytes."""

Shown = TypeVar("Shown")


@own_settings()
def render(figure: Figure, form: Literal["png", "svg"]) -> bytes:
    """The picture as a file. Equal figures give equal bytes.

    A PNG has no transparency, which Matplotlib would write too: a tenth of the bytes and of the time.
    """
    out = io.BytesIO()
    if form == "svg":
        keywords = {"Keywords": [CELLS]} if figure.get_label() == CELLS else {}
        figure.savefig(out, format="svg", dpi=DPI, metadata={"Date": None, **keywords})
        return out.getvalue()
    figure.set_dpi(DPI)
    canvas: Any = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.frombytes("RGB", canvas.get_width_height(physical=True), canvas.buffer_rgba(), "raw", "RGBX")
    image.save(out, "PNG", compress_level=_COMPRESSION, dpi=(DPI, DPI))
    return out.getvalue()


@own_settings()
def pages_as_pdf(figures: Sequence[Figure]) -> bytes:
    """Figures as the pages of a PDF at their size, with their fonts in it. Equal figures give equal bytes."""
    from matplotlib.backends.backend_pdf import PdfPages  # with its library of fonts, which no page needs

    out = io.BytesIO()
    with PdfPages(out, metadata={"CreationDate": None, "ModDate": None}) as pages:
        for figure in figures:
            pages.savefig(figure)
    return out.getvalue()


@own_settings()
def sheet(
    shown: Sequence[Shown],
    *draws: Callable[[Axes, Shown], None],
    heights: Sequence[float] = (),
    note: str = "",
    width: float = COLUMN,
    cells: bool = False,
) -> Figure | None:
    """A picture of panels, two beside each other, with one legend for all; None if there is nothing to show.

    Args:
        shown: What a panel shows each, such as the courses of agents.
        draws: What draws on a panel's axes, from the top.
        heights: Heights of these axes in inches, the same for all panels; or that of every row of axes.
        note: A text below all panels; above the legend, where there is one.
        width: Of a panel, in inches.
        cells: Whether text stands on coloured cells, so that the colours of a page must not change them.
    """
    if not shown:
        return None
    columns = min(2, len(shown))
    bands = -(-len(shown) // columns)
    high = [*(heights or [HEIGHT] * len(draws))]
    high *= bands * len(draws) // len(high)
    figure = Figure(figsize=(width * columns, sum(high)), dpi=DPI, label=CELLS if cells else "")
    FigureCanvasAgg(figure)  # it measures texts once; without a canvas a figure makes one whenever it measures
    rows: list[list[Axes]] = [[] for _ in high]
    for i, panel in enumerate(shown):
        for j, draw in enumerate(draws):
            axes = figure.add_axes((0, 0, _WITHIN / columns, 1))
            axes.set_axis_off()
            draw(axes, panel)
            rows[i // columns * len(draws) + j].append(axes)
    _lay_out(figure, rows, high, width, "\n".join(textwrap.wrap(note, int(COLUMN / _CHARACTER))))
    return figure


def _lay_out(figure: Figure, rows: Sequence[Sequence[Axes]], high: Sequence[float], width: float, note: str) -> None:
    """Give every row of axes its height, and what stands around and below them the room that it takes."""
    around = [[_around(axes) for axes in row] for row in rows]
    left, right = (max(one[side] for row in around for one in row) + _EDGE for side in (0, 2))
    legend, foot = _legend(figure, note), _EDGE
    if legend:
        foot += legend.get_window_extent().height / DPI
    elif note:
        figure.supxlabel(note, y=0.0, va="bottom", fontsize=SMALL, color=FAINT)
        foot += _LINE * (note.count("\n") + 1)
    bottoms, y = list[float](), foot
    for reach, tall in zip(reversed(around), reversed(high), strict=True):
        bottoms.append(y + max(one[1] for one in reach))
        y = bottoms[-1] + tall + max(one[3] for one in reach) + _BETWEEN
    wide, whole = figure.get_figwidth(), y - _BETWEEN + _EDGE
    figure.set_figheight(whole)
    for row, bottom, tall in zip(rows, reversed(bottoms), high, strict=True):
        for i, axes in enumerate(row):
            axes.set_position(((i * width + left) / wide, bottom / whole, (width - left - right) / wide, tall / whole))


def _around(axes: Axes) -> tuple[float, float, float, float]:
    """How far texts reach out of axes: left, below, right, above, in inches; a title may be as wide as it is."""
    box, reach = axes.bbox, [0.0] * 4
    for text in axes.texts:
        x, y = text.get_transform().transform(text.get_position())
        if not (box.x0 + _NEAR < x < box.x1 - _NEAR and box.y0 < y < box.y1):
            taken = text.get_window_extent()
            beyond = [box.x0 - taken.x0, box.y0 - taken.y0, taken.x1 - box.x1, taken.y1 - box.y1]
            reach = [max(pair) for pair in zip(reach, [0, 0, 0, beyond[3]] if y > box.y1 else beyond, strict=True)]
    left, below, right, above = (float(one) / DPI for one in reach)
    return left, below, right, above


def _legend(figure: Figure, note: str) -> Legend | None:
    """Every name once, below the axes and a note; None without a name."""
    entries: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if not entries:
        return None
    spaces = {"columnspacing": 1.2, "handlelength": 2.6, "labelspacing": 0.35, "borderpad": 0.2, "borderaxespad": 0.2}
    head: dict[str, Any] = {"title": note, "title_fontproperties": {"size": SMALL}} if note else {}
    legend = legend_below(figure, entries, 4, loc="lower center", **spaces, **head)
    legend.get_title().set_color(FAINT)
    return legend


def legend_below(figure: Figure, entries: Mapping[str, Artist], most: int, **settings: Any) -> Legend:
    """A legend in as many columns as a panel has room for, and at most ``most``."""
    room = min(figure.bbox.width, COLUMN * figure.dpi)
    for columns in range(most, 0, -1):
        legend = figure.legend(entries.values(), entries.keys(), ncols=columns, **settings)
        if legend.get_window_extent().width < room or columns == 1:
            break
        legend.remove()
    return legend
