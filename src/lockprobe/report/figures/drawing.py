"""What figures are drawn with: looks of agents, axes, titles, numbers with intervals, curves, panels, and files.

Sizes are those of print: a panel is one column (3.5 inches) wide, if its figure does not say otherwise, and no text is
smaller than 9 points. What is computed without a trial is grey, dotted or dashed, without any marker. An agent has one
colour and one mark in all figures of a study, for each way in which it is shown the box; thick lines and filled markers
are agents that the study is about. Nothing here touches global state.
"""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from lockprobe.foundation.spec import spec_name
from lockprobe.report.figures import DPI, SMALL, own_settings
from lockprobe.report.rows import Cell, Course, Curve, Estimate, Player, who
from lockprobe.statistics.design import FLIPS

INK, FAINT = "#222222", "#666666"

COLOURS = ("#0072b2", "#b23c06", "#00735c", "#8c3f7d", "#5b5b00", "#332288", "#882255", "#4d4d4d")
"""All of them dark enough for text on white (a contrast of 4.5, WCAG 2.2)."""

TARGET = COLOURS[0]
"""The target joint of a box, in figures as on pages."""

MARKERS = "osD^vP<>Xphd"


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How one agent looks; ``lead`` if the study is about it."""

    colour: str
    marker: str
    lead: bool

    @property
    def line(self) -> dict[str, Any]:
        """Its line with its markers, as settings of Matplotlib."""
        return {
            "color": self.colour,
            "linestyle": "-",
            "linewidth": 1.4 if self.lead else 0.9,
            "marker": self.marker,
            "markersize": 4.8 if self.lead else 3.6,
            "markerfacecolor": self.colour if self.lead else "white",
            "markeredgewidth": 0.7,
            "zorder": 4 if self.lead else 3,
        }


def style_of(shown: Course | Cell) -> Style:
    """The look of an agent that is shown the box in one way: by its place in the study, which no two share."""
    own, players = (shown.agent, shown.modality), shown.found.design.players
    places = ((i, one.subject) for i, one in enumerate(players) if (one.agent, one.modality) == own)
    place, lead = next(places, (0, True))
    return Style(colour=COLOURS[place % len(COLOURS)], marker=MARKERS[place % len(MARKERS)], lead=lead)


BEYOND = 0.5
"""How far a curve runs on after the last step, so that its last stair can be seen."""

_DIGITS, _TICKS = 20.0, 5
"""Digits that fit between the lowest and the highest dose; parts of an axis of steps, at most."""

_WIDE = 41
"""Characters in a line above a panel."""


def counts(sizes: Iterable[int | None]) -> str:
    """How many trials are behind every number of a panel.

    >>> counts([7, 3, 5]), counts([1])
    ('n = 3 to 7 trials', 'n = 1 trial')
    """
    known = [size or 0 for size in sizes] or [0]
    said = f"{min(known)} to {max(known)}" if min(known) < max(known) else str(known[0])
    return f"n = {said} trial" + "s" * (said != "1")


def agent_label(agent: Course | Player, longest: int = 30) -> str:
    """The agent's name, safe to set, with what tells it apart from others of this name."""
    extra = f" ({agent.shown})" if agent.shown else ""
    return safe_name(shortened(who(agent.agent), max(20, longest - len(extra))) + extra)


def heading(agent: Course) -> str:
    """Its name, and whether it acted the same at every dose."""
    return agent_label(agent) + (f", the same at every {agent.name}" if agent.blind else "")


def settable(text: str) -> str:
    """The text with ``?`` for glyphs that the font lacks, and with ``$`` escaped, so that it is never a formula."""
    font = get_font(findfont(FontProperties()))
    return "".join(c if c.isprintable() and font.get_char_index(ord(c)) else "?" for c in text).replace("$", r"\$")


def safe_name(name: str, longest: int | None = None) -> str:
    """A name that is safe to set, also in a legend, which leaves out what begins with an underscore; shortened."""
    name = settable(name if longest is None else shortened(name, longest))
    return f" {name}" if name.startswith("_") else name


def shortened(name: str, longest: int) -> str:
    """A spec in so many characters: without provider and folders first, then without its end.

    >>> shortened("llm:together/meta-llama/Llama-3.3-70B-Instruct-Turbo", 32)
    '…Llama-3.3-70B-Instruct-Turbo'
    """
    if len(name) <= longest:
        return name
    head = spec_name(name)
    *_, last = re.split(r"(?<=[:/])", head)
    if last != head and len(last) < longest:
        return f"…{shortened(last + name.removeprefix(head), longest - 1)}"
    return f"{name[: longest - 1]}…"


def axis(
    axes: Axes,
    along: Literal["x", "y"],
    places: Sequence[float],
    names: Sequence[str],
    label: str = "",
    *,
    grid: bool = False,
) -> None:
    """The axis below or on the left: names at places, a label, and with ``grid`` lines across the axes.

    A tick may have an empty name.
    """
    axes.spines["bottom" if along == "x" else "left"].set_visible(True)
    axes.set(**{f"{along}ticks": places, f"{along}ticklabels": names, f"{along}label": label})
    axes.grid(visible=grid, axis=along)


def share_axis(axes: Axes, label: str, along: Literal["x", "y"] = "y", *, grid: bool = True) -> None:
    """A share from 0 to 100 %, with a tick at every quarter."""
    axes.set(**{f"{along}lim": (-0.03, 1.03)})
    axis(axes, along, [0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"], label, grid=grid)


def dose_axis(axes: Axes, cells: Sequence[Cell], name: str = FLIPS.name) -> None:
    """The horizontal axis of Figs. 4 and 5b: flip rate, or another dose, a tick at every value played.

    A tick is named where its name fits; a single value stands in the name of the axis.
    """
    values = sorted({cell.dose for cell in cells if cell.dose is not None}) or [0.0]
    first, reach = values[0], values[-1] - values[0]
    margin = 0.06 * reach or 0.1
    axes.set_xlim(first - margin, values[-1] + margin)
    if len(values) == 1:
        axis(axes, "x", [], [], f"{settable(name)} = {first:g}")
        return
    names, free = [], first
    for value in values:
        said = f"{value:g}"
        width = (len(said) - 0.5 * said.count(".") + 0.4) * reach / _DIGITS  # a point is half a digit
        names.append(said if value - width / 2 >= free or value == first else "")
        free = value + width / 2 if names[-1] else free
    axis(axes, "x", values, names, settable(name))


def whole_axis(axes: Axes, last: float, label: str) -> None:
    """The lower axis of whole numbers from 0, such as steps, with ticks at a few."""
    ticks = MaxNLocator(_TICKS, integer=True, steps=[1, 2, 5, 10]).tick_values(0, last)
    inside = [tick for tick in ticks if 0 <= tick <= last]
    axis(axes, "x", inside, [f"{tick:g}" for tick in inside], label)


def title(axes: Axes, *lines: str) -> None:
    """What the axes show, of how many trials, and what bars and bands are; long lines end between words."""
    kept = [line.replace(" %", "\N{NO-BREAK SPACE}%") for line in lines]
    said = "\n".join(piece for line in kept for piece in textwrap.wrap(line, _WIDE))
    axes.set_title(said, loc="center", x=0, ha="left")


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
    """Numbers as marks that no line joins, and their intervals as bars where both ends are known.

    ``places`` is where each stands on the other axis; with ``across`` numbers run along the horizontal one.
    """
    value, low, high = (np.array(numbers(getattr(one, end) for one in found)) for end in ("value", "low", "high"))
    x, y, ends = (value, places, "xerr") if across else (places, value, "yerr")
    reach = {ends: np.clip([value - low, high - value], 0.0, None)}
    axes.errorbar(x, y, **{**style.line, "linestyle": "none", "elinewidth": 1.2, **reach, **settings})


def by_dose(axes: Axes, cells: Iterable[Cell], quantity: str, style: Style, **settings: Any) -> None:
    """A number of each cell at its dose, like :func:`estimates`; a thin white edge keeps marks apart."""
    found = [(cell.dose or 0.0, row) for cell in cells if (row := cell.get(quantity))]
    edge: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5} if style.lead else {}
    estimates(axes, [dose for dose, _ in found], [row for _, row in found], style, **edge, **settings)


def staircase(axes: Axes, curve: Curve, style: Style, first: int, label: str) -> None:
    """A share by step, with a marker at every fourth place from ``first`` on; with its band if it leads."""
    steps = (*curve.x, curve.x[-1] + BEYOND)
    share, low, high = (numbers((*line, *line[-1:])) for line in (curve.value, curve.low, curve.high))
    axes.step(steps, share, where="post", markevery=list(range(first, len(curve.value), 4)), label=label, **style.line)
    if style.lead and low:
        axes.fill_between(steps, low, high, step="post", color=style.colour, alpha=0.15, linewidth=0, zorder=1)


def dots(axes: Axes, points: Iterable[tuple[float, float | None]], style: Style, size: float = 9.0) -> None:
    """A faint dot for every repetition; a larger one for several at the same place."""
    places = Counter((x, math.nan if y is None else y) for x, y in points)
    x, y = [x for x, _ in places], [y for _, y in places]
    sizes = [size * count for count in places.values()]
    axes.scatter(x, y, s=sizes, color=style.colour, alpha=0.5, linewidth=0, zorder=2, clip_on=False)


def published(axes: Axes, places: Sequence[tuple[float, float]]) -> None:
    """Figures that the paper's text gives: stars that hide nothing, one entry in the legend, never joined by a line."""
    hollow: dict[str, Any] = {"color": INK, "markerfacecolor": "none", "markersize": 7.5, "markeredgewidth": 0.7}
    if places:
        axes.plot(*zip(*places, strict=True), "*", label="the paper", gid="paper", clip_on=False, zorder=5, **hollow)


COLUMN = 3.5
"""Width of a panel, in inches."""

_EDGE, _BETWEEN = 0.06, 0.14
"""Room at the edges of a picture and a panel, and between rows of axes, in inches."""

_MOST = 6
"""Panels of a picture, which a page has room for; it says how many there are."""

_NOTE, _LINE = 45, 0.165
"""Characters in a line of a note, and its height in inches."""

_FONTS = b"Inter, Segoe UI, Helvetica Neue, Helvetica, Arial, DejaVu Sans, sans-serif"
"""What the texts of an SVG file are set in: as the page, in what a reader has; all are narrower than the last one."""

Shown = TypeVar("Shown")


@own_settings()
def render(figure: Figure, form: Literal["png", "svg", "pdf"]) -> bytes:
    """The picture as a file of its size; a PDF has its fonts in it. Equal figures give equal bytes."""
    out = io.BytesIO()
    options: dict[str, dict[str, Any]] = {
        "png": {"dpi": DPI, "pil_kwargs": {"compress_level": 3}},
        "svg": {"dpi": DPI, "transparent": True, "metadata": {"Date": None}},
        "pdf": {"metadata": {"CreationDate": None, "ModDate": None}},
    }
    figure.savefig(out, format=form, **options[form])
    return out.getvalue().replace(b"'DejaVu Sans'", _FONTS) if form == "svg" else out.getvalue()


@own_settings()
def sheet(
    shown: Sequence[Shown],
    draw: Callable[[Axes, Shown], None],
    *,
    height: float = 2.05,
    note: str = "",
    width: float = COLUMN,
) -> Figure | None:
    """A picture of panels, two beside each other, with one legend for all; None if there is nothing to show.

    Args:
        shown: What a panel shows each, such as the courses of agents; the first few are drawn.
        draw: Draws on a panel's axes.
        height: Of the axes, in inches.
        note: A text below all panels; above the legend, where there is one.
        width: Of a panel, in inches.
    """
    if not shown:
        return None
    note += f" The first {_MOST} of {len(shown)} are drawn." * (len(shown) > _MOST)
    shown = shown[:_MOST]
    columns, rows, note = min(2, len(shown)), -(-len(shown) // min(2, len(shown))), textwrap.fill(note, _NOTE)
    figure = Figure(figsize=(width * columns, height * rows), dpi=DPI)
    FigureCanvasAgg(figure)  # it measures texts once; without a canvas a figure makes one whenever it measures
    for panel in shown:
        draw(figure.add_axes((0, 0, 0.75 / columns, 1), xticks=[], yticks=[]), panel)
    left, below, right, above = (max(sides) for sides in zip(*map(_around, figure.axes), strict=True))
    foot, entries = _EDGE, dict[str, Artist]()
    for axes in figure.axes:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    if entries:
        spaces = {"columnspacing": 1.2, "handlelength": 2.6, "labelspacing": 0.35, "borderpad": 0.2}
        for columns_below in range(4, 0, -1):  # as many as there is room for
            legend = figure.legend(
                entries.values(), entries.keys(), ncols=columns_below, loc="lower center", title=note,
                borderaxespad=0.2, **spaces,
            )  # fmt: skip
            if legend.get_window_extent().width < min(figure.bbox.width, COLUMN * DPI) or columns_below == 1:
                break
            legend.remove()
        legend.get_title().set(color=FAINT, fontsize=SMALL)
        foot += legend.get_window_extent().height / DPI
    elif note:
        figure.supxlabel(note, y=0.0, va="bottom", fontsize=SMALL, color=FAINT)
        foot += _LINE * (note.count("\n") + 1)
    row, wide = below + height + above + _BETWEEN, width * columns
    whole = foot + rows * row - _BETWEEN + _EDGE
    figure.set_figheight(whole)
    for i, axes in enumerate(figure.axes):
        corner = (i % columns * width + left + _EDGE) / wide, (foot + below + (rows - 1 - i // columns) * row) / whole
        axes.set_position((*corner, (width - left - right - 2 * _EDGE) / wide, height / whole))
    return figure


def _around(axes: Axes) -> tuple[float, float, float, float]:
    """How far texts reach out of axes: left, below, right, above, in inches; a title may be as wide as it is."""
    box, own = axes.bbox, (one.get_tightbbox() for one in (axes.xaxis, axes.yaxis))
    taken = Bbox.union([box, *filter(None, own), *(text.get_window_extent() for text in axes.texts)])
    above = max(taken.y1, axes.title.get_window_extent().y1 if axes.get_title() else box.y1)
    return (box.x0 - taken.x0) / DPI, (box.y0 - taken.y0) / DPI, (taken.x1 - box.x1) / DPI, (above - box.y1) / DPI
