"""The scores of a suite: a row for each agent, a panel for each score."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lockprobe.analysis.suite_scores import Rational, Score, SuiteScore
from lockprobe.figures.frame import FAINT, INK, SMALL, safe_name, shortened, title
from lockprobe.figures.palette import SUBJECTS
from lockprobe.figures.settings import own_settings
from lockprobe.formatting import minus

__all__ = ["SHOWN", "suite_drawing"]

SHOWN = 40
"""Agents that one picture has room for."""

_WIDTH, _ROW, _REST = 8.8, 0.24, 1.0
"""Width of the picture, height of a row and of all else, in inches."""

_LONGEST = 34
"""Characters of a name."""

_STEPS = (0.05, 0.1, 0.2, 0.25, 0.5, 1.0)
"""Distances between two ticks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Panel:
    """One score: its title, what stands below it, what it is of an agent, and what stands where there is none."""

    name: str
    unit: str
    of: Callable[[SuiteScore], Score | Rational | None]
    signed: bool = False
    missing: str = "no trial"


_PANELS = (
    _Panel(name="competence", unit="%\n0 is chance", of=lambda one: one.competence),
    _Panel(
        name="robustness", unit="points\n0 is no change", of=lambda one: one.robustness, signed=True, missing="none"
    ),
    _Panel(name="misreading", unit="% of claims\n", of=lambda one: one.misreading, missing="not asked"),
    _Panel(name="loops", unit="points\n0 is chance", of=lambda one: one.loops, signed=True),
    _Panel(name="rationality", unit="% of actions\nupright: chance", of=lambda one: one.rationality),
)


@own_settings()
def suite_drawing(entries: Sequence[tuple[str, SuiteScore]]) -> Figure:
    """Five panels with 95 % intervals, agents from top to bottom.

    Args:
        entries: Names and scores, at least one; those beyond :data:`SHOWN` are left out.
    """
    shown = entries[:SHOWN]
    figure = Figure(figsize=(_WIDTH, _REST + _ROW * len(shown)), layout=ConstrainedLayoutEngine(w_pad=0.09))
    panels = figure.subplots(1, len(_PANELS), sharey=True, squeeze=False)[0]
    for axes, panel in zip(panels, _PANELS, strict=True):
        _draw(axes, panel, [score for _, score in shown])
    panels[0].set_yticks(range(len(shown)), [safe_name(shortened(name, _LONGEST)) for name, _ in shown])
    panels[0].tick_params(axis="y", labelsize=SMALL, length=0, labelcolor=INK)
    panels[0].set_ylim(len(shown) - 0.4, -0.6)
    if left := len(entries) - len(shown):
        figure.supxlabel(f"{left} more agents are in the table", fontsize=SMALL, color=FAINT)
    return figure


def _draw(axes: Axes, panel: _Panel, scores: Sequence[SuiteScore]) -> None:
    found = [panel.of(score) for score in scores]
    ends = [end for one in found if one is not None for end in (one.low, one.high)]
    low, high = min([0.0, *ends]), max([0.0 if panel.signed else 1.0, *ends])
    axes.axvline(0.0, color=FAINT, linewidth=0.8, zorder=1)
    for row, one in enumerate(found):
        if one is None:
            axes.text(0.5, row, panel.missing, color=FAINT, fontsize=SMALL,
                      transform=axes.get_yaxis_transform(), ha="center", va="center")  # fmt: skip
            continue
        axes.plot([one.low, one.high], [row, row], color=SUBJECTS[0], linewidth=1.3, solid_capstyle="butt", zorder=3)
        axes.plot([one.value], [row], "o", color=SUBJECTS[0], markersize=4, zorder=4)
        if isinstance(one, Rational):
            axes.plot([one.chance] * 2, [row - 0.3, row + 0.3], color=FAINT, linewidth=1.2, zorder=2)
    pad = 0.06 * (high - low or 1.0)
    axes.set_xlim(low - pad, high + pad)
    title(axes, panel.name)
    axes.set_xlabel(panel.unit, fontsize=SMALL)
    _ticks(axes, low, high, signed=panel.signed)
    axes.grid(axis="y", color="#eeeeee", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)


def _ticks(axes: Axes, low: float, high: float, *, signed: bool) -> None:
    """At most three ticks of round values, 0 among them, and at least two where the scores reach that far."""
    every = [[i * step for i in range(-40, 41) if low - 1e-9 <= i * step <= high + 1e-9] for step in _STEPS]
    ticks = next((ticks for ticks in every if len(ticks) <= 3), every[-1])
    form = "{:+.0f}" if signed else "{:.0f}"
    said = [minus(form.format(100 * tick)) if abs(tick) > 1e-9 else "0" for tick in ticks]
    axes.set_xticks(ticks, said, fontsize=SMALL)
