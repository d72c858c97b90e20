"""Sentences on what holds at every look: why it does, what is decided, and which differences are small."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.foundation.formatting import listed, points
from lockprobe.report.prose.subject import Subject
from lockprobe.studies.stopping import Answer
from lockprobe.studies.study import Study

_HOLDS = "Success and differences in success are shown as they hold at every look"

PEOPLE_SAID = "What people did is shown as it holds for one look, at a number of people that was fixed before."

_NAMED = 3
"""Conditions that a sentence names."""


def every_look_said(study: Study, kind: str, answers: Mapping[str, Sequence[Answer]], played: int) -> str:
    """For how many looks the page holds, and why; empty for a study of fixed size that is finished.

    Args:
        study: The study.
        kind: Why it must hold at every look: until, extended or unfinished.
        answers: Agent -> what is decided, of a study that stops when it is.
        played: Its finished trials.
    """
    if kind == "until":
        return f"{progress_said(study, answers, played)}. {_HOLDS}."
    if kind == "extended":
        return f"Trials were added to this study after it had begun. {_HOLDS}."
    return f"{_HOLDS}, so that reading them now and playing on is valid." if kind else ""


def progress_said(study: Study, answers: Mapping[str, Sequence[Answer]], played: int) -> str:
    """How many differences a study that stops when it is decided has decided, without a full stop.

    Args:
        study: The study.
        answers: Agent -> what is decided.
        played: Its finished trials.
    """
    found = [one for own in answers.values() for one in own]
    done, of = sum(one.at is not None for one in found), len(found)
    assert study.until is not None
    what = "decided" if study.until.rule == "decided" else f"known to {study.until} points"
    number = f"{done} of {of} differences are" if of > 1 else f"The difference is{'' if done else ' not'}"
    end = "" if done == of else " yet" if of == 1 else ""
    return f"{number} {what}{end}, with {played} of at most {study.size} trials"


def halves_said(one: Answer) -> str:
    """A difference over all blocks and in each half of them, to be compared; empty for a share and for one block."""
    if one.question.of_share or one.course.n < 2:
        return ""
    first, second = map(points, one.course.halves)
    return f"{points(one.course.value)} points, {first} in the first half of the blocks and {second} in the second"


def small_said(answers: Mapping[str, Sequence[Answer]], points: float) -> str:
    """Which differences are shown to be smaller than the margin, either way; empty if none is.

    Args:
        answers: Agent -> what is decided.
        points: The margin, (0, 1).
    """
    found = {agent: [one.question.name for one in own if one.verdict == "small"] for agent, own in answers.items()}
    said = [f"{listed(names, named=_NAMED)} on {Subject.of(agent).name}" for agent, names in found.items() if names]
    if not said:
        return ""
    more = len(said) - _NAMED
    rest = f"; and on {more} more agent{'s' * (more > 1)}" if more > 0 else ""
    return (
        f"Shown to be smaller than {100 * points:g} points, either way: effects of {'; of '.join(said[:_NAMED])}{rest}."
    )


def effects_said(answers: Mapping[str, Sequence[Answer]]) -> str:
    """Which differences are shown to be effects, and their direction."""
    said = [
        f"{one.question.name} {'raises' if one.course.value > 0 else 'lowers'} the success of {Subject.of(agent).name}"
        for agent, own in answers.items()
        for one in own
        if one.verdict == "effect"
    ]
    more = len(said) - _NAMED
    rest = f"; and {more} more" if more > 0 else ""
    return f"Compared with the first: {'; '.join(said[:_NAMED])}{rest}." if said else "No effect is decided yet."


def decided_said(verdict: str | None, points: float) -> str:
    """What was decided of a difference, in words.

    >>> decided_said("effect", 0.1), decided_said("small", 0.1), decided_said(None, 0.1)
    ('an effect', 'smaller than 10 points', 'open')
    """
    said = {"effect": "an effect", "small": f"smaller than {100 * points:g} points", "not needed": "not needed"}
    return said.get(verdict or "", f"known to ±{100 * points:g} points" if verdict else "open")
