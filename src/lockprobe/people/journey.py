"""The scenes of one participant in order, and where in them somebody stands: a function of the diary alone.

Consent, instructions, practice, checks, then each box with what comes after it, questions, debrief.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Literal, NamedTuple

from lockprobe.people.diary import Broken, Did, Entry, Joined, Released, Slot
from lockprobe.people.experiment import Experiment
from lockprobe.people.paused_trial import Played
from lockprobe.people.responses import Act, Agree, Attempt
from lockprobe.people.texts import Words
from lockprobe.record import Ending

__all__ = ["Journey", "Station", "fingerprint", "stations"]


class Station(NamedTuple):
    """One place on the way.

    Attributes:
        kind: Of its scene.
        item: Which page or check, from 1; which question, by name.
        box: Which box, from 1; 0 is the practice box.
    """

    kind: Literal["page", "box", "over", "check", "ask", "debrief"]
    item: str = ""
    box: int = 0


def stations(experiment: Experiment, words: Words, boxes: int) -> tuple[Station, ...]:
    """The way of somebody who has agreed to take part and plays so many boxes."""

    def checks(after: int) -> Iterable[Station]:
        for number, check in enumerate(experiment.checks, 1):
            if check.after == after:
                yield Station("check", str(number))

    way = [Station("page", str(number)) for number in range(1, len(words.instructions) + 1)]
    if experiment.practice:
        way += [Station("box"), Station("over")]
    way += checks(0)
    for box in range(1, boxes + 1):
        way += [Station("box", box=box), Station("over", box=box), *checks(box)]
    way += [Station("ask", question.name) for question in experiment.questions]
    return (*way, Station("debrief"))


def fingerprint(words: Words) -> str:
    """Language and fingerprint of texts, for example ``en 3f9a01bc22d1``."""
    known = words.model_dump_json(exclude_none=True)  # texts that came with later releases change none without them
    return f"{words.language} {hashlib.sha256(known.encode()).hexdigest()[:12]}"


class Journey:
    """How far one participant has come.

    Args:
        joined: The first line of the diary.
        way: As :func:`stations` has it.

    Attributes:
        joined: The first line of the diary.
        turn: The number of the scene that is shown, from 2.
        last: The last act, which may come again if its reply was lost; None where something broke after it.
        at: When the last line was written, seconds since 1970.
        endings: How each box ended that is over, by its number; the practice box is none of them.
        practised: How the practice ended; None before.
        released: Whether the trials that were not finished are others' now.
        checks: For each check that was answered whether that was right.
        pages: By its number, the version of the page on which each box was begun, as far as that was written down.
    """

    def __init__(self, joined: Joined, way: Sequence[Station]) -> None:
        self.joined = joined
        self.turn = 2
        self.last: Act | None = Agree(agreed=True)
        self.at = joined.at
        self.endings: dict[int, Ending] = {}
        self.practised: Ending | None = None
        self.released = False
        self.checks: list[bool] = []
        self.pages: dict[int, str] = {}
        self._way = way
        self._places = {station: place for place, station in enumerate(way)}
        self._place = 0
        self._played: list[Played] = []
        self._shown = joined.at

    @classmethod
    def of(cls, diary: Sequence[Entry], experiment: Experiment, words: Words) -> Journey:
        """Where somebody stands after a diary."""
        joined = diary[0]
        assert isinstance(joined, Joined)
        journey = cls(joined, stations(experiment, words, len(joined.slots)))
        for line in diary[1:]:
            journey.follow(line)
        return journey

    @property
    def identity(self) -> str:
        """Whose it is."""
        return self.joined.identity

    @property
    def station(self) -> Station:
        """Where they stand."""
        return self._way[self._place]

    @property
    def played(self) -> tuple[Played, ...]:
        """The steps so far of the box in which they stand."""
        return tuple(self._played)

    @property
    def box_began(self) -> float:
        """When the box in which they stand was first shown, seconds since 1970."""
        return self._shown

    @property
    def boxes_done(self) -> bool:
        """Whether all boxes are over."""
        return len(self.endings) == len(self.joined.slots)

    @property
    def finished(self) -> bool:
        """Whether they have come to the end."""
        return self.station.kind == "debrief"

    @property
    def slots_kept(self) -> tuple[Slot, ...]:
        """The trials that nobody else can play: finished, or still theirs. One that broke is owed again."""
        return tuple(
            slot
            for box, slot in enumerate(self.joined.slots, 1)
            if (self.endings[box] != "error" if box in self.endings else not self.released)
        )

    def follow(self, line: Entry) -> None:
        """Go on as a line of the diary says."""
        assert not isinstance(line, Joined)
        if isinstance(line, Released):
            self.released = True
            return
        station = self._of(line)
        if isinstance(line, Did) and line.page:
            self.pages[station.box] = line.page
        self.turn, self.at = line.turn + 1, line.at
        self.last = line.act if isinstance(line, Did) else None
        if isinstance(line, Did) and line.right is not None:
            self.checks.append(line.right)
        ending: Ending | None = "error" if isinstance(line, Broken) else line.ended
        if station.kind == "box" and ending is None:
            assert isinstance(line, Did)
            assert isinstance(line.act, Attempt)
            self._place = self._places.get(station, self._place)
            self._played.append(Played(joint=line.act.joint, claimed=line.act.claimed, told=line.told))
            return
        if station.kind == "box" and ending is not None:
            if station.box:
                self.endings[station.box] = ending
            else:
                self.practised = ending
        self._go_on(station, line.at)

    def _go_on(self, station: Station, at: float) -> None:
        """To what comes after a station; one that is on the way no longer leaves them where they are."""
        self._place = self._places.get(station, self._place - 1) + 1
        self._played = []
        self._shown = at

    @staticmethod
    def _of(line: Did | Broken) -> Station:
        if isinstance(line, Broken):
            return Station("box", box=line.box)
        return Station(line.scene, line.item, line.box or 0)  # type: ignore[arg-type] # as it was written
