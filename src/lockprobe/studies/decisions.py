"""A study that stops when it is decided: what it asks, what its outcomes have decided, and what is still played.

Everything is computed from the trials on record, block by block in the order of the plan. What is said of a block
depends on no later block, so it does not depend on how many trials were open at once, on the order in which they ended,
or on where a run was interrupted. The runner, the page and ``lockprobe status`` use this one rule.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import dropwhile
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.design import arms_of
from lockprobe.statistics.every_look import AtEveryLook, Numbers, at_every_look, held_at_both_ends
from lockprobe.statistics.outcomes import BlockOrder
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why import CONTRASTS, NEEDS, PART, TOTAL
from lockprobe.studies.records.store import OnRecord
from lockprobe.studies.study import Study, Until, design_of
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial

Array = NDArray[np.float64]

LOOK_EVERY = 5
"""Blocks that are played between two looks, so that trials of a hosted model can be open at the same time."""

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
        after: The question that must be an effect for these to matter; None if they always do.
    """

    questions: tuple[Question, ...]
    choices: float
    after: Question | None = None


Finished = Trial | OnRecord
"""A trial that ended, whole or as the store says it; an agent, a place and an ending are all that is asked for."""

_One = TypeVar("_One", bound=Finished)

GIVE_UP_AFTER = 10
"""Trials broken in a row, by something outside the agent, after which a run gives the agent up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What was decided on a question.

    Attributes:
        question: The question.
        verdict: What was decided; None if nothing was.
        at: The block (from 1) with which it was decided; None if it was not.
        way: Sign of the difference where it is an effect.
        course: Its estimate after each block, whatever became of broken trials.
    """

    question: Question
    verdict: Verdict | None
    at: int | None
    way: int = 0
    course: AtEveryLook = field(compare=False)


def decisions(families: Iterable[Family], outcomes: Outcomes, until: Until) -> tuple[Decision, ...]:
    """What the outcomes of an agent have decided.

    Args:
        families: What is asked.
        outcomes: The outcomes in the order of the blocks. A statement must hold without the broken trials and at both
            ends of what these can have become.
        until: When the study stops.
    """
    ended = {label: solved for label, (solved, _) in outcomes.items()}
    cases = [(ended, ended)]  # what counts for a difference, and what counts against it
    if any(broken.any() for _, broken in outcomes.values()):
        failed, opened = (
            {label: np.where(broken, end, solved) for label, (solved, broken) in outcomes.items()} for end in (0, 1)
        )
        cases += [(failed, opened), (opened, failed)]
    found, parts = dict[Question, Decision](), dict[Question, list[Decision]]()
    for family in families:
        tried = []
        for up, down in cases:
            by_block = []
            for question in family.questions:
                terms = [up[more] - down[less] if less else 2 * up[more] - 1 for more, less in question.terms]
                values = np.mean(terms, axis=0)
                there = np.flatnonzero(~np.isnan(values))
                by_block.append(Numbers(values=values[there], block=there))
            tried.append(at_every_look(by_block, agents=family.choices, margin=until.margin))
        for question, *courses in zip(family.questions, *tried, strict=True):
            found[question] = one = _decided(question, courses, until)
            if family.after is not None:
                parts.setdefault(family.after, []).append(one)
    for premise, contrasts in parts.items():
        found |= {one.question: _settled(one, found[premise], contrasts) for one in contrasts}
    return tuple(found.values())


def _decided(question: Question, courses: Sequence[AtEveryLook], until: Until) -> Decision:
    """How closely a difference is known, or that it is an effect or small in every case."""
    course = held_at_both_ends(*courses) if len(courses) > 1 else courses[0]
    if until.rule == "width" or question.of_share:  # a share is asked for on a scale from -1 to 1
        at = courses[0].narrow_at((2 if question.of_share else 1) * until.points)
        return Decision(question=question, verdict=None if at is None else "narrow", at=at, course=course)
    effect, small = (
        max(blocks) if all(blocks := [getattr(one, name) or 0 for one in courses]) else None
        for name in ("effect_at", "small_at")
    )
    if effect is not None and effect <= (small or effect) and len({one.way for one in courses}) == 1:
        return Decision(question=question, verdict="effect", at=effect, way=courses[0].way, course=course)
    return Decision(question=question, verdict=None if small is None else "small", at=small, course=course)


def _settled(one: Decision, premise: Decision, contrasts: Iterable[Decision]) -> Decision:
    """A contrast of arms is settled with the total effect, if that is small: there is nothing to explain.

    If it is an effect, it is settled as soon as a claim on the mechanism has all of its contrasts. That two false
    statements do what one does ("falsity") names none yet.
    """
    verdict: Verdict = "small" if premise.verdict == "small" else "not needed"
    ends = [premise.at] if verdict == "small" else []
    known = {of.question.name: of for of in contrasts}
    for claim in NEEDS.keys() - {"falsity"} if premise.verdict == "effect" else ():
        needed = [(known.get(need.lstrip("-")), -1 if need[0] == "-" else 1) for need in NEEDS[claim]]
        if all(of and of.way * premise.way == way for of, way in needed):
            ends.append(max(of.at or 0 for of in (premise, *(of for of, _ in needed if of))))
    at = min((end for end in ends if end), default=None)
    return one if at is None or (one.at is not None and one.at <= at) else replace(one, verdict=verdict, at=at)


def block_orders(study: Study) -> dict[str, BlockOrder]:
    """Agent -> the order of its blocks, for what must hold at every look; people have none, who come in any order."""
    margin = study.until.margin if study.until else None
    return {
        study.label_of(agent): BlockOrder(
            plans=(
                *((one.repetitions, study.trials_of(agent, one)) for one in study.earlier),
                (study.repetitions, study.trials_of(agent)),
            ),
            margin=margin,
        )
        for agent in study.run_agents
    }


def _ranks(study: Study, agent: str) -> dict[tuple[int, int], int]:
    """The blocks of an agent in their order, each with its place, from 0."""
    blocks = [*study.blocks_of(agent)]
    ranks = block_orders(study)[study.label_of(agent)].rank(*zip(*blocks, strict=True)).tolist()
    return dict(sorted(zip(blocks, ranks, strict=True), key=lambda one: one[1]))


def counted(study: Study, trials: Iterable[_One]) -> tuple[_One, ...]:
    """The trials of every condition up to its first block that is still open, in their order; of people all.

    Later ones have ended early, so that they tell something about how they ended.
    """
    found = list(trials)
    there = {(one.group, one.condition, one.repetition, one.trial) for one in found}
    played, behind = {one.group for one in found}, set[tuple[str, str, int, int]]()
    for agent in (one for one in study.run_agents if study.label_of(one) in played):
        name, blocks = study.label_of(agent), [*_ranks(study, agent)]
        for condition in study.conditions:
            here = [(name, condition.label, *block) for block in blocks if study.in_shard(agent, condition, *block)]
            behind.update(dropwhile(there.__contains__, here))
    return tuple(one for one in found if (one.group, one.condition, one.repetition, one.trial) not in behind)


def families(study: Study, agent: str) -> tuple[Family, ...]:
    """What a study asks of an agent: every condition against the control, or the parts of a false report.

    The families are those of the report. With a single condition its success is asked for.
    """
    asked = _questions(study, agent)
    alike = [one for one in study.run_agents if is_baseline(one) == is_baseline(agent)]
    many = len(asked) * sum(bool(_questions(study, one)) for one in alike)
    if not asked:
        return tuple(Family((Question(one.label, ((one.label, ""),)),), 1) for one in study.conditions_of(agent))
    found = []
    for of in asked:
        if (total := of[0]).name == "total":  # at the usual level, and each contrast of arms at its own
            found.append(Family((total,), many))
            found += [Family((one,), many * ALPHA / PART, after=total) for one in of[1:]]
        else:
            found.append(Family(of, many))
    return tuple(found)


def _questions(study: Study, agent: str) -> list[tuple[Question, ...]]:
    design, played = design_of(study), {one.label for one in study.conditions_of(agent)}
    found: list[tuple[Question, ...]] = []
    for modality, shown in design.shown.items():
        if arms := arms_of(shown):
            of = arms[1]
            parts = tuple(
                Question(name, tuple((of[more], of[less]) for more, less in zip(one.of, one.minus, strict=True)))
                for name, one in {"total": TOTAL, **CONTRASTS}.items()
                if {*one.of, *one.minus} <= of.keys()
            )
            asked_for = {label for one in parts for label in one.labels}
            more = [one.label for one in shown if one.label not in asked_for and one.label in played]
            found += [parts, tuple(Question(one, ((one, of["truth"]),)) for one in more)]
            continue
        for (control, *labels), *_ in (one.groups for one in design.against_controls if one.modality == modality):
            found.append(tuple(Question(one, ((one, control),)) for one in labels if {one, control} <= played))
    return [of for of in found if of]


def answers(study: Study, agent: str, trials: Iterable[Finished]) -> tuple[Decision, ...]:
    """What trials on record, of other agents too, have decided of an agent. The study stops when it is decided."""
    assert study.until is not None
    ranks, name = _ranks(study, agent), study.label_of(agent)
    size = len(ranks)
    found = {one.label: (np.full(size, np.nan), np.zeros(size, bool)) for one in study.conditions_of(agent)}
    for one in counted(study, (one for one in trials if one.group == name and not one.owed_again)):
        place, (solved, broken) = ranks[one.repetition, one.trial], found[one.condition]
        broken[place] = one.ending == "error"
        solved[place] = np.nan if broken[place] else one.solved
    return decisions(families(study, agent), found, study.until)


def answers_by_agent(study: Study, trials: Iterable[Finished]) -> dict[str, tuple[Decision, ...]]:
    """The same of every agent that is run, by its name."""
    found = list(trials)
    return {study.label_of(agent): answers(study, agent, found) for agent in study.run_agents}


def owed_by_look(study: Study, agent: str, trials: Iterable[Finished]) -> Iterator[list[Plan]]:
    """Yield the trials that an agent has to play until each look, as far as trials on record leave them open.

    A condition that no open question needs is no longer played. Trials of equal repetition and trial share their luck,
    so this changes nothing for the others.
    """
    name, conditions = study.label_of(agent), study.conditions_of(agent)
    trials = [one for one in trials if one.group == name]
    found, finished = answers(study, agent, trials), {one.key for one in trials if not one.owed_again}
    places = [one for one in _ranks(study, agent).items() if study.in_shard(agent, conditions[0], *one[0])]
    for start in range(0, len(places), LOOK_EVERY):
        kept = wanted(found, places[start][1])
        plans = [
            study.plan(agent, condition, *block)
            for block, _ in places[start : start + LOOK_EVERY]
            for condition in conditions
            if condition.label in kept
        ]
        if owed := [plan for plan in plans if plan.key not in finished]:
            yield owed


def wanted(found: Iterable[Decision], blocks: int) -> frozenset[str]:
    """The conditions that are played on after this many blocks: those that a question needs which they left open."""
    return frozenset(label for one in found if one.at is None or one.at > blocks for label in one.question.labels)


def due(study: Study, agent: str, trials: Iterable[Finished]) -> list[Plan]:
    """The trials that an agent has to play before the next look; none if all is decided, or the most is played."""
    return next(owed_by_look(study, agent, trials), [])


def broken_by_agent(study: Study, trials: Iterable[Trial]) -> dict[str, int]:
    """Agent -> its trials without a valid end, of agents through all of whose trials a run has gone, or gave them up.

    A run plays them again, but nothing of what others play is open because of them.
    """
    found, by_agent = dict[str, int](), grouped(trials, lambda trial: trial.group)
    for agent in study.run_agents:
        own = by_agent.get(study.label_of(agent), [])
        ended = {one.key for one in own if not one.owed_again}
        if len(ended) == len(own):
            continue
        plans = study.plans(agent) if study.until is None else due(study, agent, own)
        owed, played = [plan.key for plan in plans if plan.key not in ended], {one.key for one in own}
        if played.issuperset(owed) or (not ended and len(own) >= GIVE_UP_AFTER):
            found[study.label_of(agent)] = len(owed)
    return found


def planned_now(study: Study, trials: Iterable[Trial]) -> int:
    """The trials of a plan: all, or of a study that stops when it is decided those up to its next look.

    Args:
        study: The study.
        trials: Its trials on record.
    """
    if study.until is None:
        return study.size
    trials = list(trials)
    owed = sum(len(due(study, agent, trials)) for agent in study.run_agents)
    return study.places_filled(trials) + owed
