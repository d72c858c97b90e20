"""What a study that stops when it is decided has to decide, what it has decided, and what it still has to play.

Everything is computed from the trials on record, block by block in the order of the plan. So it does not depend on how
many trials were open at once, on the order in which they ended, or on where a run was interrupted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.contrasts import AtEveryLook, Numbers, at_every_look
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.summary import is_reference
from lockprobe.statistics.why.arms import arms_of
from lockprobe.statistics.why.mechanism import CONTRASTS, PART
from lockprobe.studies.study import Study, trials_planned
from lockprobe.studies.study_design import design_of
from lockprobe.studies.until import LOOK_EVERY, EarlierPlan
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial

__all__ = ["Answer", "Family", "Question", "answers", "block_orders", "counted", "due", "families", "planned_now"]

Array = NDArray[np.float64]
_Outcomes = Mapping[str, tuple[Array, NDArray[np.bool_]]]
"""Condition -> whether each block was solved (NaN where not, or broken), and whether its trial broke."""

Verdict = Literal["effect", "small", "narrow"]
"""The difference is not 0; it is smaller than the margin; its interval is as narrow as asked."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What is known of a question.

    Attributes:
        question: The question.
        verdict: What was decided; None if nothing was.
        at: The block (from 1) with which it was decided; None if it was not.
        course: The estimate after each block.
    """

    question: Question
    verdict: Verdict | None
    at: int | None
    course: AtEveryLook


def block_orders(study: Study) -> dict[str, BlockOrder]:
    """Agent -> the order of its blocks, for what must hold at every look; people have none, who come in any order."""
    margin = study.until.margin if study.until else None
    plans: tuple[Study | EarlierPlan, ...] = (*study.earlier, study)
    return {
        study.label_of(agent): BlockOrder(
            plans=tuple((one.repetitions, trials_planned(agent, one)) for one in plans), margin=margin
        )
        for agent in study.run_agents
    }


def counted(study: Study, trials: Iterable[Trial]) -> tuple[Trial, ...]:
    """The trials of every condition up to its first block that is still open, in their order; of people all.

    Later ones have ended early, so that they tell something about how they ended.
    """
    found, orders = list(trials), block_orders(study)
    kept = {id(trial) for trial in found if trial.group not in orders}
    conditions = {one.label: one for one in study.conditions}
    for (name, label), own in grouped(found, lambda trial: (trial.group, trial.condition)).items():
        if name not in orders:
            continue
        agent, there = own[0].spec, {(one.repetition, one.trial): one for one in own}
        for _, block in _places(study, agent, orders[name]):
            if not study.in_shard(agent, conditions[label], *block):
                continue
            if block not in there:
                break
            kept.add(id(there[block]))
    return tuple(trial for trial in found if id(trial) in kept)


def _places(study: Study, agent: str, order: BlockOrder) -> list[tuple[int, tuple[int, int]]]:
    """The blocks of an agent in their order, each with its rank."""
    blocks = [*study.blocks_of(agent)]
    return sorted(zip(order.rank(*zip(*blocks, strict=True)).tolist(), blocks, strict=True))


def families(study: Study, agent: str) -> tuple[Family, ...]:
    """What a study asks of an agent: every condition against the control, or the parts of a false report.

    The families are those of the report. With a single condition its success is asked for.
    """
    found = _families(study, agent)
    alike = [one for one in study.run_agents if is_reference(one) == is_reference(agent)]
    many = len(found) * sum(bool(_families(study, one)) for one in alike)
    if not found:
        only = [Question(one.label, ((one.label, ""),)) for one in study.conditions_of(agent)]
        return tuple(Family((one,), 1) for one in only)
    return tuple(
        part
        for family in found
        for part in (_of_why(family, many) if family[0].name == "total" else [Family(family, many)])
    )


def _families(study: Study, agent: str) -> list[tuple[Question, ...]]:
    design, played = design_of(study), {one.label for one in study.conditions_of(agent)}
    found: list[tuple[Question, ...]] = []
    for modality in design.modalities:
        if arms := arms_of(design.shown(modality)):
            found.append(_parts(arms[1]))
            continue
        of = design.comparison(modality)
        axes = [[label for label in axis.doses if label != of.control] for axis in of.axes]
        for labels in (of.flips, *axes, of.others, of.controls):
            asked = tuple(Question(one, ((one, of.control),)) for one in labels if {one, of.control} <= played)
            found += [asked] if asked else []
    return found


def _parts(arms: Mapping[str, str]) -> tuple[Question, ...]:
    """The total effect, and the contrasts of arms that are played."""
    pairs = {"total": (("lie", "truth"),), **CONTRASTS}
    return tuple(
        Question(name, tuple((arms[more], arms[less]) for more, less in of))
        for name, of in pairs.items()
        if all(arm in arms for pair in of for arm in pair)
    )


def _of_why(parts: Sequence[Question], many: int) -> Iterator[Family]:
    """The total effect at the usual level, and each contrast at its own, as the rule of the study has it."""
    yield Family(tuple(parts[:1]), many)
    for one in parts[1:]:
        yield Family((one,), many * ALPHA / PART, after=parts[0].name)


def answers(study: Study, agent: str, trials: Iterable[Trial]) -> tuple[Answer, ...]:
    """What the trials of an agent have answered, of a study that stops when it is decided.

    Args:
        study: The study.
        agent: Spec of the agent.
        trials: Trials on record, of other agents too; broken ones count as unsolved and as solved, and a statement must
            hold either way.
    """
    seen = _seen(study, agent, trials)
    found = [(family, [*_answered(study, family, seen)]) for family in families(study, agent)]
    every = [one for _, own in found for one in own]
    return tuple(_without_premise(one, every, family) for family, own in found for one in own)


def _without_premise(one: Answer, found: Sequence[Answer], family: Family) -> Answer:
    """A contrast of arms is settled with the total effect, if that is small: there is nothing to explain."""
    premise = next((other for other in found if family.after and other.question.name == family.after), None)
    if premise is None or premise.verdict != "small" or (one.at or np.inf) <= (premise.at or 0):
        return one
    return replace(one, verdict="small", at=premise.at)


def _seen(study: Study, agent: str, trials: Iterable[Trial]) -> _Outcomes:
    order, name = block_orders(study)[study.label_of(agent)], study.label_of(agent)
    own = counted(study, (one for one in trials if one.group == name and not one.owed_again))
    by_label = grouped(own, lambda trial: trial.condition)
    size = 1 + max((int(order.rank(one.repetition, one.trial)) for one in own), default=-1)
    found = {}
    for condition in study.conditions_of(agent):
        members = by_label.get(condition.label, [])
        solved, broken = np.full(size, np.nan), np.zeros(size, dtype=np.bool_)
        place = order.rank([one.repetition for one in members], [one.trial for one in members])
        broken[place] = [one.error is not None for one in members]
        solved[place] = [np.nan if one.error is not None else one.solved for one in members]
        found[condition.label] = solved, broken
    return found


def _answered(study: Study, family: Family, seen: _Outcomes) -> Iterator[Answer]:
    assert study.until is not None
    cases = [{label: solved for label, (solved, _) in seen.items()}]
    if any(broken.any() for _, broken in seen.values()):
        cases += [{label: np.where(broken, end, solved) for label, (solved, broken) in seen.items()} for end in (0, 1)]
    judged = [
        at_every_look(
            [_numbers(one, case) for one in family.questions], agents=family.choices, margin=study.until.margin
        )
        for case in cases
    ]
    for i, question in enumerate(family.questions):
        courses = [case[i] for case in judged]
        if study.until.rule == "width" or not question.terms[0][1]:
            scale = 1 if question.terms[0][1] else 2  # a share is asked for on a scale from -1 to 1
            at = courses[0].narrow_at(scale * study.until.points)
            yield Answer(question=question, verdict="narrow" if at else None, at=at, course=courses[0])
            continue
        alike = len({np.sign(one.value) for one in courses}) == 1
        effect = _all([one.effect_at for one in courses]) if alike else None
        small = _all([one.small_at for one in courses])
        first = min((at, verdict) for at, verdict in ((effect or np.inf, "effect"), (small or np.inf, "small")))
        decided = first[0] < np.inf
        yield Answer(
            question=question,
            verdict=first[1] if decided else None,  # type: ignore[arg-type]
            at=int(first[0]) if decided else None,
            course=courses[0],
        )


def _all(blocks: Sequence[int | None]) -> int | None:
    """The last of these blocks, if all are known."""
    return max(block for block in blocks if block) if all(blocks) else None


def _numbers(question: Question, solved: Mapping[str, Array]) -> Numbers:
    terms = [solved[more] - solved[less] if less else 2 * solved[more] - 1 for more, less in question.terms]
    values = np.mean(terms, axis=0)
    there = np.flatnonzero(~np.isnan(values))
    return Numbers(values=values[there], block=there)


def due(study: Study, agent: str, trials: Iterable[Trial]) -> list[Plan]:
    """The trials that an agent has to play before the next look; none if all is decided, or the most is played.

    A condition that no open question needs is no longer played. Trials of equal repetition and trial share their luck,
    so this changes nothing for the others.
    """
    trials = [one for one in trials if one.group == study.label_of(agent)]
    found, conditions = answers(study, agent, trials), study.conditions_of(agent)
    finished = {one.key for one in trials if not one.owed_again}
    places = _places(study, agent, block_orders(study)[study.label_of(agent)])
    places = [one for one in places if study.in_shard(agent, conditions[0], *one[1])]
    for start in range(0, len(places), LOOK_EVERY):
        first = places[start][0]
        wanted = {label for one in found if one.at is None or one.at > first for label in one.question.labels}
        if not wanted:
            return []
        plans = [
            study.plan(agent, condition, *place)
            for _, place in places[start : start + LOOK_EVERY]
            for condition in conditions
            if condition.label in wanted
        ]
        if owed := [plan for plan in plans if plan.key not in finished]:
            return owed
    return []


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
