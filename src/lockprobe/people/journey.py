"""How far participants have come: the fold of a diary, for the server, the status of a study, reports and exports.

A participant sees the consent scene, instructions, questions on them, practice, checks, each box and the scene after
it, questions, and the debriefing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.diary import (
    Act,
    Agree,
    Answers,
    Attempt,
    Broken,
    Diary,
    Did,
    Entry,
    Joined,
    Released,
    Slot,
    bad_diary,
)
from lockprobe.people.experiment import Experiment
from lockprobe.people.texts import Words
from lockprobe.studies.records.store import STORE
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.study import Study
from lockprobe.trial.record import Ending, Trial

_AS_LONG = {"box": 6}
"""How many pages of text take as long as a scene of a kind, by eye; only the bar of progress uses it."""


class Station(NamedTuple):
    """One scene in a participant's order of scenes.

    ``item`` is the number of a page or check, from 1, or the name of a question. ``box`` counts from 1; 0 is practice.
    """

    kind: Literal["page", "comprehension", "box", "over", "check", "ask", "debrief"]
    item: str = ""
    box: int = 0


def stations(experiment: Experiment, words: Words, boxes: int) -> tuple[Station, ...]:
    """All scenes of a participant who has agreed to take part and plays this many boxes, in order."""

    def through(box: int) -> Iterator[Station]:
        """A box, the scene after it, and the checks then."""
        if box or experiment.practice:
            yield Station("box", box=box)
            yield Station("over", box=box)
        for number, check in enumerate(experiment.checks, 1):
            if check.after == box:
                yield Station("check", str(number))

    return (
        *(Station("page", str(number)) for number in range(1, len(words.instructions) + 1)),
        *([Station("comprehension")] if asks_comprehension(experiment, words) else []),
        *(station for box in range(boxes + 1) for station in through(box)),
        *(Station("ask", question.name) for question in experiment.questions),
        Station("debrief"),
    )


def asks_comprehension(experiment: Experiment, words: Words) -> bool:
    """Whether questions follow the instructions."""
    asked = experiment.comprehension
    return asked.ask and bool(asked.questions or words.comprehension.questions)


class Journey:
    """How far one participant has come. Feed it the lines of the diary with :meth:`follow`, or use :meth:`of`.

    Args:
        joined: The first line of the diary.
        way: All scenes in order, from :func:`stations`. Only ``station``, ``finished`` and ``share`` need it.

    Attributes:
        turn: The number of the scene shown, from 2.
        last: The last act, which may be sent again if its reply was lost; None where a box broke after it.
        at: When the last act was written, seconds since 1970.
        since: When the scene was first shown; in a box, the box.
        steps: The steps of each box, by its number; 0 is practice.
        began: When each box with a step was first shown.
        endings: How each finished box ended.
        shut: Why the participant cannot go on and others may play the unfinished trials; empty otherwise.
        rounds: How often the questions on the instructions were answered.
        misread: The answers of the last round if one was wrong; None otherwise.
        checks: For each answered attention check, whether the answer was right.
    """

    def __init__(self, joined: Joined, way: Sequence[Station] = ()) -> None:
        self.joined = joined
        self.turn = 2
        self.last: Act | None = Agree(agreed=True)
        self.at = self.since = joined.at
        self.steps: dict[int, list[Did]] = {}
        self.began: dict[int, float] = {}
        self.endings: dict[int, Ending] = {}
        self.shut: Literal["", "late", "screened"] = ""
        self.rounds = 0
        self.misread: Answers | None = None
        self.checks: list[bool] = []
        self._way = way
        self._places = {station: place for place, station in enumerate(way)}
        self._place = 0

    @classmethod
    def of(cls, diary: Diary, way: Sequence[Station] = ()) -> Journey:
        """How far a participant has come by the end of a diary."""
        journey = cls(diary.joined, way)
        for line in diary.lines:
            journey.follow(line)
        return journey

    @property
    def station(self) -> Station:
        """The scene that the participant is in."""
        return self._way[self._place]

    @property
    def boxes_done(self) -> bool:
        """Whether all boxes are over."""
        return len(self.endings.keys() - {0}) == len(self.joined.slots)

    @property
    def closed_boxes(self) -> frozenset[int]:
        """The boxes in which nothing more can happen, from 1: finished ones, and all after a release."""
        return frozenset(range(1, len(self.joined.slots) + 1) if self.shut else self.endings.keys() - {0})

    @property
    def finished(self) -> bool:
        """Whether the participant has reached the debriefing."""
        return self.station.kind == "debrief"

    @property
    def share(self) -> float:
        """How much of the way lies behind the participant, [0, 1]."""
        lengths = [_AS_LONG.get(station.kind, 1) for station in self._way[:-1]]
        return sum(lengths[: self._place]) / max(1, sum(lengths))

    @property
    def slots_kept(self) -> tuple[Slot, ...]:
        """The trials that nobody else can play: finished or still planned here, without broken ones."""
        return tuple(
            slot
            for box, slot in enumerate(self.joined.slots, 1)
            if (self.endings[box] != "error" if box in self.endings else not self.shut)
        )

    def attempts(self, box: int) -> list[RecordedAttempt]:
        """The steps of a box, to be played again."""
        acts = ((did.act, did.told) for did in self.steps.get(box, ()))
        return [RecordedAttempt(act.joint, act.claimed, told) for act, told in acts if isinstance(act, Attempt)]

    def seconds(self, box: int) -> float:
        """How long a box with a step took, from when it was shown to its last step."""
        return self.steps[box][-1].at - self.began[box]

    def follow(self, line: Entry) -> None:
        """Take in the next line of the diary."""
        assert not isinstance(line, Joined)
        if isinstance(line, Released):
            self.shut = line.why
            return
        self.turn, self.at = line.turn + 1, line.at
        if isinstance(line, Broken):
            ending: Ending | None = "error"
            self.last, station = None, Station("box", box=line.box)
        else:
            self.last, ending = line.act, line.ended
            item = "" if line.scene == "comprehension" else line.item
            station = Station(line.scene, item, line.box or 0)  # type: ignore[arg-type] # as it was written
            if station.kind == "box":
                self.began.setdefault(station.box, self.since)
                self.steps.setdefault(station.box, []).append(line)
            if station.kind == "check" and line.right is not None:
                self.checks.append(line.right)
            if isinstance(line.act, Answers):
                self.rounds += 1
                self.misread = None if line.right else line.act
                if not line.right:
                    self._place, self.since = 0, line.at
                    return
        if station.kind == "box":
            if ending is None:
                self._place = self._places.get(station, self._place)
                return
            self.endings[station.box] = ending
        # a station that is no longer on the way changes nothing
        self._place, self.since = self._places.get(station, self._place - 1) + 1, line.at


def acts_of_steps(
    study: Study, trials: Mapping[str, Trial], diaries: Iterable[Diary], directory: Path
) -> dict[tuple[str, int], Did]:
    """The act behind each step of people's trials, by key of the trial and step from 1: records have no clock.

    ``directory`` is named in messages.

    Raises:
        BadFile: If a diary and a record disagree, or a diary belongs to another study.
    """
    found: dict[tuple[str, int], Did] = {}
    for diary in diaries:
        diary.check_slots(study, directory)
        for box, steps in Journey.of(diary).steps.items():
            trial = trials.get(key := diary.key(study, box))
            if trial is None or trial.agent != diary.spec:
                continue
            acts = {did.step: (did, did.act) for did in steps}
            for step in trial.steps:
                did, act = acts.get(step.step, (None, None))
                said = step.decision
                if did is None or not isinstance(act, Attempt):
                    why = f"step {step.step} of {key} is not in the diary"
                elif (act.joint, act.claimed) != (said.joint, said.claimed):
                    why = f"step {step.step} of {key} is {act.joint} in the diary, and {said.joint} on record"
                else:
                    found[key, step.step] = did
                    continue
                raise bad_diary(directory / STORE, diary.identity, why)
    return found


def seconds_of_trials(study: Study, diaries: Iterable[Diary]) -> dict[str, float]:
    """How long each finished box took its participant, from when it was shown to its last step, by its key."""
    found = {}
    for diary in diaries:
        journey = Journey.of(diary)
        for box, steps in journey.steps.items():
            if box and steps[-1].ended:
                found[diary.key(study, box)] = round(journey.seconds(box), 3)
    return found


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
    playing = [journey for journey in journeys if journey.shut != "screened"]
    boxes = [(slot.condition, box in one.endings) for one in playing for box, slot in enumerate(one.joined.slots, 1)]
    given, left = Counter(condition for condition, _ in boxes), Counter(one for one, over in boxes if not over)
    finished = sum(journey.boxes_done for journey in journeys)
    checks = [right for journey in journeys for right in journey.checks]
    return Flow(
        consented=len(journeys) + gone,
        withdrawn=gone,
        screened=len(journeys) - len(playing),
        left_open=len(playing) - finished,
        finished=finished,
        questioned=sum(journey.rounds > 0 for journey in journeys),
        second_round=sum(journey.rounds > 1 for journey in journeys),
        checks=len(checks),
        right=sum(checks),
        boxes={
            one.label: (given[one.label], left[one.label]) for one in study.conditions_of(PEOPLE) if given[one.label]
        },
    )
