"""What is crossed: does the effect of one intervention, or of one dose, depend on another?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import p_value, percent
from lockprobe.report.format import Entry, entry_text, tested, without_empty
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import interval_kind, who
from lockprobe.report.questions.conditions import detected_said
from lockprobe.report.rows import Estimate, Fact, Results, Row, measured_row
from lockprobe.report.section import Block, Figure, Note, Part, Section, Table
from lockprobe.statistics.contrast import interactions
from lockprobe.statistics.design import Crossed, axis_key

_BETWEEN = " \N{MULTIPLICATION SIGN} "

_FIRST, _SECOND = "first dose", "second dose"
"""Facts of a grid; of a place in it, such as ``0.4, 0.1``, the fact is its condition."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    if numbers.study.of_flips:
        return
    design, named, known = numbers.design, list[tuple[Crossed, str]](), Counter[tuple[str, str]]()
    every = [one for modality in design.modalities for one in design.comparisons[modality].crossed]
    for grid in (one for one in every if one.axes):
        (first, second), rest = (one.name for one in grid.axes), grid.axes[0].rest
        name = f"{first}{_BETWEEN}{second}"
        known[name, rest] += 1
        axis = axis_key(name, rest=rest, number=known[name, rest])
        named.append((grid, axis))
        facts = {_FIRST: first, _SECOND: second, "with": rest}
        facts |= {f"{row:g}, {column:g}": condition for (row, column), condition in grid.conditions.items()}
        yield from (Fact(about=axis, name=name, text=text) for name, text in facts.items() if text)
    for agent, crossed, found, choices in interactions(numbers.by_name, design):
        if crossed.axes:
            axis = next(axis for grid, axis in named if grid == crossed)
            of: dict[str, Any] = {"modality": crossed.modality, "axis": axis}
        else:
            neither, second, first, both = crossed.conditions.values()
            of = {"modality": numbers.conditions[both].modality, "condition": both, "control": neither}
            of |= {"of": f"{first}{_BETWEEN}{second}", "doses": dict(numbers.conditions[both].doses)}
        of |= {"unit": "points", "family": "interactions", "corrected_for": choices, "test": "sign flips of blocks"}
        yield measured_row("success_interaction", found, agent=agent, **of)


def _places(found: Results, axis: str) -> dict[str, str]:
    """Every combination of doses of a grid -> its condition."""
    return {name: condition for name, condition in found.facts_about(axis).items() if ", " in name}


def _interactions(found: Results) -> list[Estimate]:
    return found.where("success_interaction", versus="")


def _table(found: Results) -> Sequence[Sequence[Entry]]:
    table: list[list[Entry]] = [["agent", "interaction of", "with", "blocks", "interaction, points", "P", "conclusion"]]
    for row in _interactions(found):
        name = f"{found.fact(row.axis, _FIRST)}{_BETWEEN}{found.fact(row.axis, _SECOND)}" if row.axis else row.of
        beside = found.fact(row.axis, "with") if row.axis else ""
        table.append([row.agent, name, beside or None, str(row.n), *tested(row)])
    return without_empty(table, ["with"])


def draw(found: Results, axis: str) -> Any:
    """Success over two doses, a panel for each agent with a cell for each combination: darker is more."""
    import matplotlib as mpl
    from matplotlib.patches import Rectangle

    from lockprobe.report.figures import drawing as figures

    own, facts = _places(found, axis), found.facts_about(axis)
    rows, columns = (sorted({name.split(", ")[i] for name in own}, key=float) for i in (0, 1))
    shares = [row for row in found.where("success", of="", axis="") if row.condition in own.values()]
    lines = 3 if len(columns) <= 4 else 2 if len(columns) <= 6 else 1  # room for the share, its count, its interval

    def on(axes: Any, player: tuple[str, str]) -> None:
        agent, modality = player
        for (i, row), (j, column) in product(enumerate(rows), enumerate(columns)):
            where = own.get(f"{row}, {column}", "")
            cell = found.get("success", agent=agent, condition=where, control="", versus="", axis="") if where else None
            share = cell.value or 0.0 if cell else 0.0
            face = mpl.colormaps["Blues"](0.85 * share) if cell else "white"
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=face, edgecolor="white", linewidth=1.5))
            colour = (
                figures.FAINT if cell is None else "white" if share > 0.78 else figures.INK
            )  # the easier to read on it
            text = "\N{MULTIPLICATION SIGN}"  # not played
            if cell:
                ends = f"[{100 * (cell.low or 0):.0f}, {100 * (cell.high or 0):.0f}]"
                said = [percent(cell.value), f"{cell.count}/{cell.n}", ends][:lines]
                text = "\n".join(said) if lines > 1 else said[0].removesuffix(" %")
            axes.text(j, i, text, ha="center", va="center", color=colour, linespacing=1.15)
        axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
        names = figures.axis_label(facts[_SECOND]), figures.axis_label(facts[_FIRST])
        figures.axis(axes, "x", range(len(columns)), columns, names[0], bare=True)
        figures.axis(axes, "y", range(len(rows)), rows, names[1], bare=True)
        change = found.get("success_interaction", agent=agent, modality=modality, axis=axis, versus="")
        interaction = "interaction not estimated"
        if change is not None:
            tested = f", {p_value(change.p_value, '$P$')}" * (change.p_value is not None)
            interaction = f"interaction {entry_text(change)} points{tested}"
        figures.title(axes, figures.safe_name(who(agent), 38), interaction)

    agents = list(dict.fromkeys((row.agent, row.modality) for row in shares))
    return figures.sheet(agents, on, heights=[0.35 + len(rows) * 0.155 * (lines + 0.9)])


def _caption(found: Results) -> Note:
    return Note(
        "Share of trials solved under every combination of two doses, with count and interval where there is room. "
        "Darker cells are higher, crossed cells were not played, and the interaction is in points.",
        f"Intervals are {interval_kind(found)}. Numbers are in per cent.",
    )


_TABLE = Table("crossings", _table, numeric_from=3)

_NOTE = Note(
    "Of two interventions: the effect of the second together with the first, minus its effect alone. Of two doses: the "
    "effect of the whole range of the second at the highest dose of the first, minus its effect at the lowest, from "
    "linear trends over all cells. At 0 the effect of each does not depend on the other.",
    Markup(
        "Each block that has a trial in every cell gives one value; <i>P</i> is that of a sign-flip permutation test "
        "over blocks, and the interval is Student's, widened as if one more block differed. Both are corrected for the "
        "number of interactions and of agents."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    grids = dict.fromkeys(fact.about for fact in found.facts if fact.name == _FIRST)
    played = {row.condition for row in found.where("success", of="")}
    alt = "Success under every combination of two doses, one cell each"
    shown = [axis for axis in grids if played & {*_places(found, axis).values()}]
    blocks: list[Block] = [
        Figure(f"grid-{number}", alt, _caption, partial(draw, axis=axis), slide=number == 1)
        for number, axis in enumerate(shown, 1)
    ]
    rows = _interactions(found)
    blocks += [_TABLE, _NOTE] if rows else []
    if blocks:
        yield Part("Interactions", detected_said(rows, "interactions"), blocks)


SECTIONS = (Section(name="crossings", title="Interactions", rows=_rows, show=_show, tables=(_TABLE,)),)
