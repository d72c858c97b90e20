"""Whether an answer is one to its question: one of the options, a number within its limits, or words."""

from __future__ import annotations

import re

from lockprobe.people.responses import Answer
from lockprobe.people.scenes import Ask

__all__ = ["fits"]

_WRITTEN = {
    "number": re.compile(r"[+-]?[0-9]{1,15}([.,][0-9]{1,15})?"),
    "integer": re.compile(r"[+-]?[0-9]{1,15}"),
}


def fits(question: Ask, act: Answer) -> bool:
    """Whether an answer can be taken.

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
