"""What the figures share: colours, axes, names at the edge, and whole pictures made of axes.

Nothing here touches global state. Colours are those of Okabe and Ito, which people with any common colour vision
can tell apart.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from statistics import fmean
from typing import Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lockprobe.analysis.summary import AgentSummary, ConditionSummary, StudySummary

__all__ = [
    "BEYOND",
    "FAINT",
    "LABEL_GAP",
    "SUBJECTS",
    "Style",
    "agent_label",
    "counts",
    "label_right",
    "p_axis",
    "panels",
    "render",
    "share_axis",
    "shifts",
    "single",
    "step_axis",
    "styles",
    "title",
]

SUBJECTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
_GREY = "#9a9a9a"
_INK = "#222222"
FAINT = "#666666"
_MARKERS = "osD^vP<>"
_DASHES = ("--", ":", "-.", (0, (6, 1.5)), (0, (1, 3)))
BEYOND = 0.5
"""How far a curve runs on after the last step."""

LABEL_GAP = 0.062
"""Least distance between labels at the right edge, in axes heights."""

AgentDrawing = Callable[[Axes, AgentSummary], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How one line looks; ``ink`` is the colour of its name."""

    colour: str
    ink: str
    marker: str
    dash: str | tuple[int, tuple[float, float]]
    lead: bool


def styles(result: StudySummary) -> list[tuple[AgentSummary, Style]]:
    """References first, in grey and told apart by their dashes; then the agents that the study is about."""
    references = [agent for agent in result.agents if agent not in result.subjects]
    found = [
        (
            agent,
            Style(colour=_GREY, ink=FAINT, marker=_MARKERS[-1 - i % 4], dash=_DASHES[i % len(_DASHES)], lead=False),
        )
        for i, agent in enumerate(references)
    ]
    for i, agent in enumerate(result.subjects):
        colour = SUBJECTS[i % len(SUBJECTS)]
        found.append((agent, Style(colour=colour, ink=colour, marker=_MARKERS[i % 4], dash="-", lead=True)))
    return found


def shifts(result: StudySummary) -> dict[tuple[str, str], float]:
    """Sideways shifts in p that keep the bars of several agents apart; the first subject is not shifted."""
    values = sorted({condition.p for condition in result.conditions})
    gap = min((b - a for a, b in pairwise(values)), default=0.1)
    agents = [
        *sorted(result.subjects, key=lambda agent: agent.blind),
        *(agent for agent in result.agents if agent not in result.subjects),
    ]
    return {
        (agent.agent, agent.modality): 0.1 * min(gap, 0.15) * ((i + 1) // 2) * (1 if i % 2 else -1)
        for i, agent in enumerate(agents)
    }


def counts(conditions: Sequence[ConditionSummary]) -> str:
    """The number of trials behind every share."""
    sizes = sorted({condition.success.n for condition in conditions})
    return f"n = {sizes[0]}" if len(sizes) == 1 else f"n = {sizes[0]} to {sizes[-1]}" if sizes else "n = 0"


def agent_label(agent: AgentSummary, longest: int = 30) -> str:
    """The agent's name, safe to set: shortened in the middle, and never read as a formula."""
    name = "".join(c if c.isprintable() else "?" for c in agent.agent)
    if len(name) > longest:
        name = f"{name[: longest // 2 - 1]}…{name[-longest // 2 :]}"
    extra = "" if agent.modality == "symbolic" else f" ({agent.modality})"
    return (name + extra).replace("$", r"\$")


def share_axis(axes: Axes, label: str) -> None:
    """The vertical axis of every figure: a share, from 0 to 100 %."""
    axes.set_ylim(-0.03, 1.03)
    axes.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.set_ylabel(label)
    axes.grid(axis="y", color="#e6e6e6", linewidth=0.7, zorder=0)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color("#888888")
    axes.tick_params(color="#888888", labelcolor=_INK)


def p_axis(axes: Axes, conditions: Sequence[ConditionSummary], shift: float = 0.0) -> None:
    """The horizontal axis of Figs. 4 and 5b: flip probability, with a tick at every value that was played."""
    values = sorted({condition.p for condition in conditions}) or [0.0]
    margin = (0.06 * (values[-1] - values[0]) or 0.1) + shift
    axes.set_xlim(values[0] - margin, values[-1] + margin)
    if len(values) <= 11:
        axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.set_xlabel("probability p that a report is inverted")


def step_axis(axes: Axes, conditions: Sequence[ConditionSummary]) -> None:
    """The axes of Fig. 3: steps up to the budget, and the share solved."""
    budget = max((len(condition.curve.share) - 1 for condition in conditions), default=20)
    share_axis(axes, "solved by this step")
    axes.set_xlim(0, budget + BEYOND)
    axes.set_xlabel("step")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))


def title(axes: Axes, text: str) -> None:
    """What the axes show, and of how many trials."""
    axes.set_title(text, loc="left", fontsize="medium", color=_INK)


def label_right(axes: Axes, labels: Sequence[tuple[float, str, str]], gap: float = LABEL_GAP) -> None:
    """Names at the right edge, each at the height where its line ends, pushed apart where they would touch."""
    low, high = axes.get_ylim()
    places = [(min(1.0, max(0.0, (y - low) / (high - low))), -i) for i, (y, _, _) in enumerate(labels)]
    ordered = sorted(places)
    blocks: list[list[float]] = []
    for i, (edge, _) in enumerate(ordered):
        blocks.append([edge - i * gap])
        while len(blocks) > 1 and fmean(blocks[-2]) > fmean(blocks[-1]):
            blocks[-2:] = [blocks[-2] + blocks[-1]]
    bases = [min(max(0.0, fmean(block)), 1.0 - gap * (len(labels) - 1)) for block in blocks for _ in block]
    for i, ((edge, place), base) in enumerate(zip(ordered, bases, strict=True)):
        height, (_, text, colour) = base + i * gap, labels[-place]
        axes.plot([1.005, 1.03], [edge, height], transform=axes.transAxes, color=colour, linewidth=0.7, clip_on=False)
        axes.text(
            1.037,
            height,
            text,
            transform=axes.transAxes,
            color=colour,
            va="center",
            ha="left",
            fontsize="small",
            linespacing=1.1,
        )


def single(draw: Callable[[Axes, StudySummary], None], result: StudySummary) -> Figure:
    """One picture of the whole study."""
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    draw(figure.add_subplot(), result)
    return figure


def panels(draw: AgentDrawing, agents: Sequence[AgentSummary], note: str = "") -> Figure:
    """One panel per agent, at most three beside each other, all on the same scales, and a note below."""
    columns = min(3, max(1, len(agents)), 2 if len(agents) == 4 else 3)
    rows = max(1, ceil(len(agents) / columns))
    width = 5.2 if columns == 1 else 3.9 * columns
    figure = Figure(figsize=(width, 3.6 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, agent in zip(grid.flat, agents, strict=False):
        draw(axes, agent)
    for axes in grid.flat[len(agents) :]:
        axes.set_visible(False)
    for axes in grid[:, 1:].flat:
        axes.set_ylabel("")
    if note:
        figure.supxlabel(note, fontsize="small", color=FAINT)
    handles, names = grid.flat[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, names, loc="outside lower center", ncols=len(names), frameon=False, fontsize="small")
    return figure


def render(figure: Figure, form: Literal["png", "svg"]) -> bytes:
    """The picture as a file. Equal figures give equal bytes."""
    out = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "lockprobe"}):
        metadata = {"Date": None} if form == "svg" else {"Software": None}
        figure.savefig(out, format=form, dpi=200, metadata=metadata)
    return out.getvalue()
