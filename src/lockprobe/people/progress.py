"""Counts of how far participants have come, for the admin page and for reports; nothing that somebody wrote."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lockprobe.people.assignment import conditions_of
from lockprobe.people.diary import Slot, read_diaries
from lockprobe.people.journey import Journey
from lockprobe.people.withdrawal import withdrawn
from lockprobe.studies.study import Study

__all__ = ["BoxesAt", "ConditionProgress", "Flow", "ParticipantProgress", "PeopleProgress", "flow_of", "progress_of"]


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
class PeopleProgress:
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


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxesAt:
    """Boxes of one condition.

    Attributes:
        modality: How they are shown.
        p: Flip probability, [0, 1].
        given: Boxes that people got when they joined.
        left_open: Of these, the boxes that are not over: left, or still to come.
    """

    modality: str
    p: float
    given: int
    left_open: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Everybody who joined a study, for its report: who dropped out bends all other numbers.

    Attributes:
        joined: How many joined and have not withdrawn.
        finished: How many of them have no box open any more.
        left_open: How many have: they left, or are still at it.
        withdrawn: How many withdrew besides; nothing else is known of them.
        checks: Attention checks answered.
        right: Of these, answered right.
        boxes: By condition, p ascending.
    """

    joined: int
    finished: int
    left_open: int
    withdrawn: int
    checks: int
    right: int
    boxes: tuple[BoxesAt, ...]


def progress_of(study: Study, journeys: Sequence[Journey], finished: Collection[Slot], gone: int) -> PeopleProgress:
    """How far people have come.

    Args:
        study: The study.
        journeys: Of all who have joined and not withdrawn.
        finished: Trials that are on record, whoever played them.
        gone: How many have withdrawn.
    """
    done = Counter(slot.cell for slot in finished)
    open_ones = {slot for journey in journeys for slot in journey.slots_kept} - set(finished)
    under_way = Counter(slot.cell for slot in open_ones)
    slots = study.repetitions * study.trials
    people = tuple(map(_participant, journeys))
    return PeopleProgress(
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
        withdrawn=gone,
        late=sum(person.stage == "late" for person in people),
        checks_right=sum(person.checks_right for person in people),
        checks_wrong=sum(person.checks_wrong for person in people),
    )


def flow_of(directory: Path) -> Flow | None:
    """How many participants of a study came to its end; None where nobody has taken part.

    Raises:
        BadFile: If a diary is damaged.
    """
    journeys, gone = [Journey.of(diary) for diary in read_diaries(directory)], withdrawn(directory)
    if not journeys and not gone:
        return None
    given: Counter[tuple[str, float]] = Counter()
    left: Counter[tuple[str, float]] = Counter()
    for journey in journeys:
        boxes = [(slot.modality, slot.p) for slot in journey.joined.slots]
        given.update(boxes)
        left.update(condition for box, condition in enumerate(boxes, 1) if box not in journey.endings)
    finished = sum(journey.boxes_done for journey in journeys)
    checks = [right for journey in journeys for right in journey.checks]
    return Flow(
        joined=len(journeys),
        finished=finished,
        left_open=len(journeys) - finished,
        withdrawn=gone,
        checks=len(checks),
        right=sum(checks),
        boxes=tuple(
            BoxesAt(modality=one[0], p=one[1], given=given[one], left_open=left[one])
            for one in sorted(given, key=lambda one: (one[1], one[0]))
        ),
    )


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
