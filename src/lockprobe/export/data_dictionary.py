"""What stands in each column of an export, in which unit, by which clock: the data dictionary."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

__all__ = ["COLUMN", "PLATFORM", "Column", "Kind", "as_bits", "column", "dictionary"]

PAGE = "the monotonic clock of the participant's browser (performance.now)"
SERVER = "the clock of the server"

Kind = Literal["text", "integer", "number", "bits"]
"""What a cell is. ``bits`` are one character a joint, 0 or 1: a text whose leading zeros count."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes:
        meaning: What stands in it.
        unit: Its unit; empty where it is a name, a text or a mark.
        least: The least that can stand in it; None where it holds no number.
        most: The most; None where there is no bound.
        kind: What its cells are.
    """

    meaning: str
    unit: str = ""
    least: float | None = None
    most: float | None = None
    kind: Kind = "text"


def _mark(meaning: str) -> Column:
    return Column(f"1 or 0: {meaning}", least=0, most=1, kind="integer")


def _count(meaning: str, least: int = 1) -> Column:
    return Column(meaning, least=least, kind="integer")


COLUMN: Mapping[str, Column] = {
    "participant": Column("Who: an ID that was made up by the server; no part of it comes from the person."),
    "key": Column("The trial: its readable name in the study. A trial is one box that is played from its start."),
    "agent": Column("Who played, as Lockprobe names agents: participant:ID for people, strategies and models by spec."),
    "box": Column("Name of the lockbox."),
    "modality": Column("How the box was shown: symbolic (reports), rgb or rgbd (pictures)."),
    "p": Column(
        "Flip rate: how often, independently in every step, the report said the opposite; empty where something else "
        "acted.",
        "",
        0,
        1,
        "number",
    ),
    "repetition": _count("Repetition of the study, from 1."),
    "trial": _count(
        "Trial within repetition and condition, from 1. Trials of one repetition and number share their luck."
    ),
    "step": _count("Step within the trial, from 1: one attempt to move one joint."),
    "joint": Column("The joint that was attempted, by its name in the box."),
    "moved": _mark("whether the joint really moved."),
    "told_moved": _mark("whether the report afterwards said that it moved. With pictures: what the picture shows."),
    "claimed": Column(
        "What was said, before this step's joint was chosen, of what the *previous* step had done: moved or blocked. "
        "It is held against moved and told_moved of the row before. Empty in the first step and where it was not asked."
    ),
    "state": Column(
        "True configuration before the step: one 0 or 1 a joint, in panel order. In CSV with b in front (b0110), so "
        "that no program reads it as a number and drops leading zeros.",
        kind="bits",
    ),
    "target": _mark("whether this step moved the target joint, which opens the box."),
    "ending": Column("How the trial ended: solved, budget (steps ran out), error (broken, no failure to solve)."),
    "condition": Column("The condition, where other things than flip rates were varied: its name, or what acted."),
    "chosen": Column("The joint that had been chosen, where an intervention had another one attempted; else empty."),
    "panel": Column("The joints in the panel order of the trial, where panels differ between trials."),
    "verdict": Column("What a robot took to have happened: moved, blocked or failed. Empty without a robot."),
    "position": _count(
        "Which of the participant's boxes it was, in the order in which they were played, from 1; 0 is for practice.",
        0,
    ),
    "view": Column("How the page showed it: text, panel (drawn) or pictures."),
    "told": Column("The report after the step, in the words in which it was told. Empty with pictures."),
    "rt_ms": Column(
        f"From when the scene was painted to the choice of the joint or of the answer, by {PAGE}; for a joint without "
        "the time for what was said of the step before.",
        "ms",
        0,
        kind="number",
    ),
    "confidence": Column(
        "How sure the agent said that it is of claimed. Empty in the first step and where it was not asked.",
        "%",
        0,
        100,
        "integer",
    ),
    "report_false": _mark(
        "whether the agent thinks that what it was told of the *previous* step is false. Empty in the first step and "
        "where it was not asked."
    ),
    "claimed_rt_ms": Column(
        f"From when the scene was painted to what was said of the step before, by {PAGE}. Empty where it was not "
        "asked.",
        "ms",
        0,
        kind="number",
    ),
    "at": Column(
        f"When it reached the server, since the participant agreed to take part, by {SERVER}.", "s", 0, kind="number"
    ),
    "turn": _count("Number of the scene that was answered, one act each; agreeing to take part is the first."),
    "scene": Column(
        "What kind of scene was answered: page, box, over, check or ask; broken where a box could not be played on."
    ),
    "label": Column("The label by which the participant knew the joint."),
    "recorded": _mark("whether the step belongs to a finished trial, which stands in the file of steps."),
    "pointer": Column(
        "With what the joint was chosen: mouse, touch, pen or keyboard. Empty where the study does not keep it."
    ),
    "window_width": Column(
        "Width of the browser's window then; of a participant at the first choice. Empty where the study does not "
        "keep it.",
        "px",
        0,
        kind="integer",
    ),
    "window_height": Column("Height of the same, in the same way.", "px", 0, kind="integer"),
    "ended": Column(
        "How the trial ended with this step, practice too: solved, budget or error. Empty where it goes on."
    ),
    "language": Column("Language of the texts that were read (BCP 47)."),
    "texts": Column("Fingerprint of these texts; equal fingerprints are equal texts."),
    "boxes_assigned": _count("Boxes that the participant was to play.", 0),
    "boxes_finished": _count("Of these, how many were finished: opened, or all steps taken.", 0),
    "boxes_broken": _count("Of these, how many broke, through no doing of the participant.", 0),
    "left_in_box": _count("Where somebody left: the first box that is not over. Empty where all are."),
    "left_after_step": _count("Steps taken in that box. Empty where all are over.", 0),
    "released": _mark("whether the participant was away so long that the boxes left over were given to others."),
    "checks_right": _count("Attention checks that were answered rightly.", 0),
    "checks_wrong": _count("Attention checks that were answered wrongly.", 0),
    "conditions": Column(
        "The participant's boxes in their order, each as modality and flip rate (symbolic p=0.4), with semicolons "
        "between."
    ),
    "finished": _mark("whether the participant came to the end: every box is over and every question was put."),
    "pointers": Column(
        "With what the participant chose joints, what was used most first: mouse, touch, pen, keyboard. Empty where "
        "the study does not keep it."
    ),
    "check": _count("Number of the attention check, from 1."),
    "question": Column("The question that was asked. Empty where the settings of the experiment are not kept."),
    "answer": Column("The answer as it was given."),
    "right": _mark("whether it is the right answer."),
    "name": Column("Name of the question, as the experimenter gave it."),
    "solved": _mark(
        "whether the target joint moved. Empty where the trial ended as error: that is no failure to solve."
    ),
    "steps": _count("Steps taken, attempts of a joint.", 0),
    "budget": _count("Steps that the trial had at most."),
    "moves": _count("Attempts that really moved their joint.", 0),
    "false_reports": _count("Steps whose report said the opposite of the truth.", 0),
    "claims": _count("Times that it was said what the previous step had done.", 0),
    "misinterpretations": _count("Of these claims, those that contradict what had been told (not: what was true).", 0),
    "any_loop": _mark("whether the attempts hold an action loop: three or more in a row that stand twice."),
    "loop_coverage": Column(
        "Share of the attempts that action loops cover at most. Empty without an attempt.", "", 0, 1, "number"
    ),
    "error": Column("Where a trial broke that ended as error: model, reply, plant, channel or participant."),
}
"""Every column of every table but those of the recruitment platform."""

PLATFORM = "platform_"
"""With what the names of columns begin that hold what the recruitment platform said."""


_DATATYPE: Mapping[Kind, str] = {"text": "string", "bits": "string", "integer": "integer", "number": "number"}


def as_bits(state: str) -> str:
    """A configuration as CSV has it: no program takes it for a number.

    >>> as_bits("0110")
    'b0110'
    """
    return f"b{state}"


def dictionary(file: str, columns: Iterable[str], row: str) -> dict[str, object]:
    """The data dictionary of a table in a file (W3C, CSV on the Web); ``row`` says what a row is."""
    return {
        "@context": "http://www.w3.org/ns/csvw",
        "url": file,
        "dc:description": row,
        "tableSchema": {"columns": [_described(name) for name in columns]},
    }


def _described(name: str) -> dict[str, object]:
    about = column(name)
    bounds = {"minimum": about.least, "maximum": about.most}
    datatype = {"base": _DATATYPE[about.kind]} | {fact: bound for fact, bound in bounds.items() if bound is not None}
    unit = {"schema:unitText": about.unit} if about.unit else {}
    return {"name": name, "titles": name, "dc:description": about.meaning, "datatype": datatype, **unit}


def column(name: str) -> Column:
    """What stands in the column of this name."""
    if name.startswith(PLATFORM):
        return Column(f"{name.removeprefix(PLATFORM)}, as the recruitment platform gave it in the URL.")
    return COLUMN[name]
