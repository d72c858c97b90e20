"""All conditions: what each agent did under each, what acted there, and what it changes against the control."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import chain
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.formatting import p_cell, percent, range_of
from lockprobe.foundation.plugins import find_plugin, plugin_names
from lockprobe.report.format import alone, count_of, p_head, tested
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import CONTROL, changes_from_control
from lockprobe.report.prose import chance_said, condition_words, interval_kind, told_apart
from lockprobe.report.rows import (
    BOUNDS,
    MEASURES,
    Estimate,
    Fact,
    Results,
    Row,
    detected_said,
    measured_row,
    share_rows,
    who,
)
from lockprobe.report.section import Block, Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.contrast import effects
from lockprobe.statistics.design import LEVELS, READING_FACTORS
from lockprobe.statistics.measures import find_measure, measured
from lockprobe.statistics.outcomes import never_acted, points, steps_changed


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        yield cell.estimate("trials", len(cell.ended), unit="trials")
        share = cell.success
        yield from cell.share("success", share, note="never acted" if never_acted(cell.trials) else "")
        if share.broken and share.n:
            for end, bound in zip(BOUNDS, share.bounds, strict=True):
                yield cell.estimate("success", bound, of=end, n=share.n + share.broken)
        for point in points(cell.ended):
            yield cell.estimate("success", point.success, n=point.n, of=f"rep={point.repetition}")
        yield cell.estimate("broken", len(cell.outcomes.broken), unit="trials")
        boundaries = Counter(trial.error.boundary for trial in cell.trials if trial.error)
        for boundary, count in sorted(boundaries.items()):
            yield cell.estimate("broken", count, of=boundary, unit="trials")
        steps = int(cell.ended.length.sum())
        yield cell.estimate("steps", steps, unit="steps")
        for spec, changed in (steps_changed(cell.trials) or {}).items():
            of = f"changed by {spec}" if spec else "changed"
            yield cell.estimate("steps", changed, of=of, unit="steps", n=steps)


def _effects(numbers: OpenedStudy) -> Iterator[Row]:
    """Success under conditions minus success under another one, and both shares."""
    for one in () if numbers.study.of_flips else effects(numbers.by_name, numbers.design):
        gap, condition = one.difference, numbers.study.labelled(one.condition)
        pair: dict[str, Any] = {"agent": one.agent, "modality": condition.modality, "axis": one.factor}
        pair |= {"condition": one.condition, "control": one.control, "doses": dict(condition.doses)}
        judged = {"family": one.family, "corrected_for": one.corrected_for, "test": gap.test}
        yield measured_row("success_difference", gap, **pair, **judged, n=gap.first.n, unit="points")
        yield from share_rows("success_in_pairs", gap.second, **pair)
        yield from share_rows("success_in_pairs", gap.first, **pair, of=CONTROL)


def _compared(found: Results) -> tuple[list[Estimate], list[Estimate]]:
    """Conditions against their control; and levels of one option, such as readings of a false report, with each other.

    None of a study of flip rates alone, which have a question of their own.
    """
    levels = [row for row in found.where("success_difference", of="", versus="") if row.family.startswith(LEVELS)]
    return (found.against_control(), levels) if found.beside_flips else ([], [])


def _effects_table(found: Results) -> Lines:
    words, rows = condition_words(found), [*chain(*_compared(found))]
    head = ["agent", "condition", "control", "solved, control", "solved", "difference, points"]
    yield [*head, p_head(rows), "conclusion"]
    for row in rows:
        pair = {name: getattr(row, name) for name in ("agent", "modality", "condition", "control", "axis")}
        counts = [count_of(found.get("success_in_pairs", **pair, of=of)) for of in (CONTROL, "")]
        yield [who(row.agent), words[row.condition], words[row.control], *counts, *tested(row)]


def _table(found: Results) -> Lines:
    """Every agent under every condition, and its change from the control; one that plays alike at every rate once."""
    apart, under = told_apart(found.cells)
    head = ["agent", apart, "trials", "success", "change, points", "P", "mean steps", "loop rate"]
    yield [*head, "by chance", *_RARE]
    changes, once = changes_from_control(found), set[tuple[str, str]]()
    for cell in found.cells:
        if cell.blind and (cell.agent, cell.modality) in once:
            continue
        once.add((cell.agent, cell.modality))
        change, acted = changes.get((cell.agent, cell.condition)), cell.get("steps", "changed")
        broke = cell.get("against_rules")
        yield [
            cell.label, "every flip rate" if cell.blind else under(cell), str(cell.trials), cell.get("success"), change,
            p_cell(change.p_value if change else None), cell.get("mean_steps_all"), cell.get("loop_rate"),
            chance_said(cell), alone(cell.get("misread")),
            alone(cell.get("optimal_actions", "naive")),
            percent((acted.value or 0.0) / acted.n) if acted and acted.n else None,
            count_of(broke) if broke and broke.count else None, f"{cell.value('broken') or 0:g}",
        ]  # fmt: skip


_RARE = ("misread", "optimal", "acted in", "against the rules", "broken")


def _measures(found: Results) -> Lines:
    """The measures of installed packages."""
    yield ["agent", "condition", "measure", "what it is", "trials", "mean [95 % interval]"]
    for row in found.measures:
        name = row.quantity.removeprefix(f"{MEASURES}.")
        yield [row.agent, row.condition, name, row.note or found.fact(MEASURES, name), str(row.n), row]


def measure_rows(numbers: OpenedStudy) -> Iterator[Row]:
    """The mean of each measure of an installed package with its 95 % interval; of one that breaks, why.

    No code of a package runs if the opened study holds what they measured.
    """
    if numbers.measured is not None:
        yield from numbers.measured
        return
    described: dict[str, Fact] = {}
    names = plugin_names("measure")
    for cell in numbers.cells if names else ():
        trials = [*numbers.records(cell.trials)]
        for name in names:
            plugin = find_plugin("measure", name)
            source, quantity = plugin.package if plugin else name, f"{MEASURES}.{name}"
            try:
                found = measured(trials, find_measure(name))
            except UserMistake as error:
                yield cell.estimate(quantity, n=0, unit="", note=str(error), source=source)
            else:
                unit = "share" if found.kind == "share" else ""
                yield measured_row(quantity, found, **cell.of, unit=unit, source=source)
                described[name] = Fact(about=MEASURES, name=name, text=found.what, source=source)
    yield from described.values()


_CONDITIONS, _MEASURES = Table("conditions", _table, rare=_RARE), Table("measures", _measures, 4)

EFFECTS = Table("effects", _effects_table, 3, drawn="difference, points")
"""Every condition against its control, and levels of one option against the first."""


def _answer(found: Results) -> str:
    """How many changes were detected, or between which shares all conditions of all agents lie."""
    shares = [row.value for row in found.where("success", of="") if row.value is not None and row.condition]
    changes, levels = _compared(found)
    said = detected_said(changes, "changes of an agent under a condition")
    others = [row for row in levels if row.axis not in READING_FACTORS]  # readings have a question of their own
    said = " ".join(filter(None, (said, detected_said(others, "differences between levels of an option"))))
    if said or not shares:
        return said
    low, high = min(shares), max(shares)
    return f"{percent(low) if low == high else range_of(low, high)} of trials solved."


_PAIRED = Note(
    Markup("<em>Not detected</em> does not show that there is no difference."),
    "Trials of equal repetition and number use common random numbers under every condition (a block) and are compared "
    "in pairs.",
    Markup(
        "<i>P</i> is the larger of McNemar's exact one (over the doses of an axis, that of a permutation within "
        "blocks; with people there is none) and that of the interval. Each axis is a family of its own, so are the "
        "modalities and all other conditions; <i>P</i> is corrected for its members and for agents (baselines apart)."
    ),
)

_MEANS = Note(
    "Measures of installed packages: means over trials with 95 % intervals.",
    "Intervals of shares are Wilson intervals, clustered by person for people; those of means are Student's, clustered "
    "by block or by person.",
)


def _show(found: Results) -> Iterator[Part]:
    one_look = " Those of loop rates hold for one look." * bool(found.progress.every_look)
    told = Note(
        "Every agent under every condition; the change is from the control, in the trials finished under both.",
        f"Intervals of success and loop rate are {interval_kind(found)}.{one_look}",
        "Mean steps: an unsolved trial counts with its whole budget. By chance: loop rate of random actions in trials "
        "of the same lengths, from uniform to without immediate repeats. Misread: claims about the last action that "
        "contradict the report. Optimal: actions that an ideal observer would have chosen too. Acted in: steps in "
        "which the condition changed something.",
    )
    blocks: list[Block] = [_CONDITIONS, told, *[note_at(found, _PAIRED)] * bool(found.against_control())]
    blocks += [EFFECTS] if _compared(found)[1] else []
    blocks += [_MEASURES, _MEANS] if found.measures else []
    yield Part("All conditions", _answer(found), blocks)


SECTIONS = (
    Section("conditions", "All conditions", _rows, _show, (_CONDITIONS, EFFECTS, _MEASURES)),
    Section("effects", "Every condition against the control", _effects),
    Section("measures", "Measures", measure_rows),
)
