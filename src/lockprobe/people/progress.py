"""Counts of participants and boxes, for the status of a study and its report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from lockprobe.people.assignment import conditions_of
from lockprobe.people.diary import Diary
from lockprobe.people.journey import Journey
from lockprobe.studies.study import Study


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
        boxes: Condition -> boxes assigned when people joined, and those of them that are not over, in the order of the
            study; without those of people who were screened out before the first box.
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
    boxes: Mapping[str, tuple[int, int]]


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
        boxes={one: (given[one], left[one]) for one in conditions_of(study) if given[one]},
    )
