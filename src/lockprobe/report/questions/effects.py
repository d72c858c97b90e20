"""Every condition against the control, and interactions of two doses or of two interventions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell, percent
from lockprobe.report.captions import share_intervals_said
from lockprobe.report.every_look import note_at
from lockprobe.report.format import DETECTED, TextTable
from lockprobe.report.questions.course_rows import PERMUTED
from lockprobe.report.rows import Estimate, Fact, Finding, Results, Row
from lockprobe.report.rows.primary import CONTROL
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import count_of, points_cell
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.conditions.axis import axis_key
from lockprobe.statistics.conditions.condition_study import ConditionStudySummary
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.dose_grid import Grid, GridSummary
from lockprobe.statistics.conditions.effects import CONTROLS, Effect, Effects, Interplay
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.trial.condition import Condition

_INTERACTIONS = "interactions"
"""The family of interactions."""

_PAIRED = "McNemar, and interval"
"""The test of a comparison in pairs; people are compared by a permutation."""

_BETWEEN = " \N{MULTIPLICATION SIGN} "


def of_blocks(found: BlockMean) -> dict[str, Any]:
    """The columns of a mean over blocks."""
    counted = {"n": found.pairs, "clusters": found.blocks}
    return counted | {name: getattr(found, name) for name in ("value", "low", "high", "p_value")}


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    if (others := numbers.others) is None:
        return
    doses = {name: dict(one.doses) for name, one in numbers.conditions.items()}
    for one in others.effects:
        yield from compared_rows(one, numbers.conditions)
        yield from _crossings(one, doses)
    yield from _grids(others, doses)
    yield from _answers(others)


_Doses = Mapping[str, dict[str, float]]
"""Condition -> its doses."""


def compared_rows(found: Effects, conditions: Mapping[str, Condition]) -> Iterator[Estimate]:
    """Success under conditions minus success under another one, and both shares."""
    for one in found.effects:
        gap, condition = one.difference, conditions[one.condition]
        pair: dict[str, Any] = {"agent": found.agent, "modality": condition.modality, "axis": found.axis}
        pair |= {"condition": one.condition, "control": found.control, "doses": dict(condition.doses)}
        yield Estimate(
            quantity="success_difference",
            **pair,
            unit="points",
            n=gap.first.n,
            value=gap.value,
            low=gap.low,
            high=gap.high,
            p_value=gap.p_value,
            family=found.family,
            corrected_for=len(found.effects) * found.agents,
            test=E_PROCESS if gap.course else _PAIRED if gap.pairs else PERMUTED,
        )
        for of, share in (("", gap.second), (CONTROL, gap.first)):
            yield from share_rows("success_in_pairs", share, **pair, of=of)


def _interaction(found: BlockMean, choices: int, **columns: Any) -> Estimate:
    return Estimate(
        quantity="success_interaction",
        **columns,
        **of_blocks(found),
        unit="points",
        family=_INTERACTIONS,
        corrected_for=choices,
        test="sign flips of blocks",
    )


def _crossings(found: Effects, doses: _Doses) -> Iterator[Estimate]:
    for one in found.interplays:
        crossing = one.crossing
        yield _interaction(
            one.change,
            one.choices,
            agent=found.agent,
            modality=found.modality,
            condition=crossing.both,
            control=crossing.neither,
            of=f"{crossing.first}{_BETWEEN}{crossing.second}",
            doses=doses[crossing.both],
        )


def _grids(others: ConditionStudySummary, doses: _Doses) -> Iterator[Row]:
    """The grids by their axis: its doses as facts, and what every agent did in the cells."""
    named = _named(others.design)
    for grid, axis in named:
        listed = (", ".join(f"{dose:g}" for dose in own) for own in (grid.row_doses, grid.column_doses))
        facts = dict(zip(("first doses", "second doses"), listed, strict=True))
        facts |= {"first dose": grid.rows.name, "second dose": grid.columns.name, "with": grid.rows.rest}
        yield from (Fact(about=axis, name=name, text=text) for name, text in facts.items() if text)
    for found in others.effects:
        for one in found.grids:
            axis = next(axis for grid, axis in named if grid == one.grid)
            yield from _grid(one, doses, {"agent": found.agent, "modality": found.modality, "axis": axis})


def _named(design: Design) -> list[tuple[Grid, str]]:
    """The grids of a study, each with a name that no other has."""
    named, known = [], Counter[tuple[str, str]]()
    for grid in (grid for modality in design.modalities for grid in design.comparison(modality).grids):
        name = grid.name, grid.rows.rest
        known[name] += 1
        named.append((grid, axis_key(grid.name, rest=grid.rows.rest, number=known[name])))
    return named


def _grid(found: GridSummary, doses: _Doses, of: Mapping[str, str]) -> Iterator[Estimate]:
    for cell in found.cells:
        place = {"condition": cell.condition, "doses": doses[cell.condition], "of": f"{cell.row:g}, {cell.column:g}"}
        yield from share_rows("success_in_grid", cell.success, **of, **place)
    if found.interaction is not None:
        yield _interaction(found.interaction, found.choices, **of)


def _answers(others: ConditionStudySummary) -> Iterator[Finding]:
    """How many of how many were detected, in the headings."""
    every = (*others.on_axes, *others.effects)
    of_conditions = [one for of in every if of.family != CONTROLS for one in of.effects]
    of_modalities = [one for of in every if of.family == CONTROLS for one in of.effects]
    from_control = " from the control" * bool(of_modalities)
    counts = [_counted(of_conditions, f"differences{from_control}"), _counted(of_modalities, "between modalities")]
    for section, quantity, said in (
        ("effects", "success_difference", " and ".join(filter(None, counts))),
        ("grids", "success_interaction", _counted([one for of in others.effects for one in of.grids], "interactions")),
        (
            "crossings",
            "success_interaction",
            _counted([one for of in others.effects for one in of.interplays], "interactions"),
        ),
    ):
        if said:
            yield Finding(section=section, kind="answer", text=f"{said} were detected.", rests_on=(quantity,))


def _counted(found: Sequence[Effect | GridSummary | Interplay], what: str) -> str:
    """How many of how many were detected; empty without any."""
    return f"{sum(one.detectable for one in found)} of {len(found)} {what}" if found else ""


def _effect_table(found: Results) -> TextTable:
    return compared_table(found, found.against_control()) if found.beside_flips else []


def compared_table(found: Results, rows: Sequence[Estimate]) -> TextTable:
    """Conditions that are compared with others, one row each."""
    table = [["agent", "condition", "control", "solved, control", "solved", "difference, points", "P", "conclusion"]]
    for row in rows:
        pair = {name: getattr(row, name) for name in ("agent", "modality", "condition", "control", "axis")}
        counts = [count_of(found.get("success_in_pairs", **pair, of=of)) for of in (CONTROL, "")]
        table.append([row.agent, row.condition, row.control, *counts, *_tested(row)])
    return table


def _tested(row: Estimate) -> list[str]:
    return [points_cell(row), p_cell(row.p_value), DETECTED[row.detected]]


def _crossing_table(found: Results) -> TextTable:
    if not found.beside_flips:
        return []
    names = {_BETWEEN.join(pair): pair for pair in permutations((one.name for one in found.design.conditions), 2)}
    head = ["agent", "first", "second", "both", "interaction, points", "P", "conclusion"]
    rows = found.where("success_interaction", axis="")
    return [head] + [[row.agent, *names[row.of], row.condition, *_tested(row)] for row in rows]


def _name(found: Results, axis: str) -> str:
    facts = found.facts_about(axis)
    return f"{facts['first dose']}{_BETWEEN}{facts['second dose']}"


def _grid_table(found: Results) -> TextTable:
    rows = found.where("success_in_grid")
    head = ["agent", "grid", "first dose", "second dose", "condition", "solved", "success"]
    table = [head] + [
        [
            row.agent,
            _name(found, row.axis),
            *row.of.split(", "),
            row.condition,
            count_of(row),
            f"{percent(row.value, 0)} [{percent(row.low, 0)}, {percent(row.high, 0)}]",
        ]
        for row in rows
    ]
    return table if rows else []


def _trend_table(found: Results) -> TextTable:
    """The interaction of every grid."""
    table = [["agent", "grid", "with", "blocks", "interaction, points", "P", "conclusion"]]
    for agent, modality, axis in dict.fromkeys((r.agent, r.modality, r.axis) for r in found.where("success_in_grid")):
        row = found.get("success_interaction", agent=agent, modality=modality, axis=axis)
        tested = ["0", NONE, NONE, NONE] if row is None else [str(row.n), *_tested(row)]
        table.append([agent, _name(found, axis), found.fact(axis, "with") or NONE, *tested])
    alone = {row[2] for row in table[1:]} <= {NONE}
    return [[*row[:2], *row[2 + alone :]] for row in table] if len(table) > 1 else []


def _applies(found: Results) -> bool:
    """Whether conditions beside flip rates were played; flip rates alone have a section of their own."""
    return found.beside_flips and bool(found.against_control())


_EFFECTS = Table("effects", _effect_table)
_CROSSINGS = Table("crossings", _crossing_table, numeric_from=4)
_GRIDS = Table("grids", _grid_table, numeric_from=5)
_TRENDS = Table("trends", _trend_table, numeric_from=3)


def _caption(found: Results) -> Caption:
    squares = bool(found.where("success_interaction", axis=""))
    return Caption(
        f"{'Circles: success' if squares else 'Success'} under each condition minus success under the control"
        f"{'. Squares: interactions of two interventions' * squares}; filled marks were detected.",
        f"Bars are 95 % intervals over matched pairs of trials, corrected for the number of conditions"
        f"{' (squares: of interactions)' * squares} and of agents. A difference is detected if the test rejects and "
        "the interval excludes 0.",
    )


_FIGURE = Figure(
    "effects",
    "Difference in success from the control, one row per condition",
    _caption,
    draw="lockprobe.report.figures.differences:effects",
    applies=_applies,
)


def _grid_caption(found: Results) -> Caption:
    agents = (row.agent for row in found.where("success_in_grid"))
    of = "Intervals, for one look," if found.progress.every_look else "Intervals"
    return Caption(
        "Share of trials solved under every combination of two doses, with count and interval where there is room. "
        "Darker cells are higher, crossed cells were not played, and the interaction is in points.",
        f"{share_intervals_said(agents, of)} Numbers are in per cent.",
    )


def _show(found: Results) -> Iterator[Part]:
    if not _applies(found):
        return
    note = Note(
        Markup(
            "Success under each condition and under the control, in the trials finished under both. "
            "<em>Not detected</em> does not show that there is no difference."
        ),
        Markup(
            "Trials of equal repetition and number use common random numbers under every condition (a block) and are "
            "compared in pairs. <i>P</i> is the larger of McNemar's exact one and that of the interval, both corrected "
            "for the number of conditions and of agents (baselines apart)."
        ),
        Markup(
            "Over the doses of an axis (flip rates, and doses of another intervention with three levels or more), and "
            "with people, a permutation within blocks stands in place of McNemar's test. Each axis is a family of its "
            "own, corrected for its doses and for agents, and so are the modalities. So other conditions change no "
            "<i>P</i> of theirs."
        ),
    )
    yield Part(
        "Every condition against the control",
        found.answer_of("effects"),
        [_FIGURE, Detail("All differences, with counts and tests", [_EFFECTS, note_at(found, note)])],
    )
    if axes := list(dict.fromkeys(row.axis for row in found.where("success_in_grid"))):
        yield Part("Interactions of doses", found.answer_of("grids"), list(_of_grids(axes)), "grids")
    if found.where("success_interaction", axis=""):
        note = Note(
            "Effect of the second intervention together with the first, minus its effect alone, in points. At 0 the "
            "effect of each does not depend on the other.",
            Markup(
                "Sign-flip permutation test over blocks; <i>P</i> and interval are corrected for the number of "
                "interactions and of agents."
            ),
        )
        yield Part("Interactions of interventions", found.answer_of("crossings"), [_CROSSINGS, note], "crossings")


def _of_grids(axes: Sequence[str]) -> Iterator[Block]:
    for number, axis in enumerate(axes, 1):
        alt = "Success under every combination of two doses, one cell each"
        yield Figure(
            f"grid-{number}", alt, _grid_caption, draw="lockprobe.report.figures.dose_grid:dose_grid", arguments=(axis,)
        )
    yield _TRENDS
    yield Note(
        "Interaction: effect of the whole range of the second dose at the highest dose of the first, minus its effect "
        "at the lowest, in points. At 0 the effect of each dose does not depend on the other.",
        Markup(
            "It is estimated from linear trends over all cells; with two doses each, it is the difference of "
            "differences. <i>P</i> and interval are corrected for the number of interactions and of agents."
        ),
        Markup(
            "Each block that has a trial in every cell gives one value; <i>P</i> is that of a sign-flip permutation "
            "test over blocks, and the interval is Student's, widened as if one more block differed."
        ),
    )
    yield Detail("All cells", [_GRIDS])


SECTIONS = (
    Section(
        name="effects",
        title="Every condition against the control",
        rows=_rows,
        show=_show,
        tables=(_EFFECTS, _CROSSINGS, _GRIDS, _TRENDS),
        figures=(_FIGURE,),
    ),
)
