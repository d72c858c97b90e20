"""All conditions: success of every agent under every condition, what acted there, and what packages measure."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter

from lockprobe.foundation.formatting import NONE, percent
from lockprobe.report.captions import success_and_loops_said
from lockprobe.report.format import TextTable
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.rows import MEASURES, Cell, Estimate, Results, Row
from lockprobe.report.section import Block, Heading, Note, Part, Section, Table
from lockprobe.report.study_numbers import BOUNDS, PlayedCell, StudyNumbers
from lockprobe.report.table_rows import chance_cell, share_of_row, value_cell

_AGAINST = "against the rules"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        yield from _of_cell(cell)


def _of_cell(cell: PlayedCell) -> Iterator[Estimate]:
    found = cell.summary
    yield cell.estimate("trials", found.success.n, unit="trials")
    yield from cell.share("success", found.success, note="never acted" if found.never_acted else "")
    if (share := found.success).broken and share.n:
        for end, bound in zip(BOUNDS, share.bounds, strict=True):
            yield cell.estimate("success", bound, of=end, n=share.n + share.broken)
    for point in found.points:
        of = f"rep={point.repetition}"
        yield cell.estimate("success", point.success, n=point.n, of=of)
        yield cell.estimate("loop_rate", point.loop_rate, n=point.n, of=of)
    yield cell.estimate("broken", sum(found.errors.values()), unit="trials")
    for boundary, count in found.errors.items():
        yield cell.estimate("broken", count, of=boundary, unit="trials")
    yield cell.estimate("distinct_sequences", found.distinct_sequences, unit="sequences", n=found.success.n)
    yield cell.estimate("steps", found.steps, unit="steps")
    if found.changed is not None:
        yield cell.estimate("changed_steps", found.changed.changed, unit="steps", n=found.changed.steps)
        for spec, changed in found.changed.by_intervention.items():
            yield cell.estimate("changed_steps", changed, of=spec, unit="steps", n=found.changed.steps)
    if (rules := found.rules) is not None and rules.attempts:
        n, count = rules.attempts, rules.against
        yield cell.estimate("against_rules", count / n, count=count, n=n)


def _table(found: Results) -> TextTable:
    return _by_conditions(found) if found.beside_flips else _by_flip_rate(found)


def _by_flip_rate(found: Results) -> TextTable:
    head = ["agent", "modality", "flip rate", "trials", "solved", "success", "loop rate", "by chance", "coverage"]
    table = [[*head, "redundant", _AGAINST, "errors"]]
    table += [
        [
            cell.agent,
            cell.modality,
            f"{cell.p:g}",
            str(cell.trials),
            str(success.count if (success := cell.get("success")) else 0),
            share_of_row(success),
            share_of_row(cell.get("loop_rate")),
            chance_cell(cell),
            percent(cell.value("coverage"), 0),
            percent(cell.value("redundant_share"), 0),
            _against(cell),
            f"{cell.value('broken'):g}",
        ]
        for cell in found.cells
    ]
    table = _without_empty(table, _AGAINST)
    return table if len({row[1] for row in table[1:]}) > 1 else [[row[0], *row[2:]] for row in table]


def _by_conditions(found: Results) -> TextTable:
    acts = {one.name: " + ".join(one.specs) for one in found.design.conditions}
    head = ["agent", "condition", "interventions", "modality", "trials", "success", "mean steps", "loop rate"]
    table = [[*head, "by chance", "misread", "false reports", "changed steps", _AGAINST, "errors"]]
    table += [
        [
            cell.agent,
            cell.condition,
            acts[cell.condition] or NONE,
            cell.modality,
            str(cell.trials),
            share_of_row(cell.get("success")),
            value_cell(cell.get("mean_steps_all"), "{:.1f}"),
            share_of_row(cell.get("loop_rate")),
            chance_cell(cell),
            percent(cell.value("misread"), 1),
            percent(cell.value("false_report", "steps"), 1),
            _changed(cell),
            _against(cell),
            f"{cell.value('broken'):g}",
        ]
        for cell in found.cells
    ]
    said = {row[2] for row in table[1:]} - {NONE}
    kept = [i for i in range(len(table[0])) if len({row[i] for row in table[1:]}) > 1 or i not in (2, 3)]
    if said <= {row[1] for row in table[1:]}:
        kept = [i for i in kept if i != 2]  # unnamed conditions are called by their interventions
    return _without_empty([[row[i] for i in kept] for row in table], _AGAINST)


def _without_empty(table: TextTable, name: str) -> TextTable:
    """The table without a column that says nothing."""
    at = table[0].index(name)
    return table if {row[at] for row in table[1:]} - {NONE} else [[*row[:at], *row[at + 1 :]] for row in table]


def _against(cell: Cell) -> str:
    """How many attempts broke the rules of the box, if any did."""
    row = cell.get("against_rules")
    return f"{row.count} of {row.n}" if row and row.count else NONE


def _changed(cell: Cell) -> str:
    row = cell.get("changed_steps")
    return NONE if row is None else f"{row.value:g} of {cell.value('steps'):g}"


_CONDITIONS = Table("conditions", _table, numeric_from=0)
_MIXED = Table("conditions", _table)


def _measures(found: Results) -> TextTable:
    """The measures of installed packages; none without any."""
    if not found.measures:
        return []
    head = ["agent", "condition", "measure", "what it is", "trials", "mean [95 % interval]"]
    return [head] + [
        [row.agent, row.condition, name, row.note or found.fact(MEASURES, name), str(row.n), value_cell(row, "{:.3g}")]
        for row in found.measures
        for name in [row.quantity.removeprefix(f"{MEASURES}.")]
    ]


_MEASURES = Table("measures", _measures, numeric_from=4)


def _show(found: Results) -> Iterator[Part]:
    yield Part("All conditions", _range(found), list(_blocks(found)))


def _range(found: Results) -> str:
    """Between which shares of trials solved all conditions of all agents lie."""
    shares = [(row.value, row) for row in found.where("success", of="") if row.value is not None and row.condition]
    if not shares:
        return ""
    (low, least), (high, most) = min(shares, key=itemgetter(0)), max(shares, key=itemgetter(0))
    if low == high:
        return f"{percent(low)} of trials solved in every row."
    if least.agent == most.agent:
        return f"From {percent(low)} to {percent(high)} of trials solved."
    return f"From {percent(low)} of trials solved ({least.agent}) to {percent(high)} ({most.agent})."


def _intervals(found: Results) -> str:
    agents = (cell.agent for cell in found.cells)
    of = "Intervals of success and loop rate"
    return success_and_loops_said(agents, of, every_look=bool(found.progress.every_look))


def _blocks(found: Results) -> Iterator[Block]:
    mixed = found.beside_flips
    yield _MIXED if mixed else _CONDITIONS
    yield Note(
        "Misread: claims about the last action that contradict the report. False reports: report and truth differ."
        if mixed
        else "Coverage: share of steps in loops, mean over trials. Redundant: share of steps that tried a joint again "
        "in the same true configuration, mean over trials.",
        f"{_intervals(found)} By chance: loop rate of random actions in trials of the same lengths, from uniform to "
        "without immediate repeats.",
    )
    if _measures(found):
        yield Heading("Measures of installed packages")
        yield _MEASURES
        yield Note(
            "Means over trials with 95 % intervals.",
            "Intervals of shares are Wilson intervals, clustered by person for people; those of means are Student's, "
            "clustered by block or by person.",
        )


SECTIONS = (
    Section(
        name="conditions",
        title="All conditions",
        rows=_rows,
        show=_show,
        tables=(_CONDITIONS, _MEASURES),
    ),
    Section(name="measures", title="Measures", rows=measure_rows),
)
