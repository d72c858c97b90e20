"""Agents compared under each condition that is no flip rate, and in how much the condition changes each of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, p_cell
from lockprobe.report.every_look import note_at
from lockprobe.report.format import DETECTED, TextTable
from lockprobe.report.prose.subject import Subject
from lockprobe.report.questions.agents_compared import FAMILIES, at_one_condition, change_at, labels
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell, steps_cell
from lockprobe.statistics.conditions.agents_by_condition import ComparisonUnder
from lockprobe.trial.condition import Condition

_NAME = "agents_by_condition"
_APART, _CHANGED = "success_difference", "success_change_difference"

_NAMED = 3
"""Differences that a sentence names."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    compared = numbers.others.agents_compared if numbers.others else ()
    found = [row for one in compared for row in _of_pair(one, numbers.conditions[one.condition])]
    yield from found
    tested = {
        quantity: own
        for quantity in (_APART, _CHANGED)
        if (own := [row for row in found if row.quantity == quantity and not row.of])
    }
    for quantity, own in tested.items():
        if said := _clearest(own):
            yield Finding(section=_NAME, kind=quantity, text=said, rests_on=(quantity,))
    if tested:
        counts = [f"{sum(row.detected for row in own)} of {len(own)} {_WHAT[name]}" for name, own in tested.items()]
        yield Finding(
            section=_NAME, kind="answer", text=f"{' and '.join(counts)} were detected.", rests_on=tuple(tested)
        )


def _of_pair(one: ComparisonUnder, condition: Condition) -> Iterator[Estimate]:
    """Two agents under a condition, and how much more it changes the one."""
    (agent, modality), (versus, shown) = one.pair.second, one.pair.first
    of = {
        "agent": agent,
        "modality": modality,
        "versus": versus,
        "versus_modality": shown,
        "condition": one.condition,
        "doses": dict(condition.doses),
        "family": f"{FAMILIES[one.pair.among]}, {one.axis or 'conditions'}",
    }
    yield from at_one_condition(one.at, of, one.tests, people=one.pair.people, every_look=one.pair.every_look)
    if (moved := one.change) is not None:
        p_values = {"": (one.change_adjusted, one.changes), "uncorrected": (moved.p_value, 1)}
        for part, (p_value, many) in p_values.items():
            own = of | {"control": one.control, "of": part, "corrected_for": many}
            yield change_at(moved.at[0], own, p_value, people=one.pair.people)


_WHAT = {_APART: "differences between agents", _CHANGED: "differences in the effect of a condition"}


def _clearest(rows: Sequence[Estimate]) -> str:
    """The clearest differences that were detected, of models with each other before those with baselines."""
    found = [row for row in rows if row.detected]
    baseline = FAMILIES["reference"]
    found.sort(key=lambda row: (row.family.startswith(baseline), row.p_value or 0.0, -abs(row.value or 0.0)))
    if not found:
        return ""
    several = len(found) > _NAMED
    each = _one_apart if found[0].quantity == _APART else _one_changed
    return capital(f"{'the clearest: ' * several}{'; '.join(each(row) for row in found[:_NAMED])}.")


def _one_apart(row: Estimate) -> str:
    first, second = _names(row)
    more = "more" if (row.value or 0.0) > 0 else "fewer"
    return f"under {row.condition} {first} solved {more} trials than {second} ({points_cell(row)} points)"


def _one_changed(row: Estimate) -> str:
    first, second = _names(row)
    higher = "higher" if (row.value or 0.0) > 0 else "lower"
    return f"the effect of {row.condition} on {first} is {higher} than on {second} ({points_cell(row)} points)"


def _names(row: Estimate) -> tuple[str, str]:
    first = Subject.seeing(row.agent, row.modality)
    return first.name, Subject.seeing(row.versus, row.versus_modality).name


def _of(found: Results, quantity: str) -> list[Estimate]:
    """The rows of a quantity under conditions that are no flip rates."""
    rates = {one.name: one.p for one in found.design.conditions}
    rows = found.where(quantity, of="", axis="")
    return [row for row in rows if row.versus and row.family and rates.get(row.condition, 0.0) is None]


def _table(found: Results) -> TextTable:
    head = ["agent", "compared with", "condition", "pairs of trials", "solved only by the first"]
    head += ["solved only by the other", "difference, points", "McNemar", "corrected P", "conclusion"]
    table = [[*head, "difference in steps"]]
    for row in _of(found, _APART):
        of = row.pair | {"condition": row.condition, "control": ""}
        counts = (found.one("solved_by_one_only", **of, of=part).count for part in ("only", "only the other"))
        steps = found.one("steps_difference", **of)
        uncorrected = found.one(_APART, **of, of="uncorrected")
        p_values = (p_cell(one.p_value) for one in (uncorrected, row))
        table.append(
            [
                *labels(found, row.pair), row.condition, str(row.n), *map(str, counts), points_cell(row), *p_values,
                DETECTED[row.detected], steps_cell(steps),
            ]
        )  # fmt: skip
    return table if len(table) > 1 else []


def _change_table(found: Results) -> TextTable:
    head = ["agent", "compared with", "condition", "control", "blocks", "difference in effect, points", "P"]
    table = [[*head, "corrected P", "conclusion"]]
    for row in _of(found, _CHANGED):
        of = row.pair | {"condition": row.condition, "control": row.control}
        p_values = (p_cell(one.p_value) for one in (found.one(_CHANGED, **of, of="uncorrected"), row))
        names = [*labels(found, row.pair), row.condition, row.control]
        table.append([*names, str(row.n), points_cell(row), *p_values, DETECTED[row.detected]])
    return table if len(table) > 1 else []


_COMPARISONS = Table("comparisons-by-condition", _table, numeric_from=3)
_CHANGES = Table("changes-by-condition", _change_table, numeric_from=4)


def _caption(found: Results) -> Caption:
    shown = "Differences in success between two agents under each condition, the first minus the other"
    if _of(found, _CHANGED):
        shown += ", and beside or below how much more the condition changes the success of the first"
    return Caption(
        f"{shown}. Filled marks were detected.",
        "Bars are 95 % intervals that are not corrected; a difference is detected if its bar leaves out 0 and the "
        "test, corrected for its family, rejects.",
    )


_FIGURE = Figure(
    "agents-by-condition",
    "Differences between two agents under each condition, and in how much the condition changes them",
    _caption,
    draw="lockprobe.report.figures.differences:by_condition",
)


def _show(found: Results) -> Iterator[Part]:
    if not _of(found, _APART):
        return
    said = [Text(text) for quantity in (_APART, _CHANGED) for text in found.said(_NAME, quantity)]
    changes = [_CHANGES] if _of(found, _CHANGED) else []
    effect = " Difference in effect: how much more the condition changes the success of the first." * bool(changes)
    flips = "; effect: sign flips of blocks" * bool(changes)
    note = Note(
        "Success and steps of the first agent minus those of the second, over the trials that both finished under the "
        f"condition.{effect}",
        f"Success: McNemar's exact test (with people: a permutation of whole people){flips}.",
        Markup(
            "<i>P</i> is corrected for all pairs of agents and conditions of a modality (Holm); the doses of an axis "
            "are a family of their own, and so are pairs with baselines. Two agents that <em>both</em> play alike "
            "under a condition and its control are compared under the control alone."
        ),
    )
    folded = Detail("Pairs of agents under each condition, in numbers", [_COMPARISONS, *changes, note_at(found, note)])
    yield Part("Agents compared under other conditions", found.answer_of(_NAME), [*said, _FIGURE, folded])


SECTIONS = (
    Section(
        name=_NAME,
        title="Agents compared under other conditions",
        rows=_rows,
        show=_show,
        tables=(_COMPARISONS, _CHANGES),
        figures=(_FIGURE,),
    ),
)
