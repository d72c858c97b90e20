"""Who takes part in a study, and what is left for others."""

from __future__ import annotations

import re
import secrets
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import takewhile
from typing import Literal

from lockprobe.people.assignment import Given, assigned, boxes_each, conditions_of
from lockprobe.people.diary import Broken, Did, Entry, Joined, Released, Slot
from lockprobe.people.journey import Journey, fingerprint, stations
from lockprobe.people.refusals import Refused
from lockprobe.people.session import Seat, Table
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.spec import PEOPLE, group_of

__all__ = ["Register"]

_HOUR = 3600.0

_PLATFORM_VALUE = re.compile(r"[A-Za-z0-9_.-]{1,64}")

_IDLE_SECONDS = 600.0
"""After so long without an act a trial is let go of; it is played again when somebody comes back."""

_LOOK_SECONDS = 60.0

_MOST_WITH_CAMERA = 32
"""So many trials are held where each holds a plant with a camera, of 60 to 70 MiB."""


class Register:
    """All seats of a study.

    Args:
        table: What all share.
        seats: Those who take part already.
    """

    def __init__(self, table: Table, seats: Iterable[Seat]) -> None:
        self._table = table
        self._seats = {seat.journey.identity: seat for seat in seats}
        self._given: Given | None = None
        """What was given out; None where it has to be counted anew."""
        self._persons = Counter(filter(None, (self._person(seat.journey.joined.platform) for seat in self)))
        self._released = sum(seat.journey.released for seat in self)
        self._open: dict[str, Seat] = {}
        """Those who have boxes left, in the order of their last acts."""
        for seat in sorted(self, key=lambda seat: seat.journey.at):
            self._watch(seat)
        marked = ((seat.journey.joined.token, seat) for seat in self._seats.values())
        self._by_mark = {mark: seat for mark, seat in marked if mark}  # whoever came from elsewhere has none
        self._looked = table.clock()
        self._most_waiting = _MOST_WITH_CAMERA if resolve_plant(table.study.plant).has_camera else sys.maxsize

    def __iter__(self) -> Iterator[Seat]:
        return iter(tuple(self._seats.values()))

    def called(self, identity: str) -> Seat | None:
        """The seat of a participant."""
        return self._seats.get(identity)

    def marked(self, mark: str) -> Seat | None:
        """The seat of whoever has a token."""
        return self._by_mark.get(mark)

    def with_platform_id(self, value: str) -> list[str]:
        """Participants whose URL held this value, in any of the parameters that are kept."""
        return [seat.journey.identity for seat in self if value in seat.journey.joined.platform.values()]

    def add(self, mark: str, platform: Mapping[str, str], slots: tuple[Slot, ...]) -> Seat:
        """A seat for somebody new, on disk.

        Args:
            mark: By what their token is known.
            platform: What the recruitment platform says of them.
            slots: What they play.

        Raises:
            BadFile: If it cannot be written; then there is none.
        """
        table = self._table
        while (identity := secrets.token_hex(4)) in self._seats:
            pass
        words = fingerprint(table.words)
        joined = Joined(
            identity=identity, token=mark, at=table.clock(), platform=dict(platform), slots=slots, words=words
        )
        seat = Seat(table, Journey(joined, stations(table.experiment, table.words, len(slots))))
        seat.write_first()
        self._seats[identity] = self._by_mark[mark] = seat
        if person := self._person(platform):
            self._persons[person] += 1
        if self._given is not None:
            self._given.give(slots)
        self._watch(seat)
        return seat

    def remove(self, seat: Seat) -> None:
        """Forget a seat."""
        if self._seats.pop(seat.journey.identity, None) is None:
            return
        self._by_mark.pop(seat.journey.joined.token, None)
        self._open.pop(seat.journey.identity, None)
        self._released -= seat.journey.released
        self._given = None
        if person := self._person(seat.journey.joined.platform):
            self._persons[person] -= 1

    def _watch(self, seat: Seat) -> None:
        """Be told of what is written of somebody from now on."""
        seat.on_line = self._written
        if not (seat.journey.released or seat.journey.boxes_done):
            self._open[seat.journey.identity] = seat

    def _written(self, seat: Seat, line: Entry) -> None:
        """A line of somebody's diary is on disk."""
        here = self._open.pop(seat.journey.identity, None)
        if here is not None and not (seat.journey.released or seat.journey.boxes_done):
            self._open[seat.journey.identity] = seat  # last
        self._released += isinstance(line, Released)
        if isinstance(line, Released | Broken) or (isinstance(line, Did) and line.ended == "error"):
            self._given = None  # trials are free again

    def finished(self) -> set[Slot]:
        """Trials of people that are on record, whoever played them."""
        return {
            Slot(p=trial.dose, modality=trial.modality, repetition=trial.repetition, trial=trial.trial)
            for trial in self._table.journal.trials.values()
            if group_of(trial.agent) == PEOPLE and not trial.owed_again
        }

    def assigned(self) -> tuple[Slot, ...]:
        """What somebody would play who joined now; empty if nothing is left."""
        return assigned(self._table.study, self._table.experiment, self._all_given())

    def why_not(self, platform: Mapping[str, str]) -> Literal["taken", "full"] | None:
        """Why somebody cannot join; None if they can, perhaps with trials of somebody who was away too long."""
        if (person := self._person(platform)) and self._persons[person]:
            return "taken"
        late = len(self._late())
        limit = self._table.experiment.participants
        if limit is not None and self._taking_part() - late >= limit:
            return "full"
        return None if late or self._is_anything_left() else "full"

    def kept(self, platform: Mapping[str, str]) -> dict[str, str]:
        """What the experimenter asked for of what the recruitment platform says.

        Raises:
            Refused: As ``incomplete``.
        """
        found = {name: platform[name] for name in self._table.experiment.recruitment if name in platform}
        for name, value in found.items():
            if not _PLATFORM_VALUE.fullmatch(value):
                raise Refused("incomplete", f"{name} in the URL is nothing that a recruitment platform sends")
        return found

    def check_id(self, platform: Mapping[str, str]) -> None:
        """Refuse somebody new without an ID of the recruitment platform, where the experimenter wants one.

        Raises:
            Refused: As ``incomplete``.
        """
        if self._table.experiment.require_id and not self._person(platform):
            raise Refused("incomplete", f"{self._table.experiment.recruitment[0]} is missing in the URL")

    def check_code(self, given: str) -> None:
        """Refuse somebody new without the code that the experimenter gave out.

        Raises:
            Refused: As ``wrong-code``.
        """
        if not self.is_code(given):
            raise Refused("wrong-code", "not the code of this study")

    def is_code(self, given: str) -> bool:
        """Whether somebody can join who gives this code; where there is none everybody can."""
        return not self._table.experiment.join_code or secrets.compare_digest(
            given.strip().encode(), self._table.experiment.join_code.encode()
        )

    async def make_room(self) -> None:
        """Release trials of those who were away too long, longest first, as far as somebody new needs them.

        Raises:
            BadFile: If it cannot be written.
        """
        for seat in self._late():
            if seat.lock.locked():
                continue
            async with seat.lock:
                if self._is_enough_left():
                    return
                if self.is_late(seat):  # still, and not deleted while another was released
                    await seat.release()

    def is_late(self, seat: Seat) -> bool:
        """Whether somebody was away for so long that trials that they have not finished can be given to others."""
        journey = seat.journey
        away = self._table.clock() - journey.at
        open_ones = not (seat.gone or journey.released or journey.boxes_done)
        return open_ones and away > self._table.experiment.away_hours * _HOUR

    def is_another(self, seat: Seat, platform: Mapping[str, str]) -> bool:
        """Whether the recruitment platform says that it is another person who sits at the same browser now."""
        person = self._person(platform)
        return person is not None and self._person(seat.journey.joined.platform) not in (None, person)

    async def let_go_of_idle(self, comes: Seat | None) -> None:
        """Let go of trials that wait for nobody, and of those that wait longest where too many do.

        Args:
            comes: Whose trial is needed next; None where somebody new comes.
        """
        now = self._table.clock()
        if now - self._looked < _LOOK_SECONDS and len(self._seats) < self._most_waiting:
            return
        waiting = sorted((seat for seat in self if seat.holds and seat is not comes), key=lambda seat: seat.used)
        surplus = max(0, len(waiting) - self._most_waiting + 1)
        if now - self._looked >= _LOOK_SECONDS:
            self._looked = now
            surplus = max(surplus, sum(now - seat.used > _IDLE_SECONDS for seat in waiting))
        for seat in waiting[:surplus]:
            if not seat.lock.locked():
                async with seat.lock:
                    await seat.let_go()

    def _person(self, platform: Mapping[str, str]) -> str | None:
        """Who somebody is on the recruitment platform."""
        names = self._table.experiment.recruitment
        return platform.get(names[0]) if names else None

    def _is_enough_left(self) -> bool:
        """Whether somebody new can have as many boxes as everybody without anybody being sent away."""
        limit = self._table.experiment.participants
        if limit is not None and self._taking_part() >= limit:
            return False
        return len(self.assigned()) >= boxes_each(self._table.study, self._table.experiment)

    def _is_anything_left(self) -> bool:
        """Whether there is a trial that nobody has."""
        study = self._table.study
        return len(self._all_given().taken) < len(conditions_of(study)) * study.repetitions * study.trials

    def _all_given(self) -> Given:
        """What was given out, counted once and then kept."""
        if self._given is None:
            self._given = Given()
            for seat in self:
                self._given.give(seat.journey.joined.slots, seat.journey.slots_kept)
            self._given.take(self.finished())
        return self._given

    def _late(self) -> list[Seat]:
        """Those who were away too long, longest first."""
        latest = self._table.clock() - self._table.experiment.away_hours * _HOUR
        away = takewhile(lambda seat: seat.journey.at < latest, self._open.values())
        return [seat for seat in away if self.is_late(seat)]

    def _taking_part(self) -> int:
        return len(self._seats) - self._released
