"""How far one participant has come: the fold of a diary, for the server and for exports.

A participant sees the consent scene, instructions, questions on them, practice, checks, each box and the scene after
it, questions, and the debriefing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

from lockprobe.people.diary import Broken, Diary, Did, Entry, Joined, Released, Slot
from lockprobe.people.experiment import Experiment
from lockprobe.people.responses import Act, Agree, Answers
from lockprobe.people.texts import Words
from lockprobe.trial.record import Ending

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

    def checks(after: int) -> Iterable[Station]:
        for number, check in enumerate(experiment.checks, 1):
            if check.after == after:
                yield Station("check", str(number))

    way = [Station("page", str(number)) for number in range(1, len(words.instructions) + 1)]
    if asks_comprehension(experiment, words):
        way += [Station("comprehension")]
    if experiment.practice:
        way += [Station("box"), Station("over")]
    way += checks(0)
    for box in range(1, boxes + 1):
        way += [Station("box", box=box), Station("over", box=box), *checks(box)]
    way += [Station("ask", question.name) for question in experiment.questions]
    return (*way, Station("debrief"))


def asks_comprehension(experiment: Experiment, words: Words) -> bool:
    """Whether questions follow the instructions."""
    asked = experiment.comprehension
    return asked.ask and bool(asked.questions or words.comprehension.questions)


def fingerprint(words: Words) -> str:
    """Language and fingerprint of texts, for example ``en 3f9a01bc22d1``."""
    known = words.model_dump_json(exclude_none=True)
    return f"{words.language} {hashlib.sha256(known.encode()).hexdigest()[:12]}"


class Journey:
    """How far one participant has come. Feed it the lines of the diary with :meth:`follow`, or use :meth:`of`.

    Args:
        joined: The first line of the diary.
        way: All scenes in order, from :func:`stations`. Only ``station`` and ``finished`` need it.

    Attributes:
        turn: The number of the scene shown, from 2.
        last: The last act, which may be sent again if its reply was lost; None where a box broke after it.
        at: When the last act was written, seconds since 1970.
        endings: How each finished box ended, by its number, without the practice box.
        practised: How the practice ended; None before.
        shut: Why the participant cannot go on and others may play the unfinished trials; empty otherwise.
        rounds: How often the questions on the instructions were answered.
        misread: The answers of the last round if one was wrong; None otherwise.
        checks: For each answered attention check, whether the answer was right.
        pages: Version of the page on which each box began, by the number of the box, where known.
        played: The steps so far of the box that is under way.
        box_began: When the box that is under way was first shown, seconds since 1970.
    """

    def __init__(self, joined: Joined, way: Sequence[Station] = ()) -> None:
        self.joined = joined
        self.turn = 2
        self.last: Act | None = Agree(agreed=True)
        self.at = joined.at
        self.endings: dict[int, Ending] = {}
        self.practised: Ending | None = None
        self.shut: Literal["", "late", "screened"] = ""
        self.rounds = 0
        self.misread: Answers | None = None
        self.checks: list[bool] = []
        self.pages: dict[int, str] = {}
        self._way = way
        self._places = {station: place for place, station in enumerate(way)}
        self._place = 0
        self.played: list[Did] = []
        self.box_began = joined.at

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
        return len(self.endings) == len(self.joined.slots)

    @property
    def closed_boxes(self) -> frozenset[int]:
        """The boxes in which nothing more can happen, from 1: finished ones, and all after a release."""
        return frozenset(range(1, len(self.joined.slots) + 1) if self.shut else self.endings)

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

    def follow(self, line: Entry) -> None:
        """Take in the next line of the diary."""
        assert not isinstance(line, Joined)
        if isinstance(line, Released):
            self.shut = line.why
            return
        station = _of(line)
        if isinstance(line, Did) and line.page:
            self.pages[station.box] = line.page
        self.turn, self.at = line.turn + 1, line.at
        self.last = line.act if isinstance(line, Did) else None
        if isinstance(line, Did) and line.scene == "check" and line.right is not None:
            self.checks.append(line.right)
        if isinstance(line, Did) and isinstance(line.act, Answers):
            self.rounds += 1
            self.misread = None if line.right else line.act
            if not line.right:
                self._place, self.box_began = 0, line.at
                return
        ending: Ending | None = "error" if isinstance(line, Broken) else line.ended
        if station.kind == "box" and ending is None:
            assert isinstance(line, Did)
            self._place = self._places.get(station, self._place)
            self.played.append(line)
            return
        if station.kind == "box" and ending is not None:
            if station.box:
                self.endings[station.box] = ending
            else:
                self.practised = ending
        # a station that is no longer on the way changes nothing
        self._place = self._places.get(station, self._place - 1) + 1
        self.played, self.box_began = [], line.at


def _of(line: Did | Broken) -> Station:
    if isinstance(line, Broken):
        return Station("box", box=line.box)
    item = "" if line.scene == "comprehension" else line.item
    return Station(line.scene, item, line.box or 0)  # type: ignore[arg-type] # as it was written
