"""Contrasts of conditions: those that the study file declares, interactions, and readings of a false report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, product
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed, percent
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.format import beside, p_head, tested
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import DECLARED, SIDES
from lockprobe.report.prose import interval_kind, inverted
from lockprobe.report.rows import Estimate, Fact, Results, Row, detected_said, measured_row
from lockprobe.report.section import Block, Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.contrast import declared, interactions
from lockprobe.statistics.design import READING_FACTORS, Crossed, axis_key
from lockprobe.statistics.every_look import E_PROCESS

ARROW, _TIMES = " \N{RIGHTWARDS ARROW} ", " \N{MULTIPLICATION SIGN} "


def contrast_head(rows: Sequence[Estimate]) -> list[str]:
    """Columns of a table of contrasts; agents stand there if they are several."""
    return ["agent", "contrast", "conditions", "success", "change, points", p_head(rows), "result", "blocks"]


BY_BLOCKS = Markup(
    "Each block of equal luck that has a trial under all of the conditions gives one value. The interval is "
    "Student\N{RIGHT SINGLE QUOTATION MARK}s over blocks, widened as if one more block differed; <i>P</i> is that of a "
    "sign-flip permutation test over blocks. Both are corrected for the number of contrasts and of agents (baselines "
    "apart)."
)
"""How a contrast of conditions is tested."""

_STUDENT = "Student over blocks"


def _declared_rows(numbers: OpenedStudy) -> Iterator[Row]:
    cells, asked = numbers.by_name, numbers.study.contrasts
    test = E_PROCESS if numbers.every_look else "sign flips of blocks"
    for agent, name, choices, (change, *sides) in declared(cells, asked, numbers.design):
        own = {"agent": agent, "modality": cells[agent, asked[name].of[0]].modality}
        quantity = f"{asked[name].measure}_difference"
        judged = {"family": DECLARED, "corrected_for": choices, "test": test if sides else _STUDENT, "unit": "points"}
        yield measured_row(quantity, change, **own, **judged, of=name)
        for side, share in zip(SIDES[::-1], sides, strict=False):
            yield measured_row("success_in_pairs", share, **own, of=f"{name}, {side}")


def _declared(found: Results) -> list[Estimate]:
    return [row for of in ("success", "misreading") for row in found.where(f"{of}_difference", family=DECLARED)]


def misreading_said(rows: Sequence[Estimate]) -> str:
    """Which contrasts change what is misread, for any agent, the largest change first."""
    clear = sorted((row for row in rows if row.detected), key=lambda row: -abs(row.value or 0.0))
    names, agents = [*dict.fromkeys(row.of for row in clear)], len({row.agent for row in rows})
    said = f"misreading changes with {listed(names)}" if names else "no change of misreading was detected"
    return f"{capital(f'for at least one of {agents} agents, ' * (agents > 1) + said)}."


def _declared_table(found: Results) -> Lines:
    known = found.design.contrasts
    rows = _declared(found)
    yield contrast_head(rows)
    for row in rows:
        less, more = (found.get("success_in_pairs", agent=row.agent, of=f"{row.of}, {side}") for side in SIDES)
        solved = ARROW.join(percent(share.value if share else None) for share in (less, more))
        conditions = ARROW.join(map(listed, (known[row.of].minus, known[row.of].of)))
        yield [row.agent, row.of, conditions, solved, *tested(beside(row, less, more)), str(row.clusters)]


CONTRASTS = Table("contrasts", _declared_table, 3, drawn="change, points", rare=("agent",))

_DECLARED_NOTE = Note(
    "Mean success, or misreading, under the conditions of one side minus that under those of the other, in points, as "
    "the study file declares it. Contrasts that were chosen after the results were seen prove nothing.",
    BY_BLOCKS
    + " Misreading: the share of statements about an attempt that contradict what happened, with Student's test.",
)


def _show_declared(found: Results) -> Iterator[Part]:
    if rows := _declared(found):
        yield Part("What the study asks", detected_said(rows, "contrasts"), [CONTRASTS, note_at(found, _DECLARED_NOTE)])


# Interactions: does the effect of one intervention, or of one dose, depend on another?


_CROSSED = "crossed doses"
"""What facts are about that name the two doses of a grid. Facts about the grid say under which condition a pair is."""


def _interactions(numbers: OpenedStudy) -> Iterator[Row]:
    if numbers.study.of_flips:
        return
    design, named, known = numbers.design, list[tuple[Crossed, str]](), Counter[tuple[str, str]]()
    for crossed in chain.from_iterable(design.crossed.values()):
        rest = crossed.axes[0].rest if crossed.axes else ""
        alone = [crossed.conditions.get(at, "") for at in ((1.0, 0.0), (0.0, 1.0))]
        name = _TIMES.join([one.name for one in crossed.axes] or alone)
        known[name, rest] += 1
        named.append((crossed, axis_key(name, rest=rest, number=known[name, rest])))
        if crossed.axes:
            yield Fact(about=_CROSSED, name=named[-1][1], text=name)
            for (row, column), condition in crossed.conditions.items():
                yield Fact(about=named[-1][1], name=f"{row:g}, {column:g}", text=condition)
    for agent, crossed, found, choices in interactions(numbers.by_name, design):
        axis = next(axis for one, axis in named if one == crossed)
        of: dict[str, Any] = {"agent": agent, "modality": crossed.modality, "axis": axis, "unit": "points"}
        of |= {"family": "interactions", "corrected_for": choices, "test": "sign flips of blocks"}
        yield measured_row("success_interaction", found, **of)


def _crossings(found: Results) -> Lines:
    rows = found.where("success_interaction", versus="")
    yield ["agent", "interaction of", "blocks", "interaction, points", p_head(rows), "conclusion"]
    for row in rows:
        yield [row.agent, row.axis, str(row.n), *tested(row)]


def _grid(found: Results, axis: str) -> Lines:
    """Success over two doses: for each agent a row a dose of the first, and a column a dose of the second."""
    own, (first, second) = found.facts_about(axis), found.fact(_CROSSED, axis).split(_TIMES)
    rows, columns = (sorted({name.split(", ")[i] for name in own}, key=float) for i in (0, 1))
    yield ["agent", first, *(f"{second} {column}" for column in columns)]
    shares = {(row.agent, row.condition): row for row in found.where("success", of="", control="", versus="", axis="")}
    for agent, row in product(dict.fromkeys(agent for agent, where in shares if where in own.values()), rows):
        yield [agent, row, *(shares.get((agent, own.get(f"{row}, {column}", ""))) for column in columns)]


_CROSSINGS = Table("crossings", _crossings)

_CROSSED_NOTE = Note(
    "Of two interventions: the effect of the second together with the first, minus its effect alone. Of two doses: "
    "the effect of the whole range of the second at the highest dose of the first, minus its effect at the lowest. At "
    "0 the effect of each does not depend on the other.",
    BY_BLOCKS,
)


def _show_crossings(found: Results) -> Iterator[Part]:
    grids = (Table("", partial(_grid, axis=axis)) for axis in found.facts_about(_CROSSED))
    tables = [table for table in grids if table.cells(found)]
    note = Note(f"Share of trials solved under every combination of two doses. Brackets are {interval_kind(found)}.")
    rows = found.where("success_interaction", versus="")
    blocks: list[Block] = [*tables, note] if tables else []
    blocks += [_CROSSINGS, _CROSSED_NOTE] if rows else []
    if blocks:
        yield Part("Interactions", detected_said(rows, "interactions"), blocks)


# Readings: what a false report is, and what that changes.

_BOTH_FIT = "The paper does not say which of these false reports it has; its numbers fit agents under each."
"""Of several readings (``docs/readings.md``)."""

_ONE = "Whether other false reports do the same is not tested (--flip re-observed,integrated)."


def _what_is_false(numbers: OpenedStudy) -> Iterator[Row]:
    study = numbers.study
    positions = any(map(tells_positions, study.modalities))
    if not any(study.p) or not positions:
        return
    said = f"The flip rate is the probability that {inverted(study.flip, positions=positions)}."
    yield Fact(about="readings", name="what", text=said)


_READINGS_NOTE = Note(
    "Differences are within pairs of trials at the same flip rate.",
    Markup(
        "<i>P</i> is the larger of McNemar's exact one and that of the interval, corrected for all flip rates and for "
        "the agents (baselines apart)."
    ),
)


def _show_readings(found: Results) -> Iterator[Part]:
    if not (what := found.fact("readings", "what")):
        return
    answer = capital(what.removeprefix("The flip rate is the probability that "))
    rows = found.where("success_difference", of="", versus="")
    if compared := [row for row in rows if row.axis in READING_FACTORS]:
        said: list[Block] = [_BOTH_FIT, detected_said(compared, "differences between readings"), _READINGS_NOTE]
    else:
        said = [_ONE] * (len({one.axis.options for one in found.design.axes if one.axis.of_flips}) < 2)
    yield Part("What is a false report here?", answer, said)


SECTIONS = (
    Section("contrasts", "Declared contrasts", _declared_rows, _show_declared, (CONTRASTS,)),
    Section("crossings", "Interactions", _interactions, _show_crossings, (_CROSSINGS,)),
    Section("readings", "What a false report is", _what_is_false, _show_readings),
)
