"""Scenes: everything that a participant's page can show.

A scene never contains the truth behind a false report, the interlock, how often reports are false (unless a condition
warns of it), the condition, or the number of the trial. It is made from the ``Situation`` that every agent gets.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

LONGEST_ANSWER = 2000
"""Characters of an answer in words."""


class StrictModel(BaseModel):
    """Base of everything that is stored or sent: immutable, no extra fields, no type conversion."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class _Text(StrictModel):
    title: str
    paragraphs: tuple[str, ...]


class _End(_Text):
    completion_url: str = ""
    completion_code: str = ""


class Consent(_Text):
    """The first scene asks for consent. Nothing is stored before the participant agrees.

    ``ask_code`` is true where a code is needed to join and the URL does not contain it.
    """

    kind: Literal["consent"] = "consent"
    ask_code: bool = False


class BoxJoint(StrictModel):
    """One joint as a participant sees it.

    Attributes:
        kind: Whether it slides or turns; only in the drawn panel.
        place: Where it sits on the panel, from the left and from below, [0, 1]; only in the drawn panel.
        position: The reported position; None where positions are not reported.
        handle: Where the pictures show its handle at each position, as shares of width and height from the upper left
            corner; only with pictures.
    """

    label: str
    target: bool
    kind: Literal["prismatic", "revolute"] | None = None
    place: tuple[float, float] | None = None
    position: Literal[0, 1] | None = None
    handle: tuple[tuple[float, float], tuple[float, float]] | None = None


class BoxPanel(StrictModel):
    """What the agent's channel shows now.

    Attributes:
        view: ``panel`` draws the report, ``pictures`` shows camera pictures.
        joints: The joints in listed order.
        report: What came of the last attempt, in sentences in the participant's language.
        last: Label of the joint that the report is about, by default the one attempted last; None before the first
            attempt.
        outcome: The reported outcome; None with pictures, before the first attempt, and where none is reported.
        pictures: PNG files as data URLs, colours first.
    """

    view: Literal["panel", "pictures"]
    joints: tuple[BoxJoint, ...]
    report: tuple[str, ...]
    last: str | None = None
    outcome: Literal["moved", "blocked"] | None = None
    pictures: tuple[str, ...] = ()


class Example(StrictModel):
    """A made-up box for the instructions. ``ask`` shows the question about the last action as well."""

    panel: BoxPanel
    ask: bool = False


class InstructionPage(_Text):
    """Page ``number`` of ``of`` of the instructions, with an example box in each modality of the participant.

    ``notice`` says why somebody is back here: answers about the instructions were wrong. ``begins`` is whether a box
    comes next.
    """

    kind: Literal["page"] = "page"
    number: int
    of: int
    examples: tuple[Example, ...] = ()
    notice: tuple[str, ...] = ()
    begins: bool = False


class OpenQuestion(StrictModel):
    """A question with options, without the right one."""

    question: str
    options: tuple[str, ...]


class ComprehensionQuestions(_Text):
    """Questions on the instructions, all on one page. Only the server knows the right options.

    ``notice`` is what went wrong before, where there are no instructions to go back to.
    """

    kind: Literal["comprehension"] = "comprehension"
    questions: tuple[OpenQuestion, ...]
    notice: tuple[str, ...] = ()


class Box(StrictModel):
    """A step of a trial or of the practice: the participant has to choose a joint.

    Attributes:
        number: The number of the box, from 1; 0 is the practice box.
        of: The number of boxes without the practice.
        step: The step to take, from 1.
        budget: Steps of the trial.
        ask: Whether the page asks what the last action did before a joint can be chosen.
        remark: A remark with the report; often empty.
        warning: A warning about reports; often empty.
        spoken: What a screen reader says: also what the panel shows.
        history: What was told after each step of this trial, oldest first; empty where the experimenter shows none.
        history_open: Whether the history is unfolded when a box begins.
        device: Whether the page sends the pointer device and the window size with each choice.
    """

    kind: Literal["box"] = "box"
    practice: bool
    number: int
    of: int
    step: int
    budget: int
    ask: bool
    panel: BoxPanel
    remark: str = ""
    warning: str = ""
    spoken: str
    history: tuple[str, ...] = ()
    history_open: bool = True
    device: bool = False


class TrialOver(_Text):
    """The end of a box, the same for the practice box: its ``number`` is 0, and ``of`` does not count it.

    ``solved`` is None where the experimenter gives no feedback; practice always has it.
    """

    kind: Literal["over"] = "over"
    practice: bool
    number: int
    of: int
    solved: bool | None


class Check(OpenQuestion):
    """An attention check. Only the server knows the right option."""

    kind: Literal["check"] = "check"


class Ask(StrictModel):
    """A question of the experimenter at the end; ``name`` is its column.

    Without options the answer is written: at most ``longest`` characters, and a number from ``low`` to ``high`` where
    ``type`` asks for one.
    """

    kind: Literal["ask"] = "ask"
    name: str
    question: str
    options: tuple[str, ...] = ()
    required: bool = False
    longest: int = LONGEST_ANSWER
    type: Literal["text", "number", "integer"] = "text"
    low: float | None = None
    high: float | None = None


class Debrief(_End):
    """The debriefing, and the way back to the recruitment platform if there is one."""

    kind: Literal["debrief"] = "debrief"


class Closed(_End):
    """The participant cannot go on.

    ``why``: ``declined``, ``withdrawn``, ``full`` (no place left), ``taken`` (the same platform ID takes part in
    another browser), ``finished`` (the same ID has reached the end there), ``late`` (was away too long, and somebody
    else got the place), or ``screened`` (too many rounds of wrong answers about the instructions).
    """

    kind: Literal["closed"] = "closed"
    why: Literal["declined", "withdrawn", "full", "taken", "finished", "late", "screened"]


Scene = Annotated[
    Consent | InstructionPage | ComprehensionQuestions | Box | TrialOver | Check | Ask | Debrief | Closed,
    Field(discriminator="kind"),
]
