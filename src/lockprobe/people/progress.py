"""How far people have come, for the experimenter: counts, and nothing that somebody wrote or was sent with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

from lockprobe.people.assignment import Cell, conditions_of
from lockprobe.people.diary import Slot
from lockprobe.people.journey import Journey
from lockprobe.studies.study import Study

__all__ = ["ConditionProgress", "ParticipantProgress", "Progress", "progress_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionProgress:
    """One condition.

    Attributes:
        p: Flip probability.
        modality: How the box is shown.
        slots: Trials of people that the study has.
        finished: Those that are on record.
        under_way: Those that somebody has who takes part and that are not finished.
        free: Those that nobody has.
    """

    p: float
    modality: str
    slots: int
    finished: int
    under_way: int
    free: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantProgress:
    """One participant.

    Attributes:
        identity: As it is in ``participant:ID``.
        stage: ``under way``, ``finished``, or ``late``: was away so long that trials were given to others.
        boxes_done: Boxes that are over.
        boxes: Boxes in all.
        broken: Boxes of these that broke.
        last_act: Seconds since 1970 (UTC).
        checks_right: Attention checks answered right.
        checks_wrong: Answered wrong.
    """

    identity: str
    stage: Literal["under way", "finished", "late"]
    boxes_done: int
    boxes: int
    broken: int
    last_act: float
    checks_right: int
    checks_wrong: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """A study as far as people play it.

    Attributes:
        conditions: In the order of the study.
        participants: In the order in which they joined.
        joined: How many have joined and not withdrawn.
        finished: How many have come to the end.
        withdrawn: How many have withdrawn.
        late: How many were away too long.
        checks_right: Attention checks answered right, over all.
        checks_wrong: Answered wrong.
    """

    conditions: tuple[ConditionProgress, ...]
    participants: tuple[ParticipantProgress, ...]
    joined: int
    finished: int
    withdrawn: int
    late: int
    checks_right: int
    checks_wrong: int


def progress_of(study: Study, journeys: Sequence[Journey], finished: Collection[Slot], withdrawn: int) -> Progress:
    """How far people have come.

    Args:
        study: The study.
        journeys: Of all who have joined and not withdrawn.
        finished: Trials that are on record, whoever played them.
        withdrawn: How many have withdrawn.
    """
    done = Counter(map(_condition, finished))
    open_ones = {slot for journey in journeys for slot in journey.slots_kept} - set(finished)
    under_way = Counter(map(_condition, open_ones))
    slots = study.repetitions * study.trials
    people = tuple(map(_participant, journeys))
    return Progress(
        conditions=tuple(
            ConditionProgress(
                p=one[0],
                modality=one[1],
                slots=slots,
                finished=done[one],
                under_way=under_way[one],
                free=slots - done[one] - under_way[one],
            )
            for one in conditions_of(study)
        ),
        participants=people,
        joined=len(people),
        finished=sum(person.stage == "finished" for person in people),
        withdrawn=withdrawn,
        late=sum(person.stage == "late" for person in people),
        checks_right=sum(person.checks_right for person in people),
        checks_wrong=sum(person.checks_wrong for person in people),
    )


def _condition(slot: Slot) -> Cell:
    return slot.p, slot.modality


def _participant(journey: Journey) -> ParticipantProgress:
    right = sum(journey.checks)
    return ParticipantProgress(
        identity=journey.identity,
        stage="late" if journey.released else "finished" if journey.finished else "under way",
        boxes_done=len(journey.endings),
        boxes=len(journey.joined.slots),
        broken=sum(ending == "error" for ending in journey.endings.values()),
        last_act=journey.at,
        checks_right=right,
        checks_wrong=len(journey.checks) - right,
    )
