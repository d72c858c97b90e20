"""What the figures share: colours, markers, axes, and names that are safe to set.

Sizes are those of print: a panel is one column (3.5 inches) wide and no text is smaller than 7 points. What belongs
together looks alike in every figure, in grey as well. Agents that the study is about are coloured (by Okabe and Ito,
whom people with any common colour vision can tell apart), thick, with filled markers; references that were played are
grey and thin with hollow ones; what is computed without a trial is grey, dotted or dashed, without any.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.font_manager import findfont, get_font
from matplotlib.ticker import MaxNLocator

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.summary import AgentSummary, StudySummary

__all__ = [
    "ACCENT",
    "BEYOND",
    "EXACT",
    "FAINT",
    "INK",
    "SMALL",
    "SUBJECTS",
    "Dash",
    "Style",
    "agent_label",
    "blank",
    "counts",
    "heading",
    "label_right",
    "minus",
    "p_axis",
    "p_value",
    "percent",
    "share_axis",
    "shifts",
    "step_axis",
    "styles",
    "title",
]

Dash = str | tuple[int, tuple[float, ...]]

SUBJECTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
ACCENT = SUBJECTS[1]
"""The colour of loops, where one agent is shown by itself."""

INK, FAINT = "#222222", "#666666"
EXACT: dict[str, Dash] = {"random": ":", "no-repeat": "--"}
"""How the two blind agents are drawn, in FAINT, wherever they are computed rather than played."""

SMALL = 7.0
"""Size of all text but names of axes, in points."""

BEYOND = 0.5
"""How far a curve runs on after the last step."""

_TEXT = 8.0
_GREYS = ("#3d3d3d", "#7a7a7a", "#a3a3a3", "#5c5c5c")
_MARKERS = "osD^"
_HOLLOW = "vP<>"
_DASHES: tuple[Dash, ...] = ("-", (0, (5, 1.5)), (0, (4, 1.2, 1, 1.2)))
_GAP = 0.08
"""Least distance between labels at the right edge, in axes heights."""

_ROOM = 29.5
"""Digits that fit between the lowest and the highest p, where names at the right edge take some of the room."""

_LINE = 54
"""Characters in a line above a panel."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How one agent looks; ``lead`` if the study is about it."""

    colour: str
    marker: str
    dash: Dash
    lead: bool

    @property
    def face(self) -> str:
        """The inside of its markers."""
        return self.colour if self.lead else "white"


def styles(result: StudySummary) -> list[tuple[AgentSummary, Style]]:
    """Every agent with its looks: those that the study is about first, then the references."""
    subjects, references = result.subjects, [agent for agent in result.agents if agent not in result.subjects]
    return [
        *(
            (
                agent,
                Style(
                    colour=SUBJECTS[i % len(SUBJECTS)],
                    marker=_MARKERS[i % len(_MARKERS)],
                    dash=_DASHES[i % len(_DASHES)],
                    lead=True,
                ),
            )
            for i, agent in enumerate(subjects)
        ),
        *(
            (agent, Style(colour=_GREYS[i % len(_GREYS)], marker=_HOLLOW[i % len(_HOLLOW)], dash="-", lead=False))
            for i, agent in enumerate(references)
        ),
    ]


def shifts(result: StudySummary) -> dict[tuple[str, str], float]:
    """Sideways shifts in p that keep the marks of several agents apart; the first subject is not shifted."""
    values = sorted({condition.p for condition in result.conditions})
    gap = min((b - a for a, b in pairwise(values)), default=0.1)
    return {
        (agent.agent, agent.modality): 0.11 * min(gap, 0.15) * ((i + 1) // 2) * (1 if i % 2 else -1)
        for i, (agent, _) in enumerate(styles(result))
    }


def counts(conditions: Sequence[ConditionSummary]) -> str:
    """The number of trials behind every share."""
    sizes = sorted({condition.success.n for condition in conditions}) or [0]
    return f"n = {sizes[0]} to {sizes[-1]} trials" if len(sizes) > 1 else f"n = {sizes[0]} trial" + "s" * (sizes != [1])


def percent(share: float) -> str:
    """A share as it is set in print."""
    return f"{100 * share:.0f} %"


def minus(text: str) -> str:
    """Numbers as they are set in print."""
    return text.replace("-", "\N{MINUS SIGN}")


def p_value(value: float | None) -> str:
    """A p-value, in a way that cannot be taken for a flip probability."""
    return "no p-value" if value is None else "p-value < 0.001" if value < 0.001 else f"p-value {value:.2g}"


def agent_label(agent: AgentSummary, longest: int = 30) -> str:
    """The agent's name, safe to set: shortened in the middle, in glyphs that exist, and never read as a formula."""
    font = get_font(findfont(mpl.font_manager.FontProperties()))
    name = "".join(c if c.isprintable() and font.get_char_index(ord(c)) else "?" for c in agent.agent)
    if len(name) > longest:
        name = f"{name[: longest // 2 - 1]}…{name[-longest // 2 :]}"
    extra = f" ({agent.shown})" if agent.shown else ""
    hidden = " " if name.startswith("_") else ""  # a legend leaves out what begins with an underscore
    return (hidden + name + extra).replace("$", r"\$")


def heading(agent: AgentSummary) -> str:
    """Its name, and whether it acted the same at every p."""
    return agent_label(agent) + (", the same at every p" if agent.blind else "")


def share_axis(axes: Axes, label: str) -> None:
    """The vertical axis of every figure: a share, from 0 to 100 %."""
    axes.set_ylim(-0.03, 1.03)
    axes.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.set_ylabel(label, fontsize=_TEXT, color=INK)
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.6, zorder=0)
    _plain(axes)


def p_axis(axes: Axes, conditions: Sequence[ConditionSummary], shift: float = 0.0) -> None:
    """The horizontal axis of Figs. 4 and 5b: flip probability, a tick at every value played, named where it fits."""
    values = sorted({condition.p for condition in conditions}) or [0.0]
    margin = (0.06 * (values[-1] - values[0]) or 0.1) + shift
    axes.set_xlim(values[0] - margin, values[-1] + margin)
    names, free = [], values[0]
    for value in values:
        name = f"{value:g}"
        width = (len(name) - 0.5 * name.count(".") + 0.4) * (values[-1] - values[0]) / _ROOM  # a point is half a digit
        names.append(name if value - width / 2 >= free or value == values[0] else "")
        free = value + width / 2 if names[-1] else free
    axes.set_xticks(values, names)
    axes.set_xlabel("probability p that a report is inverted", fontsize=_TEXT, color=INK)


def step_axis(axes: Axes, budget: int, label: str) -> None:
    """The axes of Fig. 3: interactions up to the budget, and a share."""
    share_axis(axes, label)
    axes.set_xlim(0, budget + BEYOND)
    axes.set_xlabel("number of interactions", fontsize=_TEXT, color=INK)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))


def blank(axes: Axes, why: str) -> None:
    """Axes that have nothing to show, and why."""
    axes.set_axis_off()
    text = "\n".join(textwrap.wrap(why, _LINE - 8))
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", fontsize=SMALL, color=FAINT)


def title(axes: Axes, *lines: str) -> None:
    """What the axes show, of how many trials, and what bars and bands are."""
    wrapped = [part for line in lines if line for part in textwrap.wrap(line, _LINE)]
    axes.set_title("\n".join(wrapped), loc="left", fontsize=SMALL, color=INK)


def label_right(axes: Axes, labels: Sequence[tuple[float, str, str]], gap: float = _GAP) -> None:
    """Names at the right edge, each at the height where its line ends, pushed apart where they would touch."""
    low, high = axes.get_ylim()
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
        axes.plot([1.005, 1.03], [end, height], transform=axes.transAxes, color=colour, linewidth=0.7, clip_on=False)
        axes.text(
            1.037,
            height,
            text,
            transform=axes.transAxes,
            color=colour,
            va="center",
            ha="left",
            fontsize=SMALL,
            linespacing=1.05,
        )


def _plain(axes: Axes) -> None:
    """Two thin spines, small numbers."""
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)
