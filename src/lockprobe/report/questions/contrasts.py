"""Contrasts of conditions: those that the study file declares, interactions, and readings of a false report."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, product
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed, p_value, percent
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.format import entry_text, tested
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import DECLARED, SIDES
from lockprobe.report.prose import interval_kind, inverted, who
from lockprobe.report.rows import Estimate, Fact, Results, Row, detected_said, measured_row
from lockprobe.report.section import Block, Figure, Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.contrast import declared, interactions
from lockprobe.statistics.design import READING_FACTORS, Crossed, axis_key
from lockprobe.statistics.every_look import E_PROCESS

ARROW, _TIMES = " \N{RIGHTWARDS ARROW} ", " \N{MULTIPLICATION SIGN} "

CONTRAST = ["agent", "contrast", "conditions", "success", "change, points", "P", "result", "blocks"]
"""Columns of a table of contrasts; agents stand there if they are several."""

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
    yield CONTRAST
    for row in _declared(found):
        shares = (found.get("success_in_pairs", agent=row.agent, of=f"{row.of}, {side}") for side in SIDES)
        solved = ARROW.join(percent(share.value if share else None) for share in shares)
        conditions = ARROW.join(map(listed, (known[row.of].minus, known[row.of].of)))
        yield [row.agent, row.of, conditions, solved, *tested(row), str(row.clusters)]


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
        for (row, column), condition in crossed.conditions.items() if crossed.axes else ():
            yield Fact(about=named[-1][1], name=f"{row:g}, {column:g}", text=condition)
    for agent, crossed, found, choices in interactions(numbers.by_name, design):
        axis = next(axis for one, axis in named if one == crossed)
        of: dict[str, Any] = {"agent": agent, "modality": crossed.modality, "axis": axis, "unit": "points"}
        of |= {"family": "interactions", "corrected_for": choices, "test": "sign flips of blocks"}
        yield measured_row("success_interaction", found, **of)


def _crossings(found: Results) -> Lines:
    yield ["agent", "interaction of", "blocks", "interaction, points", "P", "conclusion"]
    for row in found.where("success_interaction", versus=""):
        yield [row.agent, row.axis, str(row.n), *tested(row)]


def draw(found: Results, axis: str) -> Any:
    """Success over two doses, a panel for each agent with a cell for each combination: darker is more."""
    import matplotlib as mpl
    from matplotlib.patches import Rectangle

    from lockprobe.report.figures import drawing as figures

    own, named = found.facts_about(axis), re.sub(r" \(\d+\)$", "", axis.partition(", with ")[0])
    first, second = named.split(_TIMES)
    rows, columns = (sorted({name.split(", ")[i] for name in own}, key=float) for i in (0, 1))
    lines = 3 if len(columns) <= 4 else 2 if len(columns) <= 6 else 1  # room for the share, its count, its interval

    def on(axes: Any, player: tuple[str, str]) -> None:
        agent, modality = player
        for (i, row), (j, column) in product(enumerate(rows), enumerate(columns)):
            where = own.get(f"{row}, {column}", "")
            cell = found.get("success", agent=agent, condition=where, control="", versus="", axis="") if where else None
            face: Any = "white"
            colour, text = figures.FAINT, "\N{MULTIPLICATION SIGN}"  # not played
            if cell:
                share = cell.value or 0.0
                face, colour = mpl.colormaps["Blues"](0.85 * share), "white" if share > 0.78 else figures.INK
                ends = f"[{100 * (cell.low or 0):.0f}, {100 * (cell.high or 0):.0f}]"
                said = [percent(cell.value), f"{cell.count}/{cell.n}", ends][:lines]
                text = "\n".join(said) if lines > 1 else said[0].removesuffix(" %")
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=face, edgecolor="white", linewidth=1.5))
            axes.text(j, i, text, ha="center", va="center", color=colour, linespacing=1.15)
        axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
        figures.axis(axes, "x", range(len(columns)), columns, figures.axis_label(second), bare=True)
        figures.axis(axes, "y", range(len(rows)), rows, figures.axis_label(first), bare=True)
        change = found.get("success_interaction", agent=agent, modality=modality, axis=axis, versus="")
        interaction = "interaction not estimated"
        if change is not None:
            tested = f", {p_value(change.p_value, '$P$')}" * (change.p_value is not None)
            interaction = f"interaction {entry_text(change)} points{tested}"
        figures.title(axes, figures.safe_name(who(agent), 38), interaction)

    shares = [row for row in found.where("success", of="", axis="") if row.condition in own.values()]
    agents = list(dict.fromkeys((row.agent, row.modality) for row in shares))
    return figures.sheet(agents, on, height=0.35 + len(rows) * 0.155 * (lines + 0.9))


_CROSSINGS = Table("crossings", _crossings)

_CROSSED_NOTE = Note(
    "Of two interventions: the effect of the second together with the first, minus its effect alone. Of two doses: "
    "the effect of the whole range of the second at the highest dose of the first, minus its effect at the lowest. At "
    "0 the effect of each does not depend on the other.",
    BY_BLOCKS,
)


def _show_crossings(found: Results) -> Iterator[Part]:
    played = {row.condition for row in found.where("success", of="")}
    caption = Note(
        "Share of trials solved under every combination of two doses, with count and interval where there is room. "
        "Darker cells are higher, crossed cells were not played, and the interaction is in points.",
        f"Intervals are {interval_kind(found)}. Numbers are in per cent.",
    )
    alt = "Success under every combination of two doses, one cell each"
    grids = dict.fromkeys(fact.about for fact in found.facts if _TIMES in fact.about)
    shown = [axis for axis in grids if played & {*found.facts_about(axis).values()}]
    blocks: list[Block] = [
        Figure(f"grid-{number}", alt, caption, partial(draw, axis=axis)) for number, axis in enumerate(shown, 1)
    ]
    rows = found.where("success_interaction", versus="")
    if blocks or rows:
        blocks += [_CROSSINGS, _CROSSED_NOTE] * bool(rows)
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
        said = [_ONE] * (len({one.axis.options for one in found.design.axes if one.of_flips}) < 2)
    yield Part("What is a false report here?", answer, said)


SECTIONS = (
    Section("contrasts", "Declared contrasts", _declared_rows, _show_declared, (CONTRASTS,)),
    Section("crossings", "Interactions", _interactions, _show_crossings, (_CROSSINGS,)),
    Section("readings", "What a false report is", _what_is_false, _show_readings),
)
