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
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from PIL import Image

from lockprobe.report.figures.settings import FAINT, INK, SMALL, own_settings

COLUMN = 3.5
"""Width of a panel in inches."""

HEIGHT = 2.9
"""Height of a panel in inches."""

CELLS = "cells"
"""Keyword of a picture whose colours a dark page keeps."""

_CHARACTER, _LINE = 0.077, 0.165
"""Width of a character of the small text and height of a line, in inches, generously."""

_DPI = 200
"""Pixels per inch of what is laid out and of PNG files."""

_COMPRESSION = 3
"""Of PNG files: a third less time than the usual 6, for 6 % more bytes."""

Shown = TypeVar("Shown")


@own_settings()
def render(figure: Figure, form: Literal["png", "svg"]) -> bytes:
    """The picture as a file. Equal figures give equal bytes. It is laid out once, for the first form asked for."""
    out = io.BytesIO()
    engine = figure.get_layout_engine()
    if engine:
        _place_empty_labels(figure)
        figure.set_dpi(_DPI)
        engine.execute(figure)
        figure.set_layout_engine(None)  # with one, every file is drawn twice
    own: dict[str, Any] = {"metadata": {"Date": None}}
    if form == "svg" and figure.get_label() == CELLS:
        own["metadata"]["Keywords"] = [CELLS]
    if form == "png":
        return _png(figure)
    figure.savefig(out, format=form, dpi=_DPI, **own)
    return out.getvalue()


def _png(figure: Figure) -> bytes:
    """A picture without transparency, which Matplotlib would write too: a tenth of the bytes and of the time."""
    figure.set_dpi(_DPI)
    canvas: Any = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    canvas.draw()
    size, out = canvas.get_width_height(physical=True), io.BytesIO()
    image = Image.frombytes("RGB", size, canvas.buffer_rgba(), "raw", "RGBX")
    image.save(out, "PNG", compress_level=_COMPRESSION, dpi=(_DPI, _DPI))
    return out.getvalue()


def _place_empty_labels(figure: Figure) -> None:
    """Give axes without a label a place for it; else Matplotlib measures all numbers of an axis to find it one."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if not axis.get_label_text():
                axis.set_label_coords(0.0, 0.0)


@own_settings()
def pages_as_pdf(figures: Sequence[Figure]) -> bytes:
    """Figures as the pages of a PDF at their size, with their fonts in it. Equal figures give equal bytes."""
    from matplotlib.backends.backend_pdf import PdfPages  # with its library of fonts, which no page needs

    out = io.BytesIO()
    with PdfPages(out, metadata={"CreationDate": None, "ModDate": None}) as pages:
        for figure in figures:
            pages.savefig(figure)
    return out.getvalue()


def files(figure: Figure | None) -> dict[str, bytes]:
    """The picture as PNG and as SVG; nothing where nothing is drawn."""
    return {"png": render(figure, "png"), "svg": render(figure, "svg")} if figure else {}


@own_settings()
def sheet(
    shown: Sequence[Shown],
    *draws: Callable[[Axes, Shown], None],
    heights: Sequence[float] = (),
    around: float = 0.0,
    note: str = "",
    columns: int = 2,
    width: float = COLUMN,
    cells: bool = False,
) -> Figure | None:
    """A picture of panels beside and below each other, with one legend for all; None if there is nothing to show.

    Args:
        shown: What a panel shows each, such as the courses of agents.
        draws: What draws on a panel's axes, from the top.
        heights: Their heights in inches, the same for all panels; or that of every row of axes.
        around: What stands around axes is so high, in inches; the heights are then those of the axes alone.
        note: A text below all panels; above the legend, where there is one.
        columns: Panels beside each other, at most.
        width: Of a panel, in inches.
        cells: Whether text stands on coloured cells, so that the colours of a page must not change them.
    """
    if not shown:
        return None
    columns, bands = min(columns, len(shown)), -(-len(shown) // columns)
    ratios = [*(heights or [HEIGHT] * len(draws))]
    ratios *= bands * len(draws) // len(ratios)
    layout = ConstrainedLayoutEngine(w_pad=0.06, wspace=0.04)
    figure = Figure(figsize=(width * columns, sum(ratios) + around * len(ratios)), layout=layout)
    figure.set_label(CELLS if cells else "")
    FigureCanvasAgg(figure)  # it measures texts once; without a canvas a figure makes one whenever it measures
    grid = figure.subplots(len(ratios), columns, squeeze=False, height_ratios=ratios)
    for i in range(columns * bands):
        for j, draw in enumerate(draws):
            axes = grid[i // columns * len(draws) + j, i % columns]
            axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)
            if i < len(shown):
                draw(axes, shown[i])
            else:
                axes.set_visible(False)
    lines = textwrap.wrap(note, int(COLUMN / _CHARACTER))
    if not _legend(figure, "\n".join(lines)) and lines:
        figure.supxlabel("\n".join(lines), fontsize=SMALL, color=FAINT)
        figure.set_figheight(figure.get_figheight() + _LINE * len(lines))
    return figure


def _legend(figure: Figure, note: str) -> Legend | None:
    """Every name once, below the axes and a note; None without a name."""
    entries: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if not entries:
        return None
    spaces = {"columnspacing": 1.2, "handlelength": 2.6, "labelspacing": 0.35, "borderpad": 0.2}
    head: dict[str, Any] = {"title": note, "title_fontproperties": {"size": SMALL}} if note else {}
    legend = legend_below(figure, entries, 4, loc="outside lower center", **spaces, **head)
    legend.get_title().set_color(FAINT)
    figure.set_figheight(figure.get_figheight() + legend.get_window_extent().height / figure.dpi)
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
