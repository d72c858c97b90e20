"""The rule of a study that stops when it is decided, over outcomes alone: what is decided, and what is still played.

The runner applies it to the trials on record. What it says of a block depends on no later block.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.sequential.contrasts import Numbers, at_every_look, decided_at_every_look
from lockprobe.statistics.why.mechanism import NEEDS
from lockprobe.studies.until import Until

Array = NDArray[np.float64]

Outcomes = Mapping[str, tuple[Array, NDArray[np.bool_]]]
"""Condition -> whether each block was solved (NaN where it was not played, or broke), and whether its trial broke."""

Verdict = Literal["effect", "small", "narrow", "not needed"]
"""The difference is not 0; it is smaller than the margin; its interval is as narrow as asked; a mechanism is named, so
that no other contrast of arms is needed."""


@dataclass(frozen=True, slots=True)
class Question:
    """A difference that a study is to decide.

    Attributes:
        name: The condition, or the contrast of arms.
        terms: Pairs of conditions; the difference is the mean of the first minus the second of each. With a second
            that is empty, the success of the first itself is asked for.
    """

    name: str
    terms: tuple[tuple[str, str], ...]

    @property
    def labels(self) -> frozenset[str]:
        """The conditions that it needs."""
        return frozenset(label for pair in self.terms for label in pair if label)

    @property
    def of_share(self) -> bool:
        """Whether it asks for the success of a single condition."""
        return not self.terms[0][1]


@dataclass(frozen=True, slots=True)
class Family:
    """Questions that are judged together.

    Attributes:
        questions: The questions.
        choices: For how many such families their levels are corrected (Bonferroni).
        after: Name of a question that must be an effect for these to matter; empty if they always do.
    """

    questions: tuple[Question, ...]
    choices: float
    after: str = ""


@dataclass(frozen=True, slots=True)
class Decision:
    """What was decided on a question.

    Attributes:
        question: The question.
        verdict: What was decided; None if nothing was.
        at: The block (from 1) with which it was decided; None if it was not.
        way: Sign of the difference where it is an effect.
    """

    question: Question
    verdict: Verdict | None
    at: int | None
    way: int = 0


def decisions(families: Iterable[Family], outcomes: Outcomes, until: Until) -> tuple[Decision, ...]:
    """What the outcomes of an agent have decided.

    Args:
        families: What is asked.
        outcomes: The outcomes in the order of the blocks. A statement must hold without the broken trials and at both
            ends of what these can have become.
        until: When the study stops.
    """
    found = [(family, [*_decided(family, outcomes, until)]) for family in families]
    every = [one for _, own in found for one in own]
    return tuple(_settled(one, every, family.after) if family.after else one for family, own in found for one in own)


def _settled(one: Decision, found: Sequence[Decision], after: str) -> Decision:
    """A contrast of arms is settled with the total effect, if that is small: there is nothing to explain.

    If it is an effect, it is settled as soon as a mechanism is named.
    """
    premise = next(other for other in found if other.question.name == after)
    small = premise.verdict == "small"
    at = premise.at if small else _named_at(premise, found)
    if at is None or (one.at is not None and one.at <= at):
        return one
    return replace(one, verdict="small" if small else "not needed", at=at)


def _named_at(total: Decision, found: Sequence[Decision]) -> int | None:
    """The block with which a claim on the mechanism has all of its contrasts; None if none has.

    That two false statements do what one does ("falsity") names none yet.
    """
    if total.verdict != "effect" or total.at is None:
        return None
    ways = {one.question.name: one.way * total.way for one in found if one.verdict == "effect"}
    ends = {one.question.name: one.at or 0 for one in found}
    claims = [
        [(need.lstrip("-"), -1 if need[0] == "-" else 1) for need in NEEDS[claim]]
        for claim in NEEDS
        if claim != "falsity"
    ]
    held = [[ends[name] for name, _ in needs] for needs in claims if all(ways.get(name) == way for name, way in needs)]
    return min((max(total.at, *blocks) for blocks in held), default=None)


def _decided(family: Family, outcomes: Outcomes, until: Until) -> Iterator[Decision]:
    if until.rule == "width" or family.questions[0].of_share:
        yield from _narrow(family, outcomes, until)
        return
    tried = [
        decided_at_every_look(numbers_of(family, *case), agents=family.choices, margin=until.margin)
        for case in cases(outcomes)
    ]
    for i, question in enumerate(family.questions):
        courses = [case[i] for case in tried]
        effect = _last([one.effect_at for one in courses]) if len({one.way for one in courses}) == 1 else None
        small = _last([one.small_at for one in courses])
        if effect is not None and effect <= (small or effect):
            yield Decision(question, "effect", effect, courses[0].way)
        else:
            yield Decision(question, None if small is None else "small", small)


def _narrow(family: Family, outcomes: Outcomes, until: Until) -> Iterator[Decision]:
    solved = {label: one for label, (one, _) in outcomes.items()}
    courses = at_every_look(numbers_of(family, solved, solved), agents=family.choices, margin=until.margin)
    for question, course in zip(family.questions, courses, strict=True):
        scale = 2 if question.of_share else 1  # a share is asked for on a scale from -1 to 1
        at = course.narrow_at(scale * until.points)
        yield Decision(question, None if at is None else "narrow", at)


_Solved = Mapping[str, Array]
"""Condition -> 1 where a block was solved, 0 where it was not, NaN where that is not known."""


def cases(outcomes: Outcomes) -> list[tuple[_Solved, _Solved]]:
    """The outcomes of what counts for a difference and of what counts against it: those of trials that ended.

    If trials broke, also with them unsolved in the one and solved in the other, and the reverse.
    """
    ended = {label: solved for label, (solved, _) in outcomes.items()}
    if not any(broken.any() for _, broken in outcomes.values()):
        return [(ended, ended)]
    failed, opened = (
        {label: np.where(broken, end, solved) for label, (solved, broken) in outcomes.items()} for end in (0, 1)
    )
    return [(ended, ended), (failed, opened), (opened, failed)]


def _last(blocks: Sequence[int | None]) -> int | None:
    """The last of these blocks, if all are known."""
    return max(block for block in blocks if block) if all(blocks) else None


def numbers_of(family: Family, up: _Solved, down: _Solved) -> list[Numbers]:
    """The differences that each question asks for, by block: what is subtracted is of ``down``, all else of ``up``."""
    found = []
    for question in family.questions:
        terms = [up[more] - down[less] if less else 2 * up[more] - 1 for more, less in question.terms]
        values = np.mean(terms, axis=0)
        there = np.flatnonzero(~np.isnan(values))
        found.append(Numbers(values=values[there], block=there))
    return found


def wanted(found: Iterable[Decision], blocks: int) -> frozenset[str]:
    """The conditions that are played on after this many blocks: those that a question needs which they left open."""
    return frozenset(label for one in found if one.at is None or one.at > blocks for label in one.question.labels)
