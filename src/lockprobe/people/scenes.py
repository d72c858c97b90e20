"""Scenes: all that a participant's page gets to show, one after the other.

A scene never says what is true where something else was told, what locks what, how often reports are false, or which
trial of the study this is. It is made of the ``Situation`` that every agent gets.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "LONGEST_ANSWER",
    "Ask",
    "Box",
    "BoxJoint",
    "BoxPanel",
    "Check",
    "Closed",
    "Consent",
    "Debrief",
    "Example",
    "InstructionPage",
    "PastStep",
    "Scene",
    "StrictModel",
    "TrialOver",
]

LONGEST_ANSWER = 2000
"""Characters of an answer in words."""


class StrictModel(BaseModel):
    """The base of all that is stored or sent: immutable, no other fields, no conversion of types."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Consent(StrictModel):
    """The first scene asks for consent. Nothing is stored before the participant agrees.

    Attributes:
        title: Its title.
        paragraphs: Its text.
        ask_code: Whether a code has to be given to join, and the URL did not hold it.
    """

    kind: Literal["consent"] = "consent"
    title: str
    paragraphs: tuple[str, ...]
    ask_code: bool = False


class BoxJoint(StrictModel):
    """One joint as a participant knows it.

    Attributes:
        label: Its label.
        target: Whether it is the one that has to move.
        kind: How it is drawn, ``prismatic`` (slides) or ``revolute`` (turns); only for the drawn panel.
        place: Where it sits on the panel, from the left and from below, [0, 1]; only for the drawn panel.
        position: The position as told; None where none is told.
        handle: Where its handle lies in the pictures at either position, as shares of width and height from the upper
            left corner; only for pictures.
    """

    label: str
    target: bool
    kind: Literal["prismatic", "revolute"] | None = None
    place: tuple[float, float] | None = None
    position: Literal[0, 1] | None = None
    handle: tuple[tuple[float, float], tuple[float, float]] | None = None


class PastStep(StrictModel):
    """One finished step: what was attempted, and what was reported. The report is empty where pictures are shown.

    Attributes:
        step: Which, from 1.
        joint: Label of the joint that was attempted.
        told: The report in words, as models read them.
        outcome: What was told of the joint.
        ones: Labels of the joints that were told to be at position 1; None where no positions are told.
    """

    step: int
    joint: str
    told: str
    outcome: Literal["moved", "blocked"] | None = None
    ones: tuple[str, ...] | None = None


class BoxPanel(StrictModel):
    """What the agent's channel shows now.

    Attributes:
        view: ``text``: the report in words. ``panel``: the same drawn, from what was told. ``pictures``: a camera's.
        joints: In the order in which they are listed.
        told: The report in words; empty with pictures.
        last: Label of the joint attempted last; None before the first attempt.
        outcome: What was told of it; None with pictures, and before the first attempt.
        pictures: PNG files as data URLs, colours first; empty without pictures.
    """

    view: Literal["text", "panel", "pictures"]
    joints: tuple[BoxJoint, ...]
    told: str
    last: str | None = None
    outcome: Literal["moved", "blocked"] | None = None
    pictures: tuple[str, ...] = ()


class Example(StrictModel):
    """A made-up box as those of the study are shown, on which nothing can be done.

    Attributes:
        panel: What is shown.
        ask: Whether the question what the last action did stands there too.
    """

    panel: BoxPanel
    ask: bool = False


class InstructionPage(StrictModel):
    """A page of instructions, or what stands before the first box.

    Attributes:
        title: Its title.
        paragraphs: Its text.
        number: Which page, from 1.
        of: How many there are.
        examples: A box in each way in which the participant will see the study's.
    """

    kind: Literal["page"] = "page"
    title: str
    paragraphs: tuple[str, ...]
    number: int
    of: int
    examples: tuple[Example, ...] = ()


class Box(StrictModel):
    """A step of a trial, or of the practice: a joint has to be chosen.

    Attributes:
        practice: Whether it is the practice box.
        number: Which box, from 1; 0 is the practice box.
        of: How many there are; the practice does not count.
        step: The step that is to be taken, from 1.
        budget: Steps of the trial.
        ask: Whether it is asked, before a joint is chosen, what the last action did.
        panel: What is shown.
        history: All steps of this trial so far, oldest first; empty where the experimenter shows none.
        history_open: Whether they are unfolded when a box begins.
        device: Whether the page says with what a choice was made, and how large its window was.
    """

    kind: Literal["box"] = "box"
    practice: bool
    number: int
    of: int
    step: int
    budget: int
    ask: bool
    panel: BoxPanel
    history: tuple[PastStep, ...] = ()
    history_open: bool = True
    device: bool = False


class TrialOver(StrictModel):
    """A box is done with. What the last attempt did is said only where the experimenter says so (``feedback``).

    Attributes:
        practice: Whether it was the practice box.
        number: Which box, from 1; 0 is the practice box.
        of: How many there are; the practice does not count.
        solved: Whether it was opened; None where that is not said.
        title: In words.
        paragraphs: The same at length.
    """

    kind: Literal["over"] = "over"
    practice: bool
    number: int
    of: int
    solved: bool | None
    title: str
    paragraphs: tuple[str, ...]


class Check(StrictModel):
    """An attention check: one of some options, of which only the server knows the right one."""

    kind: Literal["check"] = "check"
    question: str
    options: tuple[str, ...]


class Ask(StrictModel):
    """A question of the experimenter's at the end.

    Attributes:
        name: The name of its column.
        question: The question.
        options: What can be chosen; empty for an answer in words.
        required: Whether it can be left empty.
        longest: Characters that an answer in words may have.
        type: What a written answer has to be.
        low: The least number that is taken; None for any.
        high: The largest number that is taken; None for any.
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


class Debrief(StrictModel):
    """The end: what it was about, and the way back to the recruitment platform, if there is one.

    Attributes:
        title: Its title.
        paragraphs: Its text.
        completion_url: Where to go on.
        completion_code: What to enter there.
    """

    kind: Literal["debrief"] = "debrief"
    title: str
    paragraphs: tuple[str, ...]
    completion_url: str = ""
    completion_code: str = ""


class Closed(StrictModel):
    """Nothing can be done here (any more).

    Attributes:
        why: ``declined``, ``withdrawn``, ``full`` (nobody can join), ``taken`` (this person of the recruitment platform
            takes part already, in another browser), ``late`` (was away too long).
        title: In words.
        paragraphs: The same at length.
        completion_url: Where to go on, where there is such a place for those who come no further.
        completion_code: What to enter there.
    """

    kind: Literal["closed"] = "closed"
    why: Literal["declined", "withdrawn", "full", "taken", "late"]
    title: str
    paragraphs: tuple[str, ...]
    completion_url: str = ""
    completion_code: str = ""


Scene = Annotated[
    Consent | InstructionPage | Box | TrialOver | Check | Ask | Debrief | Closed, Field(discriminator="kind")
]
