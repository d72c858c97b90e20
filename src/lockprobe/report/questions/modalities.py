"""Modalities: whether what an agent is shown of the box changes how soon, and how often, it solves it."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.formatting import p_cell, p_value
from lockprobe.report.format import Entry
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import who
from lockprobe.report.rows import Estimate, Results, measured_row
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.statistics.hazards import modality_effects
from lockprobe.statistics.modalities import fidelity, spoken
from lockprobe.statistics.proportions import ALPHA

_PAIRS = "every two modalities"


def _rows(numbers: OpenedStudy) -> Iterator[Estimate]:
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


def _table(found: Results) -> list[list[Entry]]:
    head: list[Entry] = ["agent", "compared with", "hazard ratio of solving", "log-rank, Holm", "success, points"]
    rows: list[list[Entry]] = []
    for row in found.where("hazard_ratio", of="modalities"):
        final = found.one("success_difference", **row.pair, family=_PAIRS)
        both = f"{row.agent} ({spoken(row.modality)})", spoken(row.versus_modality)
        rows.append([*both, row, p_cell(row.p_value), final, p_cell(final.p_value)])
    return [[*head, "McNemar"], *rows] if rows else []


def effect_said(found: Results, row: Estimate) -> str:
    """The trend over fidelity; without one whether any two modalities differ."""
    solves = f"how soon the box is solved by {who(row.agent)}"
    pairs = found.where("hazard_ratio", agent=row.agent, of="modalities")
    if row.p_value is not None and row.p_value < ALPHA:
        how = "sooner" if (row.value or 0) > 0 else "later or more rarely"
        by = f"the box is solved by {who(row.agent)} ({p_value(row.p_value)})"
        return f"The higher the fidelity of what is shown, the {how} {by}."
    if any(one.p_value is not None and one.p_value < ALPHA for one in pairs):
        return f"The modality changes {solves}, in no order of fidelity."
    if all(one.p_value is None for one in (row, *pairs)):
        return f"Too few trials ended to test whether the modality changes {solves}."
    tested = "" if row.p_value is None else f" ({p_value(row.p_value)})"
    return f"No effect of the modality on {solves} was detected{tested}."


_PAIRS_TABLE = Table("modalities", _table)

_NOTE = Note(
    "A ratio above one: the first named is faster. With 10 trials in each modality the power to detect the paper's "
    "trend is 13 % (95 % interval 12 to 14 %; simulated for agents that solve 80 % by steps 11, 13 and 15).",
    "Log-rank tests of the step that solves the box, clustered by block: trials of equal repetition and number use "
    "common random numbers in all modalities. P values of these are corrected for the pairs and for the number of "
    "agents; McNemar's, of solved and unsolved trials in the same pairs, are not.",
    "The power is that of benchmarks/modality_rates.py --lapses 0.12 0.2 0.3 --trials 10 --shared 0 --studies 3000.",
)


def _show(found: Results) -> Iterator[Part]:
    if effects := found.where("modality_effect"):
        said = " ".join(effect_said(found, row) for row in effects[:2])
        yield Part("What does the modality change?", said, [_PAIRS_TABLE, _NOTE])


SECTIONS = (Section(name="modalities", title="Modalities", rows=_rows, show=_show, tables=(_PAIRS_TABLE,)),)
