"""A participant's acts, as the page sends them, and whether an answer fits its question."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field

from lockprobe.people.scenes import LONGEST_ANSWER, Ask, StrictModel

Milliseconds = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)]
"""Time on the page's monotonic clock (``performance.now``); each field says from when."""

Pixels = Annotated[int, Field(ge=0, le=100_000)]

Label = Annotated[str, Field(min_length=1, max_length=8)]


class Agree(StrictModel):
    """In ``Consent``: yes or no."""

    kind: Literal["agree"] = "agree"
    agreed: bool
    code: Annotated[str, Field(max_length=100)] = ""


class Next(StrictModel):
    """In ``Page`` and ``TrialOver``: go on."""

    kind: Literal["next"] = "next"


class Attempt(StrictModel):
    """In ``Box``: choose a joint.

    Attributes:
        claimed: What the participant says the last action did, where asked.
        rt: From painting the scene to the choice of the joint, ms; without the time for ``claimed``.
        claimed_rt: From painting the scene to the choice of ``claimed``, ms; None where not asked.
        pointer: The device of the choice; None where it is not kept.
        viewport: Width and height of the window, CSS pixels; None where they are not kept.
    """

    kind: Literal["attempt"] = "attempt"
    joint: Label
    claimed: Literal["moved", "blocked"] | None = None
    rt: Milliseconds
    claimed_rt: Milliseconds | None = None
    pointer: Literal["mouse", "touch", "pen", "keyboard"] | None = None
    viewport: tuple[Pixels, Pixels] | None = None


class Answer(StrictModel):
    """In ``Check`` and ``Ask``: an option in its words, or a written answer; empty to skip an optional ``Ask``.

    ``rt`` is the time from painting the scene to the answer, ms.
    """

    kind: Literal["answer"] = "answer"
    answer: Annotated[str, Field(max_length=LONGEST_ANSWER)]
    rt: Milliseconds


class Answers(StrictModel):
    """In ``ComprehensionQuestions``: an option for each question, in their order.

    ``rt`` is the time from painting the scene to the answers, ms.
    """

    kind: Literal["answers"] = "answers"
    answers: Annotated[tuple[Annotated[str, Field(max_length=200)], ...], Field(max_length=20)]
    rt: Milliseconds


Act = Annotated[Agree | Next | Attempt | Answer | Answers, Field(discriminator="kind")]
"""One act in a scene."""

_WRITTEN = {"number": re.compile(r"[+-]?[0-9]{1,15}([.,][0-9]{1,15})?"), "integer": re.compile(r"[+-]?[0-9]{1,15}")}


def fits(question: Ask, act: Answer) -> bool:
    """Whether an answer is acceptable.

    >>> age = Ask(name="age", question="How old are you?", type="integer", low=18, high=120)
    >>> [fits(age, Answer(answer=answer, rt=1.0)) for answer in ("34", "banana", "7", "")]
    [True, False, False, True]
    """
    answer = act.answer.strip()
    if not answer:
        return not question.required
    if question.options:
        return act.answer in question.options
    if question.type == "text":
        return True
    if not _WRITTEN[question.type].fullmatch(answer):
        return False
    number = float(answer.replace(",", "."))
    return not (
        (question.low is not None and number < question.low) or (question.high is not None and number > question.high)
    )
