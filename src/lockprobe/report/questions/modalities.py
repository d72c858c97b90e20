"""Modalities: whether what an agent is shown of the box changes how soon, and how often, it solves it."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.foundation.formatting import p_cell, p_value
from lockprobe.report.format import TextTable
from lockprobe.report.prose import Subject
from lockprobe.report.rows import Estimate, Results
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, measured_row
from lockprobe.report.table_rows import points_cell, value_cell
from lockprobe.statistics.conditions.modalities import fidelity, spoken
from lockprobe.statistics.conditions.modality_effect import modality_effects
from lockprobe.statistics.proportions import ALPHA

_PAIRS = "every two modalities"


def _rows(numbers: StudyNumbers) -> Iterator[Estimate]:
    for effect in modality_effects(numbers.courses):
        ranks = {fidelity(modality) for modality in effect.modalities} - {None}
        yield measured_row(
            "modality_effect", effect.trend, agent=effect.agent, of="trend over fidelity", value=effect.trend.direction,
            unit="direction", test="log-rank", corrected_for=effect.agents,
            note="" if len(ranks) > 1 else "equal fidelity",
        )  # fmt: skip
        tested = {"test": "log-rank", "corrected_for": len(effect.pairs) * effect.agents}
        for pair in effect.pairs:
            of = {"agent": effect.agent, "modality": pair.second, "family": _PAIRS}
            of |= {"versus": effect.agent, "versus_modality": pair.first}
            yield measured_row("hazard_ratio", pair.hazard, **of, of="modalities", unit="ratio", **tested)
            yield measured_row("success_difference", pair.final, **of, unit="points", test="McNemar")


def _table(found: Results) -> TextTable:
    table = [["agent", "compared with", "hazard ratio of solving", "log-rank, Holm", "success, points", "McNemar"]]
    for row in found.where("hazard_ratio", of="modalities"):
        final = found.one("success_difference", **row.pair, family=_PAIRS)
        both = f"{row.agent} ({spoken(row.modality)})", spoken(row.versus_modality)
        tested = [value_cell(row), p_cell(row.p_value), points_cell(final), p_cell(final.p_value)]
        table.append([*both, *tested])
    return table if len(table) > 1 else []


def effect_said(found: Results, row: Estimate) -> str:
    """The trend over fidelity; without one whether any two modalities differ."""
    who = Subject.of(row.agent)
    solves = f"{who.form('solves', 'solve')} the box"
    if row.p_value is not None and row.p_value < ALPHA:
        how = "sooner" if (row.value or 0) > 0 else "later or more rarely"
        return f"The higher the fidelity of what is shown, the {how} {who.name} {solves} ({p_value(row.p_value)})."
    pairs = found.where("hazard_ratio", agent=row.agent, of="modalities")
    if any(one.p_value is not None and one.p_value < ALPHA for one in pairs):
        return f"How soon {who.name} {solves} differs between modalities."
    if all(one.p_value is None for one in (row, *pairs)):
        return f"Too few trials ended to test whether the modality changes how soon {who.name} {solves}."
    tested = "" if row.p_value is None else f" ({p_value(row.p_value)})"
    return f"No effect of the modality on how soon {who.name} {solves} was detected{tested}."


_PAIRS_TABLE = Table("modalities", _table)


def _show(found: Results) -> Iterator[Part]:
    if effects := found.where("modality_effect"):
        note = Note(
            "A ratio above one: the first named is faster. With 10 trials in each modality the power to detect the "
            "paper's trend is 13 % (95 % interval 12 to 14 %).",
            "Log-rank tests of the step that solves the box, clustered by block: trials of equal repetition and number "
            "use common random numbers in all modalities. P values of these are corrected for the pairs and for the "
            "number of agents; McNemar's, of solved and unsolved trials in the same pairs, are not.",
            Markup(
                "The 13 % are simulated for agents that solve 80 % of their trials by steps 11, 13 and 15, about as in "
                "the paper (<code>benchmarks/modality_rates.py --lapses 0.12 0.2 0.3 --trials 10 --shared 0 --studies "
                "3000</code>)."
            ),
        )
        yield Part(
            "What does the modality change?",
            " ".join(effect_said(found, row) for row in effects[:2]),
            [_PAIRS_TABLE, note],
        )


SECTIONS = (Section(name="modalities", title="Modalities", rows=_rows, show=_show, tables=(_PAIRS_TABLE,)),)
