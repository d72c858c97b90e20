"""What the figures share: axes, titles, labels at the edge, and names that are safe to set.

Sizes are those of print: a panel is one column (3.5 inches) wide and no text is smaller than 9 points. What belongs
together looks alike in every figure, in grey as well; what is computed without a trial is grey, dotted or dashed,
without any marker.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Transform, offset_copy

from lockprobe.foundation.formatting import capital
from lockprobe.foundation.spec import spec_name
from lockprobe.report.figures.palette import of_text
from lockprobe.report.figures.settings import DPI, FAINT
from lockprobe.report.prose import Subject, false_reports
from lockprobe.report.rows import Cell, Course, Curve, DoseAxis
from lockprobe.statistics.conditions.axis import FLIPS

BEYOND = 0.5
"""How far a curve runs on after the last step."""

_WHOLE = 200
"""More characters than a name has."""

_GAP = 0.085
"""Least distance between labels at the right edge, in axes heights."""

_BESIDE = 0.02
"""Up to so far from the end of its line, in axes heights, a name needs no line that leads to it."""

_ROOM = 20.0
"""Digits that fit between the lowest and the highest p, where names at the right edge take some of the room."""

_STEPS = 5
"""Parts of an axis of steps, at most: its ticks have two digits, and names at the right edge take some of the room."""

_LEAST = 15
"""Characters that an agent keeps, however much has to be said of how it was shown the box."""

_LINE = 41
"""Characters in a line above a panel."""

_POINTS, _HIGH, _ABOVE, _BEHIND = 5, 12, 5, 12
"""Points between axes and the names of ticks, and between these and a label; of a line of names; up to a title; to
names at the right edge."""


def from_to(sizes: Iterable[int | None]) -> str:
    """Numbers as their range.

    >>> from_to([7, 3, 5]), from_to([3, 3]), from_to([])
    ('3 to 7', '3', '0')
    """
    known = [size or 0 for size in sizes] or [0]
    least, most = min(known), max(known)
    return f"{least}" if least == most else f"{least} to {most}"


def counts(shown: Sequence[Cell | Curve]) -> str:
    """The number of trials behind every share, or behind every curve, which counts those that broke too."""
    said = from_to(one.trials if isinstance(one, Cell) else one.n or 0 for one in shown)
    return f"n = {said} trial" + "s" * (said != "1")


def agent_label(agent: Course, longest: int = 30) -> str:
    """The agent's name, safe to set: in glyphs that exist, never read as a formula, shortened between words."""
    extra = f" ({agent.shown})" if agent.shown else ""
    return safe_name(shortened(Subject.of(agent.agent).name, max(_LEAST, longest - len(extra))) + extra)


def label_in_lines(agent: Course, longest: int) -> str:
    """The agent's label, in two lines where one of so many characters would leave a part of its name out."""
    label, whole = agent_label(agent, longest), agent_label(agent, _WHOLE)
    if label == whole:
        return label
    if agent.shown:
        name = shortened(whole.removesuffix(f" ({agent.shown})"), longest)
        return f"{name}\n({agent.shown})"
    if not label.endswith("…"):
        return label
    halves = [(whole[: found.end()], whole[found.end() :]) for found in re.finditer(r"[-_/:?&.]", whole)]
    narrow = min(halves, key=lambda lines: max(map(_width, lines)), default=(whole, ""))
    return "\n".join(narrow) if max(map(_width, narrow)) <= longest else label


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
    if _width(name) <= longest:
        return name
    head = spec_name(name)
    *_, last = re.split(r"(?<=[:/])", head)
    if last != head and _width(last) < longest:
        return f"…{shortened(last + name.removeprefix(head), longest - 1)}"
    fits = max(n for n in range(len(name)) if _width(name[:n]) < longest)
    ends = [found.start() for found in re.finditer(r"[^\w.]", name[: fits + 1]) if found.start() > fits // 3]
    return f"{name[: ends[-1] if ends else fits]}…"


def _width(text: str) -> float:
    """How wide a text is, in letters of usual width."""
    return len(text) + 1.1 * sum(text.count(wide) for wide in "mwMW@")


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
    """The axis below or on the left: names at places, a label, and lines across the axes.

    Matplotlib's own takes twice as long: it has five parts for every tick, and measures all of them several times.

    Args:
        axes: Where; their limits are set elsewhere.
        along: Which of the two.
        places: Where names stand.
        names: Empty for a tick without a name.
        label: What is shown along it.
        grid: Whether a line across the axes leads to every name.
        bare: Whether the names stand there without line and ticks.
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
    beside = offset(axes, across, y=-_POINTS) if below else offset(axes, across, x=-_POINTS)
    made = [
        axes.text(*((place, 0.0) if below else (0.0, place)), name, transform=beside, **side)
        for place, name in zip(places, names, strict=True)
        if name
    ]
    if label and below:
        deep = max((name.count("\n") + 1 for name in names if name), default=0)
        axes.text(0.5, 0, label, transform=offset(axes, axes.transAxes, y=-_POINTS - 1 - _HIGH * deep), **side)
    elif label:
        widest = max(made, key=lambda text: _width(text.get_text()))
        away = widest.get_window_extent().width * 72 / DPI + 2 * _POINTS
        axes.text(0, 0.5, label, transform=offset(axes, axes.transAxes, x=-away), rotation=90, **side)


def offset(axes: Axes, place: Transform, **points: float) -> Transform:
    """A place and so many points beside it, along ``x`` or ``y``."""
    return offset_copy(place, axes.get_figure(root=True), units="points", **points)


def share_axis(axes: Axes, label: str, along: Literal["x", "y"] = "y", *, grid: bool = True) -> None:
    """A share from 0 to 100 %, with a tick at every quarter."""
    axes.set(**{f"{along}lim": (-0.03, 1.03)})
    axis(axes, along, [0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"], label, grid=grid)


def p_axis(axes: Axes, cells: Sequence[Cell], name: str = FLIPS.name, *, label: str | None = None) -> None:
    """The horizontal axis of Figs. 4 and 5b: flip rate, or another dose, a tick at every value played.

    A tick is named where its name fits. With a single value there is no axis, and its name says which.

    Args:
        axes: Where.
        cells: Those played.
        name: Of the dose.
        label: What stands there in place of an axis, if anything does.
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
        width = (len(said) - 0.5 * said.count(".") + 0.4) * reach / _ROOM  # a point is half a digit
        names.append(said if value - width / 2 >= free or value == first else "")
        free = value + width / 2 if names[-1] else free
    axis(axes, "x", values, names, axis_label(name))


def dose_axes(axes: Axes, course: Course, label: str) -> None:
    """A share, with this label, over the doses of an agent."""
    share_axis(axes, label)
    p_axis(axes, course.cells, name=course.name)


def axis_label(name: str) -> str:
    """What stands below the axis; a flip rate has the letter of the paper."""
    return f"{name} $p$" if name == FLIPS.name else name.replace("$", r"\$")


def axis_note(axis: DoseAxis) -> str:
    """What stands below a figure over flip rates whose false reports are not the usual ones."""
    return capital(false_reports(axis.options)) if axis.of_flips and axis.options else ""


def whole_axis(axes: Axes, last: float, label: str) -> None:
    """The lower axis of whole numbers from 0, such as steps, with ticks at a few."""
    ticks = MaxNLocator(_STEPS, integer=True, steps=[1, 2, 5, 10]).tick_values(0, last)
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
    """What the axes show, of how many trials, and what bars and bands are."""
    above = offset(axes, axes.transAxes, y=_ABOVE)
    axes.text(0, 1, "\n".join(title_lines(*lines)), transform=above, ha="left", va="bottom")


def title_lines(*lines: str) -> list[str]:
    r"""The lines of a title as they are set: a long one ends after a semicolon, or else between words.

    >>> title_lines("n = 1200 trials per flip rate; bars: 95 % intervals", "")
    ['n = 1200 trials per flip rate;', 'bars: 95\xa0% intervals']
    """
    space = "\N{NO-BREAK SPACE}"
    together = [line.replace(" %", f"{space}%").replace("$P$ = ", f"$P${space}={space}") for line in lines if line]
    wrapped = []
    for line in together:
        first, *others = re.split(r"(?<=;) ", line)
        parts = [first]
        for part in others:
            joined = f"{parts[-1]} {part}"
            parts[-1:] = [joined] if len(joined) <= _LINE else [parts[-1], part]
        wrapped += [piece for part in parts for piece in textwrap.wrap(part, _LINE)]
    return wrapped


def label_right(axes: Axes, labels: Sequence[tuple[float, str, str]]) -> None:
    """Names at the right edge, each at the height where its line ends, pushed apart where they would touch.

    A name of two lines pushes all apart by as much.

    They have the colours of their lines, darker where text on white has to be.
    """
    gap = max([_GAP, *(_GAP * (1 + text.count("\n")) for _, text, _ in labels)])
    low, high = axes.get_ylim()
    beside = offset(axes, axes.transAxes, x=_BEHIND)
    places = [(min(1.0, max(0.0, (y - low) / (high - low))), -i) for i, (y, _, _) in enumerate(labels)]
    ordered = sorted(places)
    blocks: list[list[float]] = []
    for i, (end, _) in enumerate(ordered):
        blocks.append([end - i * gap])
        while len(blocks) > 1 and fmean(blocks[-2]) > fmean(blocks[-1]):
            blocks[-2:] = [blocks[-2] + blocks[-1]]
    edge = gap - _GAP  # what is more than a line high stays between the ends of the axis
    bases = [min(max(edge, fmean(block)), 1.0 - edge - gap * (len(labels) - 1)) for block in blocks for _ in block]
    for i, ((end, place), base) in enumerate(zip(ordered, bases, strict=True)):
        height, (_, text, colour) = base + i * gap, labels[-place]
        if abs(height - end) > _BESIDE:  # a level line would run into the name as a dash
            leader: dict[str, Any] = {"linewidth": 0.7, "clip_on": False, "label": "_axis"}
            axes.plot([1.005, 1.04], [end, height], color=colour, transform=axes.transAxes, **leader)
        axes.text(1, height, text, color=of_text(colour), va="center", ha="left", linespacing=1.05, transform=beside)
