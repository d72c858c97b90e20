"""The roster: all participants of a study, and the trials that are left for others."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import takewhile

from lockprobe.foundation.spec import PEOPLE, group_of
from lockprobe.people.assignment import Given, assigned, boxes_each, conditions_of
from lockprobe.people.diary import Broken, Did, Entry, Released, Slot, bad_diary, read_diaries
from lockprobe.people.open_study import OpenStudy
from lockprobe.people.session import Session
from lockprobe.plants.catalogue import resolve_plant

_IDLE_SECONDS = 600.0
"""Seconds without an act after which a trial is dropped from memory; it is replayed when its participant returns."""

_LOOK_SECONDS = 60.0
"""Seconds between searches for idle trials."""

_MOST_WITH_CAMERA = 32
"""The most trials in memory where each holds a plant with a camera, of 60 to 70 MiB."""


class Roster:
    """All sessions of a study. Use :meth:`read`."""

    def __init__(self, opened: OpenStudy, sessions: Iterable[Session]) -> None:
        self._opened = opened
        self._sessions = {session.journey.joined.identity: session for session in sessions}
        self._given: Given | None = None
        """The trials given out; None where they have to be counted again."""
        self._persons = Counter(filter(None, (self.person(one.journey.joined.platform) for one in self)))
        self._released = sum(bool(session.journey.shut) for session in self)
        self._unfinished: dict[str, Session] = {}
        """Participants who have boxes left, in the order of their last acts."""
        for session in sorted(self, key=lambda session: session.journey.at):
            self._watch(session)
        marked = ((session.journey.joined.token, session) for session in self._sessions.values())
        self._by_mark = {mark: session for mark, session in marked if mark}  # imported participants have no token
        self._previews: dict[str, Session] = {}
        self._looked = opened.clock()
        self._most_waiting = (
            _MOST_WITH_CAMERA if any(resolve_plant(one).has_camera for one in opened.study.plants) else sys.maxsize
        )

    @classmethod
    async def read(cls, opened: OpenStudy) -> Roster:
        """Everybody who has joined so far.

        Raises:
            BadFile: If a diary is damaged or copied, or disagrees with the record; see :meth:`Session.restore`.
        """
        sessions, whose = [], dict[str, str]()
        for diary in read_diaries(opened.journal.directory):
            token, identity = diary.joined.token, diary.identity
            if token and whose.setdefault(token, identity) != identity:
                raise bad_diary(opened.journal.store.path, identity, f"a copy of the diary of {whose[token]}")
            sessions.append(await Session.restore(opened, diary))
        return cls(opened, sessions)

    def __iter__(self) -> Iterator[Session]:
        return iter(tuple(self._sessions.values()))

    def called(self, identity: str) -> Session | None:
        """The session of a participant."""
        return self._sessions.get(identity)

    def marked(self, mark: str) -> Session | None:
        """The session of the browser with a token."""
        return self._by_mark.get(mark)

    def person(self, platform: Mapping[str, str]) -> str | None:
        """A person's ID on the recruitment platform."""
        names = self._opened.experiment.recruitment
        return platform.get(names[0]) if names else None

    def of_person(self, person: str) -> Session | None:
        """The session of the person with a platform ID, one that has ended before others; None if none has joined."""
        if not self._persons[person]:
            return None
        theirs = (session for session in self if self.person(session.journey.joined.platform) == person)
        return max(theirs, key=lambda session: session.journey.finished or session.journey.shut)

    def add(self, session: Session) -> None:
        """Add a participant who has just joined. A preview takes no place."""
        joined = session.journey.joined
        if session.preview:
            self._previews[joined.token] = self._by_mark[joined.token] = session
            return
        self._sessions[joined.identity] = self._by_mark[joined.token] = session
        if person := self.person(joined.platform):
            self._persons[person] += 1
        if self._given is not None:
            self._given.give(joined.slots)
        self._watch(session)

    def remove(self, session: Session) -> None:
        """Remove a participant who has withdrawn."""
        joined = session.journey.joined
        if session.preview:
            self._previews.pop(joined.token, None)
            self._by_mark.pop(joined.token, None)
        if self._sessions.pop(joined.identity, None) is None:
            return
        self._by_mark.pop(joined.token, None)
        self._unfinished.pop(joined.identity, None)
        self._released -= bool(session.journey.shut)
        self._given = None
        if person := self.person(joined.platform):
            self._persons[person] -= 1

    def assigned(self) -> tuple[Slot, ...]:
        """The trials that the next participant gets; empty if none is left."""
        return assigned(self._opened.study, self._opened.experiment, self._all_given())

    def is_full(self) -> bool:
        """Whether no new participant can join, even if late ones make room."""
        late = len(self._late())
        limit = self._opened.experiment.participants
        if limit is not None and self._taking_part() - late >= limit:
            return True
        study = self._opened.study
        every_trial = len(conditions_of(study)) * study.repetitions * study.trials
        return not late and len(self._all_given().taken) >= every_trial

    async def make_room(self) -> None:
        """Release the trials of late participants, longest away first, as far as a new one needs them.

        Nothing else releases them: until then a late participant who comes back goes on.

        Raises:
            BadFile: If it cannot be written.
        """
        for session in self._late():
            if session.lock.locked():
                continue
            async with session.lock:
                if self._is_enough_left():
                    return
                if self._is_late(session):  # still, and not deleted while another was released
                    await session.release()

    async def let_go(self) -> None:
        """Drop all trials from memory."""
        for session in (*self, *self._previews.values()):
            await session.let_go()

    async def let_go_of_idle(self, comes: Session | None) -> None:
        """Drop idle trials from memory, and the longest waiting ones where there are too many.

        ``comes`` is the participant whose trial is needed next; None for a new one.
        """
        now = self._opened.clock()
        if now - self._looked < _LOOK_SECONDS and len(self._sessions) < self._most_waiting:
            return
        waiting = sorted(
            (one for one in (*self, *self._previews.values()) if one.holds and one is not comes),
            key=lambda one: one.used,
        )
        surplus = max(0, len(waiting) - self._most_waiting + 1)
        if now - self._looked >= _LOOK_SECONDS:
            self._looked = now
            surplus = max(surplus, sum(now - session.used > _IDLE_SECONDS for session in waiting))
        for session in waiting[:surplus]:
            if not session.lock.locked():
                async with session.lock:
                    await session.let_go()

    def _watch(self, session: Session) -> None:
        session.on_line = self._written
        if not (session.journey.shut or session.journey.boxes_done):
            self._unfinished[session.journey.joined.identity] = session

    def _written(self, session: Session, line: Entry) -> None:
        """Update the counts after a line was written to a diary."""
        known = self._unfinished.pop(session.journey.joined.identity, None)
        if known is not None and not (session.journey.shut or session.journey.boxes_done):
            self._unfinished[session.journey.joined.identity] = session  # last
        self._released += isinstance(line, Released)
        if isinstance(line, Released | Broken) or (isinstance(line, Did) and line.ended == "error"):
            self._given = None  # trials are free again

    def _is_late(self, session: Session) -> bool:
        """Whether a participant was away so long that others can get the unfinished trials."""
        journey = session.journey
        away = self._opened.clock() - max(journey.at, session.used)
        unfinished = not (session.gone or journey.shut or journey.boxes_done)
        return unfinished and away > self._opened.experiment.away_minutes * 60

    def _late(self) -> list[Session]:
        """Late participants, longest away first."""
        latest = self._opened.clock() - self._opened.experiment.away_minutes * 60
        away = takewhile(lambda session: session.journey.at < latest, self._unfinished.values())
        return [session for session in away if self._is_late(session)]

    def _is_enough_left(self) -> bool:
        """Whether a new participant can get a full set of boxes without further releases."""
        limit = self._opened.experiment.participants
        if limit is not None and self._taking_part() >= limit:
            return False
        return len(self.assigned()) >= boxes_each(self._opened.study, self._opened.experiment)

    def _all_given(self) -> Given:
        """What was given out; counted once and then kept up to date."""
        if self._given is None:
            self._given = Given()
            for session in self:
                self._given.give(session.journey.joined.slots, session.journey.slots_kept)
            recorded = self._opened.journal.trials.values()
            self._given.take(
                Slot(condition=trial.condition, repetition=trial.repetition, trial=trial.trial)
                for trial in recorded
                if group_of(trial.agent) == PEOPLE and not trial.owed_again
            )
        return self._given

    def _taking_part(self) -> int:
        return len(self._sessions) - self._released
