"""Misinterpretations: what agents said of their actions, against what they were told and against the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import percent
from lockprobe.foundation.spec import Spec
from lockprobe.report.format import TextTable
from lockprobe.report.prose.floor import NO_FLOOR, floor_said
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.rows import Cell, Estimate, Finding, Results, Row
from lockprobe.report.sample_pictures import ABOUT
from lockprobe.report.section import Block, Cells, Detail, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers, share_rows
from lockprobe.report.table_rows import by_conditions, count_of, share_of_row
from lockprobe.statistics.misinterpretation import misread_in_blocks
from lockprobe.studies.modality import is_pictured


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        yield from _of_cell(cell)
    yield from _floor(numbers)
    yield from numbers.answer("misinterpretations", "misread", "trials_not_asked", "claims")


def _of_cell(cell: PlayedCell) -> Iterator[Estimate]:
    said = cell.summary.claims
    shares = {
        "misread": said.misinterpreted,
        "said_moved_told_blocked": said.moved_for_blocked,
        "said_blocked_told_moved": said.blocked_for_moved,
        "said_moved_of_misread": said.hallucinated,
        "false_report": said.falsely_told,
        "false_belief": said.false_belief,
    }
    for quantity, share in shares.items():
        yield from cell.share(quantity, share)
    yield from cell.share("misread", said.pooled, of="not clustered")
    yield from cell.share("false_report", said.false_reports, of="steps")
    yield from cell.share("false_positions", said.false_positions)
    if false := said.falsely_told.count:
        yield cell.estimate("false_reports_believed", said.believed / false, n=false, count=said.believed)
    if said.not_asked:
        yield cell.estimate("trials_not_asked", said.not_asked, unit="trials")
    if said.trials:
        yield cell.estimate("misinterpretations", said.total, unit="claims", n=said.pooled.n)
        affected = said.affected / said.trials
        yield cell.estimate("trials_with_misinterpretation", affected, n=said.trials, count=said.affected)
        yield cell.estimate("misinterpretation_rate", said.mean_rate, n=said.trials)
        for kind in said.counts:
            of = f"claimed {kind.claimed}, told {kind.told}, in truth {kind.truth}"
            yield cell.estimate("claims", kind.count, of=of, unit="claims")
    if said.sd_rate is not None:
        yield cell.estimate("misinterpretation_rate_sd", said.sd_rate, n=said.trials)


def _floor(numbers: StudyNumbers) -> Iterator[Row]:
    """What the scripted viewer misreads of the pictures that other agents say something of.

    A report of pictures is what they show, so the floor is held against the same as the misreading beside it.
    """
    study = numbers.study
    viewer = next((study.label_of(agent) for agent in study.agents if _is_floor(agent)), "")
    pictured = [cell for cell in numbers.cells if is_pictured(cell.modality) and cell.summary.claims.trials]
    others = [cell for cell in pictured if cell.agent != viewer]
    floors = {cell.condition: cell for cell in pictured if cell.agent == viewer}
    for cell in others:
        if floor := floors.get(cell.condition):
            yield from cell.share("misreading_floor", floor.summary.claims.misinterpreted)
    about: dict[str, Any] = {"section": "misinterpretations", "kind": "floor"}
    if others and floors:
        pooled = misread_in_blocks([trial for cell in floors.values() for trial in cell.trials])
        (row,) = share_rows("floor_of_pictures", pooled, agent=viewer)
        yield row
        yield Finding(**about, agent=viewer, text=floor_said(row), rests_on=("floor_of_pictures", "misreading_floor"))
    elif others and not viewer:
        yield Finding(**about, text=NO_FLOOR)


def _is_floor(agent: str) -> bool:
    """Whether an agent is a viewer whose acuity the pictures decide."""
    spec = Spec.parse(agent)
    return spec.kind == "viewer" and "acuity" not in spec.options


def _asked(found: Results) -> list[Cell]:
    """The agents that the study is about and that said what their actions did."""
    return [cell for cell in found.cells if cell.agent in found.subjects and cell.get("misinterpretations")]


def _table1(found: Results) -> TextTable:
    """The paper's Table 1, one row per condition.

    The paper's rows are modalities, and so are these where a study compares them; else a row names its flip rate too.
    The paper marks a total by one asterisk or two for the number of trials that it occurred in; here words say so,
    since asterisks read as levels of significance.
    """
    asked = _asked(found)
    first = "Input Modality" if _of_modalities(asked) else "Agent and condition"
    head = [first, "Average State Misinterpretation Rate per Trial", "Total State Misinterpretations"]
    return [head] + [[_named(cell, asked), _rate(cell), _total(cell)] for cell in asked]


def _rate(cell: Cell) -> str:
    spread = cell.value("misinterpretation_rate_sd")
    return percent(cell.value("misinterpretation_rate"), 1) + ("" if spread is None else f" ± {percent(spread, 1)}")


def _total(cell: Cell) -> str:
    affected = cell.get("trials_with_misinterpretation")
    trials = f", in {affected.count} of {affected.n} trials" if affected else ""
    return f"{cell.value('misinterpretations'):g}{trials}"


def _table1_corrected(found: Results) -> TextTable:
    """The three errors of claims, pooled over claims, with intervals clustered by trial."""
    floors = bool(found.where("misreading_floor"))
    head = ["agent and condition", "claims", "misread", *(["floor"] if floors else [])]
    table = [[*head, *_ERRORS]]
    asked = _asked(found)
    for cell in asked:
        misread = cell.get("misread")
        table.append(
            [
                _named(cell, asked),
                str(misread.n if misread else 0),
                share_of_row(misread),
                *([share_of_row(cell.get("misreading_floor"))] if floors else []),
                count_of(cell.get("said_moved_told_blocked")),
                count_of(cell.get("said_blocked_told_moved")),
                share_of_row(cell.get("false_report")),
                share_of_row(cell.get("false_belief")),
                count_of(cell.get("false_reports_believed")),
            ]
        )
    return table


_ERRORS = (
    *("claimed moved, told blocked", "claimed blocked, told moved"),
    *("false report", "false belief", "false reports believed"),
)


def _named(cell: Cell, among: Sequence[Cell]) -> str:
    """A condition's name; its flip rate goes without saying where modalities are compared at one."""
    if _of_modalities(among):
        return cell.label
    return f"{cell.label}, {cell.condition if by_conditions(among) else f'flip rate {cell.p:g}'}"


def _of_modalities(cells: Sequence[Cell]) -> bool:
    """Whether cells differ in their modality alone."""
    one_p = len({cell.p for cell in cells}) == 1 and not by_conditions(cells)
    return one_p and len({cell.modality for cell in cells}) > 1


_MANY = 8
"""Rows of a table beyond which the report holds the first of each agent."""

_TABLE1 = Table("table1", _table1, numeric_from=1)
_TABLE1_CORRECTED = Table("table1-corrected", _table1_corrected, numeric_from=1)


def _show(found: Results) -> Iterator[Part]:
    yield Part("Misinterpretations", found.answer_of("misinterpretations") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    if not _asked(found):
        why = ": they were not asked" if found.where("trials_not_asked") else ""
        yield Text(f"No agent of this study said what its actions did{why}.")
        return
    seen = any(fact.about.startswith(ABOUT) for fact in found.facts)
    pictures = ", or what the pictures showed" if seen else ""
    baselines = (
        "; baselines are excluded, since they repeat their reports or claim nothing"
        if len(found.subjects) < len(found.study.get("agents", []))
        else ""
    )
    yield from map(Text, found.said("misinterpretations", "floor"))
    note = Note(
        "Misread: claim and report differ; false report: report and truth differ, which the channel causes; false "
        "belief: claim and truth differ; believed: false reports that the agent repeated.",
        "Each error is pooled over claims, with a 95 % interval clustered by trial. Agents make no claim about the "
        f"last step of a trial{baselines}.",
        lead=True,
    )
    three: list[Block] = [note, _TABLE1_CORRECTED]
    head, *rows = _table1_corrected(found)
    if len(rows) > _MANY:
        first = {cell.label: row for cell, row in reversed([*zip(_asked(found), rows, strict=True)])}
        yield Cells([head, *reversed(first.values())], 1)
        three = [Detail("Three separate errors under every condition", three)]
    yield from three
    note = Note(
        Markup(
            "The paper's Table 1. A misinterpretation is a claim about the last action that contradicts what the agent "
            "was <em>told</em> about it{}."
        ).format(pictures),
        "Mean \N{PLUS-MINUS SIGN} standard deviation over trials.",
        lead=True,
    )
    yield Detail("The paper's Table 1", [note, _TABLE1])


SECTIONS = (
    Section(
        name="misinterpretations",
        title="Misinterpretations",
        rows=_rows,
        show=_show,
        tables=(_TABLE1, _TABLE1_CORRECTED),
    ),
)
