"""From pictures to flips: which part of what pictures change do misreadings account for, as false reports?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell
from lockprobe.report.format import TextTable
from lockprobe.report.prose.bridge import ARMS_SAID, bridge_said, numbers_said, others_said
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Figure, Heading, Listed, Note, Part, Section, Table, Text
from lockprobe.report.sections.effects import of_blocks
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import share_of_row, steps_cell
from lockprobe.statistics.bridge.arms import PICTURES, WORDS
from lockprobe.statistics.bridge.bridge import Bridge, BridgeArm
from lockprobe.statistics.proportions import proportion

__all__ = ["FIGURE", "SECTIONS"]

_AGENTS, _ARMS = "pictures against words", "arms of the bridge"

_MISREAD = {"moved": "hidden_moves", "blocked": "invented_moves"}
"""True outcome -> the quantity of its misreadings."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for found in numbers.others.bridges if numbers.others else ():
        own: dict[str, Any] = {"agent": found.agent, "modality": found.modality}
        for one in found.arms:
            yield from _of_arm(found, one, own)
        for joint in (*found.misread.joints, ""):
            for outcome, quantity in _MISREAD.items():
                counted = found.misread.count(outcome, joint or None)  # type: ignore[arg-type]
                yield from share_rows(quantity, proportion(*counted), **own, of=joint)
        said = {"verdict": bridge_said(found), "numbers": numbers_said(found), "others": others_said(found)}
        for kind, text in said.items():
            if text:
                rests = ("steps_difference", "share_accounted_for", "hidden_moves", "invented_moves")
                yield Finding(section="bridge", kind=kind, **own, text=text, rests_on=rests)


def _of_arm(found: Bridge, one: BridgeArm, own: dict[str, Any]) -> Iterator[Estimate]:
    arm = own | {"condition": one.condition, "of": one.arm}
    yield Estimate(quantity="false_reports_in_arm", **arm, unit="reports", value=one.told, n=one.success.n)
    alone = one.arm in (PICTURES, "replayed")
    others = sum(arm.arm not in (WORDS, PICTURES, "replayed") for arm in found.arms)
    family: dict[str, Any] = {
        "family": _AGENTS if alone else _ARMS,
        "corrected_for": found.agents * (1 if alone else others),
    }
    if one.change is not None:
        tested = of_blocks(one.change) | {"control": found.arm(WORDS).condition, "test": "sign flips of blocks"}
        yield Estimate(quantity="steps_difference", **arm, **family, unit="steps", **tested)
    if one.share is not None:
        ends: dict[str, Any] = {"value": one.share.value, "low": one.share.low, "high": one.share.high}
        note = "" if one.share.low is not None else "its interval is not bounded"
        counted: dict[str, Any] = {} if one.change is None else {"n": one.change.pairs, "clusters": one.change.blocks}
        yield Estimate(quantity="share_accounted_for", **arm, **family, **ends, **counted, note=note)


def _bridges(found: Results) -> list[Estimate]:
    """The difference between pictures and words of every bridge."""
    return found.where("steps_difference", of=PICTURES)


def _table(found: Results) -> TextTable:
    head = ["agent", "arm", "told", "solved", "mean steps", "false reports", "steps more than in words", "P"]
    table = [[*head, "share of the difference"]]
    for row in found.where("false_reports_in_arm"):
        own = {"agent": row.agent, "modality": row.modality, "of": row.of}
        cell = {"agent": row.agent, "condition": row.condition}
        change, share = found.get("steps_difference", **own), found.get("share_accounted_for", **own)
        table.append(
            [
                row.agent,
                row.of,
                ARMS_SAID[row.of],
                share_of_row(found.get("success", **cell)),
                f"{found.one('mean_steps_all', **cell).value:.1f}",
                f"{row.value:g}",
                steps_cell(change) if change else NONE,
                p_cell(change.p_value) if change else NONE,
                share_of_row(share),
            ]
        )
    return table if len(table) > 1 else []


def _misread_table(found: Results) -> TextTable:
    """The confusion matrix of every agent, by joint."""
    table = [["agent", "pictures", "joint", "moves", "of these hidden", "failures", "of these taken for moves"]]
    for total in _bridges(found):
        own = {"agent": total.agent, "modality": total.modality}
        rows = {(row.of, row.quantity): row for name in _MISREAD.values() for row in found.where(name, **own)}
        for joint in sorted({of for of, _ in rows}, key=lambda of: (not of, of)):
            cells = [total.agent, total.modality, joint or "all joints"]
            for quantity in _MISREAD.values():
                row = rows.get((joint, quantity))
                cells += [str(row.n) if row else "0", share_of_row(row)]
            table.append(cells)
    return table if len(table) > 1 else []


_TABLE = Table("bridge", _table, numeric_from=3)
_MATRIX = Table("misread", _misread_table, numeric_from=3)

FIGURE = Figure(
    "bridge",
    "What pictures change, and what misreadings told as false reports change in words",
    Caption(
        "Steps more than with true reports in words; an unsolved trial counts with its whole budget. Filled: pictures. "
        "Hollow: words in which the misreadings of the pictures are told as false reports, from the most exact "
        "repetition to the least.",
        "Brackets are 95 % intervals, corrected for the number of agents, and below the first two rows for the number "
        "of rows. If misreadings act as false reports do, the first hollow mark stands at the dashed line.",
    ),
    draw="lockprobe.report.figures.bridge:bridge",
    applies=lambda found: bool(_bridges(found)),
)

_NOTE = Note(
    Markup(
        "All arms of a block share their random numbers. A <em>misreading</em> is a statement about the last action "
        "that contradicts what happened. <code>replayed</code> tells it as a false report of the same joint and "
        "outcome at the same step; if the trials part, at the next attempt of that joint with that outcome. "
        "<code>profile</code> and <code>symmetric</code> use the rates of this study, which are taken as known."
    ),
    Markup(
        "The share is the mean change of an arm by the mean change of pictures. Its 95 % interval over blocks is that "
        "of Fieller, widened as if one more block differed. Misreadings <em>account for</em> the difference if the "
        "interval holds 100 % and lies above 50 %, for <em>little or none</em> if it holds 0 and lies below 50 %, and "
        "for <em>a part</em> if it lies between 0 and 100 %. The line at 50 % is ours. Nothing is said of shares "
        "unless <i>P</i> of the difference is below 0.05 and its interval leaves out 0."
    ),
)

_LIMITS = [
    (
        "Only what an agent says of its last action is known and told again. What it misreads of other joints, or "
        "does not say, counts as an effect of pictures that misreadings do not account for."
    ),
    (
        "A false report is told as the study says (--flip). A misreading may last as long as the picture looks the "
        "same, and --flip integrated lets false positions last in words, too."
    ),
    (
        "The share speaks of false reports that the agent is told. It does not show that the agent treats its own "
        "reading and a report of others alike."
    ),
    (
        "An agent whose sampling cannot be seeded shares only the box and the labels between arms; its differences "
        "vary more and need more blocks."
    ),
]


def _show(found: Results) -> Iterator[Part]:
    if bridges := _bridges(found):
        blocks: list[Block] = [FIGURE]
        for row in bridges:
            own = {"agent": row.agent, "modality": row.modality}
            said = [text for kind in ("verdict", "numbers", "others") for text in found.said("bridge", kind, **own)]
            blocks += [*([Heading(row.agent, code=True)] if len(bridges) > 1 else []), *map(Text, said)]
        answer = found.said("bridge", "verdict", agent=bridges[0].agent, modality=bridges[0].modality)[0]
        known: list[Block] = [_MATRIX, _MATRIX_NOTE] if _misread_table(found) else []
        blocks += [_TABLE, _NOTE, *known, Listed(_LIMITS)]
        yield Part("From pictures to flips: do misreadings act as false reports?", answer, blocks)


_MATRIX_NOTE = Note(
    "How the pictures were misread, by joint and by what the attempt did.",
    "Shares have 95 % Wilson intervals, as if all statements were independent.",
)


SECTIONS = (
    Section(
        name="bridge",
        title="From pictures to flips",
        rows=_rows,
        show=_show,
        tables=(_TABLE, _MATRIX),
        figures=(FIGURE,),
    ),
)
