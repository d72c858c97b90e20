"""Whole pictures made of axes, and files made of pictures. Nothing here touches global state."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable, Sequence
from typing import Literal, TypeVar

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lockprobe.figures.frame import FAINT, SMALL
from lockprobe.figures.settings import own_settings

__all__ = ["COLUMN", "HEIGHT", "files", "render", "sheet"]

COLUMN = 3.5
"""Width of a panel in inches."""

HEIGHT = 2.9
"""Height of a panel in inches."""

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
        figure.set_dpi(_DPI)
        engine.execute(figure)
        figure.set_layout_engine(None)  # with one, every file is drawn twice
    if form == "svg":
        figure.savefig(out, format=form, dpi=_DPI, metadata={"Date": None})
    else:
        pixels = {"compress_level": _COMPRESSION}
        figure.savefig(out, format=form, dpi=_DPI, metadata={"Software": None}, pil_kwargs=pixels)
    return out.getvalue()


def files(figure: Figure) -> dict[str, bytes]:
    """The picture as PNG and as SVG."""
    return {"png": render(figure, "png"), "svg": render(figure, "svg")}


@own_settings()
def sheet(
    shown: Sequence[Shown],
    *draws: Callable[[Axes, Shown], None],
    heights: Sequence[float] = (),
    note: str = "",
) -> Figure:
    """A picture of panels in two columns at most, with one legend for all.

    Args:
        shown: What a panel shows each, such as the courses of agents; at least one.
        draws: What draws on a panel's axes, from the top.
        heights: Their heights in inches.
        note: A text below all.
    """
    columns, bands = min(2, len(shown)), -(-len(shown) // 2)
    ratios = [*(heights or [HEIGHT] * len(draws))] * bands
    figure = Figure(figsize=(COLUMN * columns, sum(ratios)), layout=ConstrainedLayoutEngine(w_pad=0.06, wspace=0.04))
    grid = figure.subplots(len(ratios), columns, squeeze=False, height_ratios=ratios)
    for i in range(columns * bands):
        for j, draw in enumerate(draws):
            axes = grid[i // 2 * len(draws) + j, i % 2]
            if i < len(shown):
                draw(axes, shown[i])
            else:
                axes.set_visible(False)
    if note:
        lines = textwrap.wrap(note, int(COLUMN * columns / _CHARACTER))
        figure.supxlabel("\n".join(lines), fontsize=SMALL, color=FAINT)
        figure.set_figheight(figure.get_figheight() + _LINE * len(lines))
    _legend(figure)
    return figure


def _legend(figure: Figure) -> None:
    """Every name once, below the axes, in as many columns as there is room for."""
    entries: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if not entries:
        return
    for columns in (4, 3, 2, 1):
        legend = figure.legend(
            entries.values(),
            entries.keys(),
            loc="outside lower center",
            ncols=columns,
            frameon=False,
            fontsize=SMALL,
            columnspacing=1.2,
            handlelength=2.6,
            labelspacing=0.35,
            borderpad=0.2,
        )
        size = legend.get_window_extent()
        if size.width < figure.bbox.width or columns == 1:
            figure.set_figheight(figure.get_figheight() + size.height / figure.dpi)
            return
        legend.remove()
