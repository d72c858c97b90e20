"""What figures are drawn with: looks of agents, axes, titles, numbers with intervals, curves, panels, and files.

Sizes are those of print: a panel is one column (3.5 inches) wide and no text is smaller than 9 points. What is computed
without a trial is grey, dotted or dashed, without any marker. An agent has one colour and one mark in all figures of a
study, and a dash for each way to see the box; thick lines and filled markers are agents that the study is about.
Nothing here touches global state.
"""

from __future__ import annotations

from lockprobe.report.figures.settings import DPI, SMALL, own_settings  # isort: skip - it imports Matplotlib
from lockprobe.report.figures import settings  # isort: skip

import io
import math
import re
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Transform, offset_copy
from PIL import Image

from lockprobe.foundation.spec import spec_name
from lockprobe.report.labels import placed
from lockprobe.report.prose import who
from lockprobe.report.rows import Cell, Course, Curve, Estimate
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.published import PEAK

INK, FAINT = settings.INK, settings.FAINT

Dash = str | tuple[int, tuple[float, ...]]

COLOURS = ("#0072b2", "#b23c06", "#00735c", "#8c3f7d", "#5b5b00", "#332288", "#882255", "#4d4d4d")
"""All of them dark enough for text on white (a contrast of 4.5, WCAG 2.2)."""

TARGET, ACCENT = COLOURS[:2]
"""The target joint of a box, in figures as on pages; what is apart where one agent is shown by itself."""

MARKERS = "osD^vP<>Xphd"

DASHES: tuple[Dash, ...] = ("-", (0, (5, 1.5)), (0, (4, 1.2, 1, 1.2)), (0, (1, 1.2)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How one agent looks; ``lead`` if the study is about it. An empty marker draws none."""

    colour: str
    marker: str = "o"
    dash: Dash = "-"
    lead: bool = True

    @property
    def line(self) -> dict[str, Any]:
        """Its line with its markers, as settings of Matplotlib."""
        return {
            "color": self.colour,
            "linestyle": self.dash,
            "linewidth": 1.4 if self.lead else 0.9,
            "marker": self.marker,
            "markersize": 4.8 if self.lead else 3.6,
            "markerfacecolor": self.colour if self.lead else "white",
            "markeredgewidth": 0.7,
            "zorder": 4 if self.lead else 3,
        }


def style_of(course: Course) -> Style:
    """The look of an agent: by its place among those of the study, so no two share colour and mark.

    The dash is that of the way in which it is shown the box.
    """
    players = course.found.design.players
    agents = list(dict.fromkeys(one.agent for one in players))
    ways = [one.modality for one in players if one.agent == course.agent]
    place = agents.index(course.agent) if course.agent in agents else 0
    way = ways.index(course.modality) if course.modality in ways else 0
    return Style(
        colour=COLOURS[place % len(COLOURS)],
        marker=MARKERS[place % len(MARKERS)],
        dash=DASHES[way % len(DASHES)],
        lead=course.subject,
    )


def lighter(colour: str, white: float) -> str:
    """The colour with so much white in it, from 0 to 1."""
    red, green, blue = (part + white * (1 - part) for part in mpl.colors.to_rgb(colour))
    return mpl.colors.to_hex((red, green, blue))


BEYOND = 0.5
"""How far a curve runs on after the last step, so that its last stair can be seen."""

_GAP, _BESIDE = 0.085, 0.02
"""In axes heights: least distance of names at the right edge; up to which a name needs no line that leads to it."""

_DIGITS, _TICKS = 20.0, 5
"""Digits that fit between the lowest and the highest dose; parts of an axis of steps, at most."""

_WIDE = 41
"""Characters in a line above a panel."""

_POINTS, _HIGH, _ABOVE, _BEHIND = 5, 12, 5, 12
"""Points between axes and the names of ticks, and between these and a label; of a line of names; up to a title; to
names at the right edge."""


def counts(sizes: Iterable[int | None]) -> str:
    """How many trials are behind every number of a panel.

    >>> counts([7, 3, 5]), counts([1])
    ('n = 3 to 7 trials', 'n = 1 trial')
    """
    known = [size or 0 for size in sizes] or [0]
    said = f"{min(known)} to {max(known)}" if min(known) < max(known) else str(known[0])
    return f"n = {said} trial" + "s" * (said != "1")


def agent_label(agent: Course, longest: int = 30) -> str:
    """The agent's name, safe to set, with what tells it apart from others of this name."""
    extra = f" ({agent.shown})" if agent.shown else ""
    return safe_name(shortened(who(agent.agent), max(15, longest - len(extra))) + extra)


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
    bare: bool = False,
) -> None:
    """The axis below or on the left: names at places, a label, and with ``grid`` lines across the axes.

    A tick may have an empty name; with ``bare`` names stand there without line and ticks. Matplotlib's own axis takes
    twice as long: it has five parts for every tick, and measures all of them several times.
    """
    below = along == "x"
    across = axes.get_xaxis_transform() if below else axes.get_yaxis_transform()
    line: dict[str, Any] = {"color": "#888888", "linewidth": 0.7, "clip_on": False, "label": "_axis"}
    if grid:
        faint: dict[str, Any] = {"color": "#e6e6e6", "linewidth": 0.6, "zorder": 0.5, "label": "_axis"}
        ends = [[(at, 0), (at, 1)] if below else [(0, at), (1, at)] for at in places]
        axes.add_artist(LineCollection(ends, transform=across, **faint))
    if not bare:
        whole, ticks = ([0, 1], [0, 0]), (places, [0] * len(places))
        axes.add_artist(Line2D(*(whole if below else whole[::-1]), transform=axes.transAxes, **line))
        mark = {"marker": TICKDOWN if below else TICKLEFT, "markersize": 3, "markeredgewidth": 0.7, "linestyle": "none"}
        axes.add_artist(Line2D(*(ticks if below else ticks[::-1]), transform=across, **line | mark))
    side: dict[str, Any] = {"ha": "center", "va": "top"} if below else {"ha": "right", "va": "center"}
    beside = _offset(axes, across, y=-_POINTS) if below else _offset(axes, across, x=-_POINTS)
    made = [
        axes.text(*((place, 0.0) if below else (0.0, place)), name, transform=beside, **side)
        for place, name in zip(places, names, strict=True)
        if name
    ]
    if label and below:
        deep = max((name.count("\n") + 1 for name in names if name), default=0)
        axes.text(0.5, 0, label, transform=_offset(axes, axes.transAxes, y=-_POINTS - 1 - _HIGH * deep), **side)
    elif label:
        widest = max(made, key=lambda text: len(text.get_text()))
        away = widest.get_window_extent().width * 72 / DPI + 2 * _POINTS
        axes.text(0, 0.5, label, transform=_offset(axes, axes.transAxes, x=-away), rotation=90, **side)


def _offset(axes: Axes, place: Transform, **points: float) -> Transform:
    """A place and so many points beside it, along ``x`` or ``y``."""
    return offset_copy(place, axes.get_figure(root=True), units="points", **points)


def share_axis(axes: Axes, label: str, along: Literal["x", "y"] = "y", *, grid: bool = True) -> None:
    """A share from 0 to 100 %, with a tick at every quarter."""
    axes.set(**{f"{along}lim": (-0.03, 1.03)})
    axis(axes, along, [0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"], label, grid=grid)


def dose_axis(axes: Axes, cells: Sequence[Cell], name: str = FLIPS.name, *, label: str | None = None) -> None:
    """The horizontal axis of Figs. 4 and 5b: flip rate, or another dose, a tick at every value played.

    A tick is named where its name fits; a single value stands in the name of the axis. With a ``label`` there is that
    in place of an axis.
    """
    values = sorted({cell.dose for cell in cells if cell.dose is not None}) or [0.0]
    first, reach = values[0], values[-1] - values[0]
    margin = 0.06 * reach or 0.1
    axes.set_xlim(first - margin, values[-1] + margin)
    if label is not None:
        axis(axes, "x", [], [], label, bare=True)
        return
    if len(values) == 1:
        axis(axes, "x", [], [], f"{axis_label(name)} = {first:g}")
        return
    names, free = [], first
    for value in values:
        said = f"{value:g}"
        width = (len(said) - 0.5 * said.count(".") + 0.4) * reach / _DIGITS  # a point is half a digit
        names.append(said if value - width / 2 >= free or value == first else "")
        free = value + width / 2 if names[-1] else free
    axis(axes, "x", values, names, axis_label(name))


def axis_label(name: str) -> str:
    """What stands below the axis; a flip rate has the letter of the paper."""
    return f"{name} $p$" if name == FLIPS.name else name.replace("$", r"\$")


def whole_axis(axes: Axes, last: float, label: str) -> None:
    """The lower axis of whole numbers from 0, such as steps, with ticks at a few."""
    ticks = MaxNLocator(_TICKS, integer=True, steps=[1, 2, 5, 10]).tick_values(0, last)
    inside = [tick for tick in ticks if 0 <= tick <= last]
    axis(axes, "x", inside, [f"{tick:g}" for tick in inside], label)


def chance_band(axes: Axes, levels: Sequence[float]) -> None:
    """A grey band between the exact success of random agents with and without immediate repeats."""
    if levels:
        axes.axhspan(min(levels), max(levels), color=FAINT, alpha=0.18, linewidth=0, zorder=0)
        axes.text(
            0.98, max(levels), "random play", color=FAINT, ha="right", va="bottom", transform=axes.get_yaxis_transform()
        )


def title(axes: Axes, *lines: str) -> None:
    """What the axes show, of how many trials, and what bars and bands are; long lines end between words."""
    space = "\N{NO-BREAK SPACE}"
    kept = [line.replace(" %", f"{space}%").replace("$P$ = ", f"$P${space}={space}") for line in lines]
    said = "\n".join(piece for line in kept for piece in textwrap.wrap(line, _WIDE))
    axes.text(0, 1, said, transform=_offset(axes, axes.transAxes, y=_ABOVE), ha="left", va="bottom")


def label_right(axes: Axes, labels: Sequence[tuple[float, str, str]]) -> None:
    """Names (height, text, colour) at the right edge, near where their lines end, none on another one."""
    low, high = axes.get_ylim()
    ends = [min(1.0, max(0.0, (y - low) / (high - low))) for y, _, _ in labels]
    beside = _offset(axes, axes.transAxes, x=_BEHIND)
    for end, height, (_, text, colour) in zip(ends, placed(ends, 0.0, 1.0, _GAP), labels, strict=True):
        if abs(height - end) > _BESIDE:  # a level line would run into the name as a dash
            leader: dict[str, Any] = {"linewidth": 0.7, "clip_on": False, "label": "_axis"}
            axes.plot([1.005, 1.04], [end, height], color=colour, transform=axes.transAxes, **leader)
        axes.text(1, height, text, color=colour, va="center", ha="left", transform=beside)


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


def staircase(axes: Axes, curve: Curve, style: Style, first: int) -> None:
    """A share by step from 0, with a marker at every fourth step from ``first`` on; with its band if it leads."""
    steps = (*range(len(curve.value)), len(curve.value) - 1 + BEYOND)
    share, low, high = (numbers((*line, *line[-1:])) for line in (curve.value, curve.low, curve.high))
    axes.step(steps, share, where="post", markevery=list(range(first, len(curve.value), 4)), **style.line)
    if style.lead and low:
        axes.fill_between(steps, low, high, step="post", color=style.colour, alpha=0.15, linewidth=0, zorder=1)


def curve_with_band(axes: Axes, curve: Curve, style: Style) -> None:
    """A curve, and its band where it has one."""
    axes.plot(curve.x, numbers(curve.value), **{**style.line, "marker": "", "zorder": 3})
    if curve.low:
        band = numbers(curve.low), numbers(curve.high)
        axes.fill_between(curve.x, *band, color=style.colour, alpha=0.15, linewidth=0, zorder=1)


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


def published_by_p(cells: Sequence[Cell], first: Proportion, peak: Proportion) -> list[tuple[float, float]]:
    """The paper's shares at p = 0 and at its peak, as far as the study has that p; none with a single p."""
    played = {cell.p for cell in cells if cell.p is not None}
    places = [(0.0, first.value), (PEAK, peak.value)]
    return [place for place in places if len(played) > 1 and min(played) <= place[0] <= max(played)]


COLUMN, HEIGHT = 3.5, 2.05
"""Width of a panel and height of its axes, in inches."""

_EDGE, _BETWEEN = 0.06, 0.14
"""Room at the edges of a picture and a panel, and between rows of axes, in inches."""

_WITHIN, _NEAR = 0.75, 0.5 * DPI
"""Part of a panel that its axes take, about, before it is laid out; pixels from their side at which texts may reach
out."""

_NOTE, _LINE = 45, 0.165
"""Characters in a line of a note, and its height in inches."""

Shown = TypeVar("Shown")


@own_settings()
def render(figure: Figure, form: Literal["png", "svg"]) -> bytes:
    """The picture as a file. Equal figures give equal bytes.

    A PNG has no transparency, which Matplotlib would write too: a tenth of the bytes and of the time.
    """
    out = io.BytesIO()
    if form == "svg":
        figure.savefig(out, format="svg", dpi=DPI, transparent=True, metadata={"Date": None})
        return out.getvalue()
    figure.set_dpi(DPI)
    canvas: Any = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.frombytes("RGB", canvas.get_width_height(physical=True), canvas.buffer_rgba(), "raw", "RGBX")
    image.save(out, "PNG", compress_level=3, dpi=(DPI, DPI))
    return out.getvalue()


@own_settings()
def as_pdf(figure: Figure) -> bytes:
    """A figure as a PDF of its size, with its fonts in it. Equal figures give equal bytes."""
    out = io.BytesIO()
    figure.savefig(out, format="pdf", metadata={"CreationDate": None, "ModDate": None})
    return out.getvalue()


@own_settings()
def sheet(
    shown: Sequence[Shown],
    *draws: Callable[[Axes, Shown], None],
    heights: Sequence[float] = (),
    note: str = "",
    width: float = COLUMN,
) -> Figure | None:
    """A picture of panels, two beside each other, with one legend for all; None if there is nothing to show.

    Args:
        shown: What a panel shows each, such as the courses of agents.
        draws: What draws on a panel's axes, from the top.
        heights: Heights of these axes in inches, the same for all panels.
        note: A text below all panels; above the legend, where there is one.
        width: Of a panel, in inches.
    """
    if not shown:
        return None
    columns = min(2, len(shown))
    high = [*(heights or [HEIGHT] * len(draws))] * -(-len(shown) // columns)
    figure = Figure(figsize=(width * columns, sum(high)), dpi=DPI)
    FigureCanvasAgg(figure)  # it measures texts once; without a canvas a figure makes one whenever it measures
    rows: list[list[Axes]] = [[] for _ in high]
    for i, panel in enumerate(shown):
        for j, draw in enumerate(draws):
            axes = figure.add_axes((0, 0, _WITHIN / columns, 1))
            axes.set_axis_off()
            draw(axes, panel)
            rows[i // columns * len(draws) + j].append(axes)
    _lay_out(figure, rows, high, width, "\n".join(textwrap.wrap(note, _NOTE)))
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
