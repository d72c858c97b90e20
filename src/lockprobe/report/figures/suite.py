"""The scores of a suite: a row for each agent, a panel for each score."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import minus
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import FAINT, safe_name, title
from lockprobe.report.figures.palette import SUBJECTS, Style
from lockprobe.report.figures.primitives import estimates
from lockprobe.report.figures.settings import own_settings
from lockprobe.statistics.suite.scores import Rational, Score, SuiteScore

__all__ = ["SHOWN", "suite_drawing"]

SHOWN = 40
"""Agents that one picture has room for."""

_WIDTH, _ROW, _REST = 1.76, 0.24, 1.0
"""Width of a panel with its share of the names, height of a row and of all else, in inches."""

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
def suite_drawing(entries: Sequence[tuple[str, SuiteScore]]) -> Figure | None:
    """Five panels with 95 % intervals, agents from top to bottom; None without any.

    Args:
        entries: Names and scores; those beyond :data:`SHOWN` are left out.
    """
    shown = entries[:SHOWN]
    note = f"{len(entries) - SHOWN} more agents are in the table" if len(entries) > SHOWN else ""
    panels, height = _PANELS if shown else (), _REST + _ROW * len(shown)
    return sheet(panels, partial(_draw, shown), heights=(height,), note=note, columns=len(_PANELS), width=_WIDTH)


def _draw(entries: Sequence[tuple[str, SuiteScore]], axes: Axes, panel: _Panel) -> None:
    found = [panel.of(score) for _, score in entries]
    ends = [end for one in found if one is not None for end in (one.low, one.high)]
    low, high = min([0.0, *ends]), max([0.0 if panel.signed else 1.0, *ends])
    axes.axvline(0.0, color=FAINT, linewidth=0.8, zorder=1)
    for row, one in enumerate(found):
        if one is None:
            place = axes.get_yaxis_transform()
            axes.text(0.5, row, panel.missing, color=FAINT, transform=place, ha="center", va="center")
            continue
        estimates(axes, [row], [one], Style(colour=SUBJECTS[0]), across=True)
        if isinstance(one, Rational):
            axes.plot([one.chance] * 2, [row - 0.3, row + 0.3], color=FAINT, linewidth=1.2, zorder=2)
    pad = 0.06 * (high - low or 1.0)
    axes.set(xlim=(low - pad, high + pad), ylim=(len(found) - 0.4, -0.6), xlabel=panel.unit)
    title(axes, panel.name)
    _ticks(axes, low, high, signed=panel.signed)
    names = [safe_name(name, _LONGEST) for name, _ in entries] if panel is _PANELS[0] else [""] * len(found)
    axes.set_yticks(range(len(found)), names)
    axes.grid(axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)


def _ticks(axes: Axes, low: float, high: float, *, signed: bool) -> None:
    """At most three ticks of round values, 0 among them, and at least two where the scores reach that far."""
    every = [[i * step for i in range(-40, 41) if low - 1e-9 <= i * step <= high + 1e-9] for step in _STEPS]
    ticks = next((ticks for ticks in every if len(ticks) <= 3), every[-1])
    form = "{:+.0f}" if signed else "{:.0f}"
    axes.set_xticks(ticks, [minus(form.format(100 * tick)) if abs(tick) > 1e-9 else "0" for tick in ticks])
