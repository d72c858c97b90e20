"""Whole pictures made of axes, and files made of pictures. Nothing here touches global state."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal, TypeVar

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lockprobe.analysis.branch import BranchEffect
from lockprobe.analysis.effects import Effects
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.analysis.why import Why
from lockprobe.figures.courses import draw_course
from lockprobe.figures.differences import change_rows, difference_rows, draw_changes, draw_differences, shown
from lockprobe.figures.dose_grid import GridPanel, draw_grid, grid_height
from lockprobe.figures.effects import draw_effects, effect_rows
from lockprobe.figures.forest import height
from lockprobe.figures.forks import draw_forks, fork_panels
from lockprobe.figures.frame import FAINT, SMALL
from lockprobe.figures.loops import (
    draw_loop_harm,
    draw_loop_onset,
    draw_loops_against_success,
    draw_loops_by_p,
    draw_loops_with_chance,
    odds_reach,
)
from lockprobe.figures.overview import draw_overview
from lockprobe.figures.people import compared, draw_people, draw_relative_steps
from lockprobe.figures.rationality import draw_optimal_actions, draw_steps_lost
from lockprobe.figures.settings import own_settings
from lockprobe.figures.success_by_flip_rate import draw_success_by_p, draw_success_by_p_corrected
from lockprobe.figures.success_by_step import (
    draw_relative_success,
    draw_success_curves,
    draw_success_curves_by_p,
    draw_success_curves_corrected,
    relative_rows,
)
from lockprobe.figures.why import draw_ladder, draw_parts

__all__ = ["condition_drawings", "drawings", "fork_drawing", "panels", "pictures", "render", "single"]

_COLUMN = 3.5
"""Width of a panel in inches."""

_HEIGHT = 2.9
"""Height of a panel in inches."""

_SCREEN = (5.6, 3.15)
"""Size of the figure of the first screen in inches: as wide for its height as a slide."""

_TICKS = 3
"""Ticks of that figure in a column."""

_CHARACTER, _LINE = 0.077, 0.165
"""Width of a character of the small text and height of a line, in inches, generously."""

_DPI = 200
"""Pixels per inch of what is laid out and of PNG files."""

_COMPRESSION = 3
"""Of PNG files: a third less time than the usual 6, for 6 % more bytes."""

_LENGTH_NOTE = (
    "Solved trials are shorter and hold fewer loops by chance alone: a negative r is expected even if loops do no harm."
)

_OVER_P = {"fig3-by-p", "fig4", "fig4-corrected", "courses", "fig5a", "fig5b"}
"""Pictures that say nothing with a single p."""

Shown = TypeVar("Shown")


@own_settings()
def pictures(result: StudySummary) -> dict[str, Figure]:
    """Every picture of a study by its file name: the paper's figures, each followed by its corrected companion.

    What runs over p is left out of a study with a single p.
    """
    return {name: draw() for name, draw in drawings(result).items()}


@own_settings()
def drawings(result: StudySummary) -> dict[str, Callable[[], Figure]]:
    """The same before they are drawn."""
    subjects = result.subjects
    by_p = partial(draw_success_by_p_corrected, reference=result.reference)
    judged = [agent for agent in subjects if any(condition.rationality for condition in agent.conditions)]
    onset = [draw_loop_onset] if any(agent.inference.onset.primary for agent in subjects) else []
    steps = [draw_relative_steps] if compared(result) else []
    drawn: dict[str, Callable[[], Figure]] = {
        "overview": lambda: _overview(result, _SCREEN),
        "overview-column": lambda: _overview(result, (_COLUMN, _HEIGHT)),
        "people": lambda: single(draw_people, result, *steps),
        "side-by-side": lambda: _side_by_side(result),
        "fig3": lambda: single(draw_success_curves, result),
        "fig3-corrected": lambda: _curves_corrected(result),
        "fig3-by-p": lambda: panels(draw_success_curves_by_p, subjects),
        "fig4": lambda: single(draw_success_by_p, result),
        "fig4-corrected": lambda: panels(by_p, subjects),
        "courses": lambda: panels(draw_course, result.agents, heights=(2.1,)),
        "rationality": lambda: panels(draw_optimal_actions, judged, draw_steps_lost, heights=(_HEIGHT, 2.1)),
        "fig5a": lambda: panels(draw_loops_against_success, subjects, note=_LENGTH_NOTE),
        "fig5a-corrected": lambda: _loop_harm(subjects),
        "fig5b": lambda: panels(draw_loops_by_p, subjects),
        "fig5b-corrected": lambda: panels(draw_loops_with_chance, subjects, *onset),
    }
    left_out = {"courses"} if len(result.agents) < 2 else set()
    left_out |= set() if judged else {"rationality"}
    left_out |= set() if shown(result) else {"side-by-side"}
    left_out |= set() if result.people else {"people"}
    if len({condition.p for condition in result.conditions}) == 1:
        left_out |= _OVER_P
    return {name: own_settings()(draw) for name, draw in drawn.items() if name not in left_out}


def _loop_harm(agents: Sequence[AgentSummary]) -> Figure:
    """Odds ratios on one axis for all agents."""
    return panels(partial(draw_loop_harm, reach=odds_reach(agents)), agents, heights=(2.5,))


def _side_by_side(result: StudySummary) -> Figure:
    sides = [(draw_differences, height(difference_rows(result)))]
    sides += [(draw_changes, height(moved))] if (moved := change_rows(result)) else []
    (first, _), *below = sides
    return single(first, result, *(draw for draw, _ in below), heights=[inches for _, inches in sides])


def _curves_corrected(result: StudySummary) -> Figure:
    if not any(condition.relative for condition in result.conditions):
        return single(draw_success_curves_corrected, result)
    heights = [_HEIGHT, height(relative_rows(result))]
    return single(draw_success_curves_corrected, result, draw_relative_success, heights=heights)


@own_settings()
def condition_drawings(
    effects: Sequence[Effects], series: Sequence[StudySummary], whys: Sequence[Why] = ()
) -> dict[str, Callable[[], Figure]]:
    """The pictures of a study of conditions by file name, before they are drawn.

    Args:
        effects: Each agent's conditions against their control.
        series: The numbers over one dose each.
        whys: Why false reports change the success of each agent.
    """
    rows = max((effect_rows(one) for one in effects), key=len, default=[])
    drawn: dict[str, Callable[[], Figure]] = {}
    if whys:
        drawn["why"] = lambda: _sheet((draw_ladder, draw_parts), whys, [], "")
    if rows:
        drawn["effects"] = lambda: _sheet((draw_effects,), effects, [height(rows)], "")
    for number, shown_grids in enumerate(_grids(effects), 1):
        drawn[f"grid-{number}"] = partial(_sheet, (draw_grid,), shown_grids, [grid_height(shown_grids)], "")
    for number, result in enumerate(series, 1):
        by_dose = partial(draw_success_by_p_corrected, reference=result.reference)
        shown = [agent for agent in result.agents if any(condition.success.n for condition in agent.conditions)]
        if shown:
            drawn[f"series-{number}-success"] = partial(panels, by_dose, shown)
            drawn[f"series-{number}-loops"] = partial(panels, draw_loops_with_chance, shown)
    return {name: own_settings()(draw) for name, draw in drawn.items()}


@own_settings()
def fork_drawing(found: Sequence[BranchEffect]) -> Figure:
    """What one report did by its step, a panel for each agent and condition; at least one step has a number."""
    return _sheet((draw_forks,), fork_panels(found), [], "")


def _grids(effects: Sequence[Effects]) -> list[list[GridPanel]]:
    """What one picture shows each: the same two interventions beside the same others, a panel for each agent."""
    found: dict[tuple[str, str, str], list[GridPanel]] = {}
    for one in effects:
        for summary in one.grids:
            grid = summary.grid
            found.setdefault((grid.name, grid.rows.rest, grid.modality), []).append((one.agent, summary))
    return list(found.values())


@own_settings()
def single(
    draw: Callable[[Axes, StudySummary], None],
    result: StudySummary,
    *below: Callable[[Axes, StudySummary], None],
    heights: Sequence[float] = (),
) -> Figure:
    """One picture of the whole study, one column wide; further drawings go below the first."""
    return _sheet((draw, *below), [result], heights, "")


def _overview(result: StudySummary, size: tuple[float, float]) -> Figure:
    """The figure of the first screen in a size in inches, without a legend."""
    figure = Figure(figsize=size, layout=ConstrainedLayoutEngine(w_pad=0.06))
    axes = figure.subplots()
    draw_overview(axes, result)
    if size[0] <= _COLUMN:  # the names of agents take half of it
        every = -(-len(axes.get_xticks()) // _TICKS)
        labels = [label.get_text() for label in axes.get_xticklabels()]
        axes.set_xticks(axes.get_xticks()[::every], labels[::every])
    return figure


@own_settings()
def panels(
    draw: Callable[[Axes, AgentSummary], None],
    agents: Sequence[AgentSummary],
    *below: Callable[[Axes, AgentSummary], None],
    heights: Sequence[float] = (),
    note: str = "",
) -> Figure:
    """One panel per agent, two beside each other; further drawings go below the first, a note below all."""
    return _sheet((draw, *below), agents, heights, note)


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


def _sheet(
    draws: Sequence[Callable[[Axes, Shown], None]], shown: Sequence[Shown], heights: Sequence[float], note: str
) -> Figure:
    """Two columns at most, each as many drawings high as there are, and one legend for all."""
    columns, bands = min(2, len(shown)), -(-len(shown) // 2)
    ratios = [*(heights or [_HEIGHT] * len(draws))] * bands
    figure = Figure(figsize=(_COLUMN * columns, sum(ratios)), layout=ConstrainedLayoutEngine(w_pad=0.06, wspace=0.04))
    grid = figure.subplots(len(ratios), columns, squeeze=False, height_ratios=ratios)
    for i in range(columns * bands):
        for j, draw in enumerate(draws):
            axes = grid[i // 2 * len(draws) + j, i % 2]
            if i < len(shown):
                draw(axes, shown[i])
            else:
                axes.set_visible(False)
    if note:
        lines = textwrap.wrap(note, int(_COLUMN * columns / _CHARACTER))
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
