"""Counts of participants and boxes, for the admin page and for reports."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from lockprobe.people.assignment import conditions_of
from lockprobe.people.diary import Diary, Slot
from lockprobe.people.journey import Journey
from lockprobe.studies.study import Study

__all__ = ["BoxesAt", "ConditionProgress", "Flow", "ParticipantProgress", "PeopleProgress", "flow_of", "progress_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionProgress:
    """Trials of one condition: ``slots`` in all, finished, assigned (``under_way``), and free."""

    condition: str
    slots: int
    finished: int
    under_way: int
    free: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantProgress:
    """One participant. ``last_act`` is in seconds since 1970 (UTC).

    ``late`` participants were away so long that others may play their unfinished trials. ``screened`` ones answered
    questions on the instructions wrong too often.
    """

    identity: str
    stage: Literal["under way", "finished", "late", "screened"]
    boxes_done: int
    boxes: int
    broken: int
    last_act: float
    checks_right: int
    checks_wrong: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleProgress:
    """A study as people play it; participants in the order in which they joined, without withdrawn ones."""

    conditions: tuple[ConditionProgress, ...]
    participants: tuple[ParticipantProgress, ...]
    joined: int
    finished: int
    withdrawn: int
    late: int
    screened: int
    checks_right: int
    checks_wrong: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxesAt:
    """Boxes of one condition: assigned when people joined, and those of them that are not over.

    Boxes of people who were screened out before the first box are not counted.
    """

    condition: str
    given: int
    left_open: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Everybody who agreed to take part in a study, for its report: dropout can bias every other number.

    Attributes:
        consented: Everybody who agreed: the sum of the next four.
        withdrawn: Participants who withdrew; nothing else is known of them.
        screened: Those whose session the limit of rounds of questions on the instructions ended, before any box.
        left_open: Those with open boxes: they left, or still take part.
        finished: Those with no open box.
        questioned: Those who answered questions on the instructions, screened-out ones among them.
        second_round: Those of them who needed a second round.
        checks: Attention checks answered.
        right: Those of them answered right.
        boxes: By condition, in the order of the study.
    """

    consented: int
    withdrawn: int
    screened: int
    left_open: int
    finished: int
    questioned: int
    second_round: int
    checks: int
    right: int
    boxes: tuple[BoxesAt, ...]


def progress_of(study: Study, journeys: Sequence[Journey], finished: Collection[Slot], gone: int) -> PeopleProgress:
    """The progress of a study.

    Args:
        study: The study.
        journeys: Of all participants who have not withdrawn.
        finished: Recorded trials, whoever played them.
        gone: Number of withdrawals.
    """
    done = Counter(slot.condition for slot in finished)
    open_ones = {slot for journey in journeys for slot in journey.slots_kept} - set(finished)
    under_way = Counter(slot.condition for slot in open_ones)
    slots = study.repetitions * study.trials
    people = tuple(map(_participant, journeys))
    return PeopleProgress(
        conditions=tuple(
            ConditionProgress(
                condition=one,
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
        screened=sum(person.stage == "screened" for person in people),
        checks_right=sum(person.checks_right for person in people),
        checks_wrong=sum(person.checks_wrong for person in people),
    )


def flow_of(study: Study, diaries: Iterable[Diary], gone: int) -> Flow | None:
    """How many participants reached the end; None where nobody has taken part. ``gone``: number of withdrawals."""
    journeys = [Journey.of(diary) for diary in diaries]
    if not journeys and not gone:
        return None
    given: Counter[str] = Counter()
    left: Counter[str] = Counter()
    for journey in journeys:
        if journey.shut == "screened":
            continue
        boxes = [slot.condition for slot in journey.joined.slots]
        given.update(boxes)
        left.update(condition for box, condition in enumerate(boxes, 1) if box not in journey.endings)
    finished = sum(journey.boxes_done for journey in journeys)
    screened = sum(journey.shut == "screened" for journey in journeys)
    checks = [right for journey in journeys for right in journey.checks]
    return Flow(
        consented=len(journeys) + gone,
        withdrawn=gone,
        screened=screened,
        left_open=len(journeys) - screened - finished,
        finished=finished,
        questioned=sum(journey.rounds > 0 for journey in journeys),
        second_round=sum(journey.rounds > 1 for journey in journeys),
        checks=len(checks),
        right=sum(checks),
        boxes=tuple(
            BoxesAt(condition=one, given=given[one], left_open=left[one]) for one in conditions_of(study) if given[one]
        ),
    )


def _participant(journey: Journey) -> ParticipantProgress:
    right = sum(journey.checks)
    return ParticipantProgress(
        identity=journey.identity,
        stage=journey.shut or ("finished" if journey.finished else "under way"),
        boxes_done=len(journey.endings),
        boxes=len(journey.joined.slots),
        broken=sum(ending == "error" for ending in journey.endings.values()),
        last_act=journey.at,
        checks_right=right,
        checks_wrong=len(journey.checks) - right,
    )
