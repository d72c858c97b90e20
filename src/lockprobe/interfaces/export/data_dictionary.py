"""The data dictionary: meaning, unit, range and clock of each column of an export."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

PAGE = "the monotonic clock of the participant's browser (performance.now)"
SERVER = "the clock of the server"

Kind = Literal["text", "integer", "number", "bits"]
"""The type of a cell. ``bits`` have one character per joint, 0, 1 or ?: a text whose leading zeros count."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes:
        meaning: The meaning of its values.
        unit: Its unit; empty for names, texts and marks.
        least: The smallest possible value; None if it holds no number.
        most: The largest possible value; None if there is no bound.
        kind: The type of its cells.
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
    "participant": Column("The participant: a random ID from the server, independent of the person."),
    "key": Column("The trial: its readable name in the study. A trial is one box, played from its start."),
    "agent": Column(
        "The agent that played: participant:ID for people; its name, or its spec if it has none, for others."
    ),
    "box": Column("Name of the lockbox."),
    "modality": Column("How the box was shown: symbolic (reports), rgb or rgbd (pictures)."),
    "p": Column(
        "Flip rate: probability that a report says the opposite, independent for each step. Empty if other "
        "interventions acted.",
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
    "joint": Column("The attempted joint, by its name in the box."),
    "label": Column("The attempted joint, by the letter that the agent knew it by."),
    "moved": _mark("whether the joint really moved."),
    "told": _mark(
        "whether the report after the step said that it moved; with pictures, whether the picture shows that. Empty if "
        "nothing was reported."
    ),
    "claimed": _mark(
        "whether the agent then said that it moved, when it chose the next joint. Empty for the last step, and if it "
        "was not asked."
    ),
    "misread": _mark("whether it said the opposite of the report: claimed differs from told. Empty if one of them is."),
    "reply": Column(
        "The reply of a model that chose the joint, word for word. Replies before it that could not be read stand in "
        "study.db. Empty for all other agents."
    ),
    "state": Column(
        "True configuration before the step: 0 or 1 for each joint, in panel order. CSV files have b in front (b0110), "
        "so that no program reads it as a number and drops leading zeros.",
        kind="bits",
    ),
    "target": _mark("whether this step moved the target joint, which opens the box."),
    "ending": Column("How the trial ended: solved, budget (steps ran out), error (broken, not a failure to solve)."),
    "condition": Column(
        "The condition, if other interventions than flips were varied: its name, or its interventions."
    ),
    "chosen": Column("The chosen joint, if an intervention replaced it by another one; else empty."),
    "panel": Column("The joints in the panel order of the trial, if panels differ between trials."),
    "verdict": Column("A robot's own verdict on the attempt: moved, blocked or failed. Empty without a robot."),
    "camera": Column(
        "The positions that a camera read after the step: 0 or 1 for each joint, ? for an unclear one, in panel order. "
        "Empty if no camera was read.",
        kind="bits",
    ),
    "position": _count(
        "Number of the box in the participant's order, from 1; 0 for practice.",
        0,
    ),
    "view": Column("How the page showed the box: text, panel (drawn) or pictures."),
    "report": Column("The report after the step, word for word. Empty with pictures."),
    "shown": Column(
        "What the participant read of the step, in their language: the sentences of the page, and a remark. Empty if "
        "the step ended the box, and in studies of earlier releases."
    ),
    "rt_ms": Column(
        f"Response time, from painting the scene to the choice of the joint or answer, by {PAGE}; for a joint without "
        "the time for the claim.",
        "ms",
        0,
        kind="number",
    ),
    "claimed_rt_ms": Column(
        f"Response time of what stands in claimed, from painting the scene to the claim, by {PAGE}. Empty without it.",
        "ms",
        0,
        kind="number",
    ),
    "claim": Column(
        "What the participant said, with this act, of the step before: moved or blocked. Empty if it was not asked."
    ),
    "claim_rt_ms": Column(
        f"Response time, from painting the scene to the claim, by {PAGE}. Empty if it was not asked.",
        "ms",
        0,
        kind="number",
    ),
    "at": Column(
        f"Time of arrival at the server, counted from the participant's consent, by {SERVER}.", "s", 0, kind="number"
    ),
    "turn": _count("Number of the answered scene, one act each; consent is the first."),
    "scene": Column(
        "Kind of the answered scene: page, box, over, check or ask; broken if a box could not be continued."
    ),
    "recorded": _mark("whether the step belongs to a finished trial, which is in the file of steps."),
    "pointer": Column("Device of the choice: mouse, touch, pen or keyboard. Empty if the study does not store it."),
    "window_width": Column(
        "Width of the browser's window at this choice; for a participant, at the first choice. Empty if the study "
        "does not store it.",
        "px",
        0,
        kind="integer",
    ),
    "window_height": Column("Height of the browser's window, as for window_width.", "px", 0, kind="integer"),
    "ended": Column("How the trial or practice ended with this step: solved, budget or error. Empty if it continues."),
    "language": Column("Language of the texts on the page (BCP 47)."),
    "texts": Column("Fingerprint of these texts; equal fingerprints mean equal texts."),
    "boxes_assigned": _count("Boxes assigned to the participant.", 0),
    "boxes_finished": _count("Number of them that were finished: opened, or all steps taken.", 0),
    "boxes_broken": _count("Number of them that broke through no fault of the participant.", 0),
    "left_in_box": _count(
        "The first unfinished box, at which the participant left; 0 without a step in any box: at the instructions, in "
        "the practice, or screened out. Empty if all are finished.",
        0,
    ),
    "left_after_step": _count("Steps taken in that box. Empty if all are finished.", 0),
    "released": _mark("whether the participant was away so long that the remaining boxes were given to others."),
    "comprehension_rounds": _count(
        "Rounds in which the questions on the instructions were answered; 1 is right at first. Empty if none was.", 1
    ),
    "screened": _mark("whether the limit of rounds ended the session, without a box."),
    "checks_right": _count("Attention checks answered correctly.", 0),
    "checks_wrong": _count("Attention checks answered incorrectly.", 0),
    "seconds": Column(f"Time from consent to the participant's last act, by {SERVER}.", "s", 0, kind="number"),
    "trial_seconds": Column(
        f"Time that a person took for the box, from when it was shown to its last step, by {SERVER}. Empty for others.",
        "s",
        0,
        kind="number",
    ),
    "box_seconds": Column(
        "Seconds that each box took in order, from when it was shown to its last step, separated by semicolons; empty "
        "where no step was taken."
    ),
    "conditions": Column(
        "The conditions of the participant's boxes in order (truth; flip?p=0.4), separated by semicolons."
    ),
    "finished": _mark("whether all boxes of the participant are over, whether or not the questions after them are."),
    "questions_left": _count("Attention checks and questions to which the participant has not come; 0 at the end.", 0),
    "pointers": Column(
        "Devices of the participant's choices, most used first: mouse, touch, pen, keyboard. Empty if the study does "
        "not store them."
    ),
    "check": _count("Number of the attention check, from 1."),
    "question": Column("The question. Empty if the settings of the experiment are not stored."),
    "answer": Column("The answer, word for word."),
    "right": _mark("whether the answer is right."),
    "name": Column("The experimenter's name for the question."),
    "solved": _mark(
        "whether the target joint moved. Empty if the trial ended as error, which is not a failure to solve."
    ),
    "steps": _count("Steps taken; each is one attempt to move a joint.", 0),
    "budget": _count("The most steps of the trial."),
    "moves": _count("Attempts that really moved their joint.", 0),
    "false_reports": _count("Steps whose report said the opposite of the truth.", 0),
    "claims": _count("Number of claims about the previous step.", 0),
    "misinterpretations": _count("Number of claims that contradict the report (not the truth).", 0),
    "any_loop": _mark("whether the attempts contain an action loop: a run of three or more that occurs twice."),
    "loop_coverage": Column(
        "The largest share of attempts that action loops cover. Empty without an attempt.", "", 0, 1, "number"
    ),
    "call": _count("Number of the call for that step, from 1; later ones follow a malformed reply."),
    "input_tokens": _count("Tokens that the model read, by its provider's count.", 0),
    "output_tokens": _count("Tokens that the model wrote, those of reasoning included.", 0),
    "call_seconds": Column("Time of the call, retries included.", "s", 0, kind="number"),
    "error": Column("The boundary at which a trial broke: model, reply, refusal, plant, channel or participant."),
}
"""Every column of every table except those of the recruitment platform."""

PLATFORM = "platform_"
"""The prefix of columns with parameters of the recruitment platform."""


_DATATYPE: Mapping[Kind, str] = {"text": "string", "bits": "string", "integer": "integer", "number": "number"}


def as_bits(state: str) -> str:
    """A configuration for CSV, marked so that no program reads it as a number; empty without one.

    >>> as_bits("0110")
    'b0110'
    """
    return f"b{state}" if state else ""


def dictionary(file: str, columns: Iterable[str], row: str) -> dict[str, object]:
    """The data dictionary of a table in a file (W3C, CSV on the Web); ``row`` describes a row."""
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
    """The description of the column with this name."""
    if name.startswith(PLATFORM):
        return Column(f"{name.removeprefix(PLATFORM)}, as the recruitment platform gave it in the URL.")
    return COLUMN[name]
