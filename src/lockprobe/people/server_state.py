"""Where participants come in, go on where they were, and leave: who may do what, and where each of them sits.

All in one event loop; there is no HTTP here. A token says who it is, a lease which page of theirs may act, a turn which
scene an act is for: so no act counts twice, none is lost once its outcome was shown, and two pages cannot play one box.
"""

from __future__ import annotations

import asyncio
import re
import secrets
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.people.directory import TOKENS
from lockprobe.people.example import examples_of
from lockprobe.people.experiment import Experiment
from lockprobe.people.open_study import opened, seats_on_disk
from lockprobe.people.progress import Progress, progress_of
from lockprobe.people.refusals import Refused
from lockprobe.people.responses import Act, Agree
from lockprobe.people.roster import Register
from lockprobe.people.scenes import Scene
from lockprobe.people.session import Seat, Table
from lockprobe.people.text_scenes import Texts
from lockprobe.people.texts import Words
from lockprobe.people.tokens import Tokens
from lockprobe.people.withdrawal import finish_withdrawal, note_withdrawal, withdrawing, withdrawn
from lockprobe.studies.study import Study

__all__ = ["CODE", "Reception", "Shown"]

CODE = "code"
"""The parameter of the URL that may hold the code with which somebody joins."""

_LEASE = re.compile(r"[A-Za-z0-9_-]{1,64}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """What a page is answered.

    Attributes:
        token: Who it is; kept by the browser where scripts cannot read it.
        lease: With which the page acts from now on.
        turn: The number of the scene, from 1.
        scene: What is shown.
        identity: Who takes part; None before somebody has agreed to.
        may_withdraw: Whether there is something to delete.
    """

    token: str
    lease: str
    turn: int
    scene: Scene
    identity: str | None
    may_withdraw: bool


class Reception:
    """Everybody who takes part in a study. Use :meth:`open`."""

    def __init__(self, table: Table, tokens: Tokens, register: Register) -> None:
        self._table = table
        self._tokens = tokens
        self._register = register
        self._door = asyncio.Lock()
        """Held while somebody joins."""

    @classmethod
    @asynccontextmanager
    async def open(
        cls,
        directory: Path,
        study: Study,
        experiment: Experiment,
        words: Words,
        *,
        clock: Callable[[], float] = time.time,
        page: str = "",
    ) -> AsyncIterator[Reception]:
        """Open a study for people, new or to go on.

        Args:
            directory: Of the study; made if it is not there. Where models have played in it, people join them.
            study: The study; who plays in it does not matter.
            experiment: How people take part.
            words: What they read.
            clock: Seconds since 1970.
            page: Version of the page on which they play, for the record.

        Raises:
            SettingsChanged: If the directory holds another study, or people have joined under other settings.
            DirectoryBusy: If another process is writing there.
            BadFile: If something in it is damaged, or a trial is not told again as it was shown.
            UserMistake: If the plant cannot be had.
        """
        with opened(directory, study, experiment, words, clock=clock, page=page) as there:
            examples = await examples_of(there.study, experiment, there.place)
            table = replace(there, texts=Texts(words, there.study, experiment, examples))
            seats = await seats_on_disk(table)
            given = any(seat.journey.joined.token for seat in seats)
            tokens = Tokens(directory / PEOPLE_DIRECTORY / TOKENS, given=given)
            reception = cls(table, tokens, Register(table, seats))
            try:
                yield reception
            finally:
                for seat in reception._register:
                    await seat.let_go()

    @property
    def study(self) -> Study:
        """The study, people among its agents."""
        return self._table.study

    @property
    def experiment(self) -> Experiment:
        """How people take part."""
        return self._table.experiment

    def check(self) -> None:
        """Refuse to go on where somebody else has changed the records or the clock readings.

        Raises:
            BadFile: If they have.
        """
        self._table.journal.check()

    def invite(self) -> None:
        """From now on people can come: whatever happens, what the start wrote stays."""
        self._table.people.used = True

    async def enter(self, token: str | None, platform: Mapping[str, str]) -> Shown:
        """Somebody loads the page: they go on where they were, and pages of theirs that are open can act no longer.

        Args:
            token: What the browser shows; None if it has none.
            platform: What the URL says, by parameter.

        Raises:
            Refused: As ``forged``, or as ``incomplete`` if a parameter that is kept is missing or nothing that is sent.
            BadFile: If something cannot be written or read.
        """
        code, platform, lease = platform.get(CODE, ""), self._register.kept(platform), secrets.token_hex(16)
        seat = None if token is None else self._register.marked(self._tokens.mark(token))
        await self._register.let_go_of_idle(seat)
        if token is None or (seat is not None and self._register.is_another(seat, platform)):
            token, seat = self._tokens.new(), None
        if seat is not None:
            async with seat.lock:
                seat.lease = lease
                if not seat.gone:
                    await self._release_if_late(seat)
                    return await self._shown(token, seat)
                if self._register.called(seat.journey.identity) is seat:  # noted, and not finished yet
                    return _outside(token, lease, self._table.texts.closed("withdrawn"))
        self._register.check_id(platform)
        texts, ask_code = self._table.texts, not self._register.is_code(code)
        why = self._register.why_not(platform)
        boxes = boxes_each(self.study, self._table.experiment)
        scene = texts.closed(why) if why else texts.consent(boxes, ask_code=ask_code)
        return _outside(token, lease, scene)

    async def act(self, token: str | None, lease: str, turn: int, act: Act, platform: Mapping[str, str]) -> Shown:
        """Somebody does something; what comes of it is on disk before this returns.

        Args:
            token: What the browser shows.
            lease: That the page got when it was loaded.
            turn: The number of the scene that the act is for.
            act: What is done.
            platform: What the URL says, by parameter.

        Raises:
            Refused: As ``forged``; ``elsewhere`` if a newer page was loaded; ``stale`` if another scene is shown;
                ``impossible`` if it cannot be done in this one; ``malformed``; ``incomplete``; ``wrong-code``. Then
                nothing is written, but that a box broke, or that somebody was away too long, if that came out with it.
            BadFile: If something cannot be written or read; then it has not been done.
        """
        token, mark = self._proof(token, lease)
        known = self._register.marked(mark)
        await self._register.let_go_of_idle(known)
        if isinstance(act, Agree):
            given, act = act.code or platform.get(CODE, ""), Agree(agreed=act.agreed)
            if known is None and act.agreed:
                self._register.check_id(self._register.kept(platform))
                self._register.check_code(given)
        seat = known or await self._join(mark, lease, turn, act, self._register.kept(platform))
        if not isinstance(seat, Seat):
            return _outside(token, lease, self._table.texts.closed(seat))
        async with seat.lock:
            self._check_lease(seat, lease)
            again = turn == seat.journey.turn - 1 and act == seat.journey.last  # its reply was lost
            if seat.gone or not (again or turn == seat.journey.turn):
                raise Refused("stale", "not the scene that is shown")
            if not again and not await self._release_if_late(seat):
                await seat.do(act)
            seat.lease = lease
            return await self._shown(token, seat)

    async def withdraw(self, token: str | None, lease: str) -> Shown:
        """Somebody withdraws: all that is kept of them is deleted.

        Raises:
            Refused: As ``forged``, ``elsewhere`` or ``malformed``.
            BadFile: If it cannot be written; then it is finished when the study is next opened.
        """
        token, mark = self._proof(token, lease)
        async with self._door:  # they may be about to join
            seat = self._register.marked(mark)
        if seat is not None:
            async with seat.lock:
                self._check_lease(seat, lease)
                await self._delete(seat)
        return _outside(token, lease, self._table.texts.closed("withdrawn"))

    async def withdraw_participant(self, identity: str) -> None:
        """Delete all that is kept of somebody, as the experimenter asks.

        Raises:
            Refused: As ``unknown``, if nobody here is called so.
            BadFile: If it cannot be written; then it is finished when the study is next opened.
        """
        if (seat := self._register.called(identity)) is None:
            raise Refused("unknown", "no such participant")
        async with seat.lock:
            await self._delete(seat)

    def with_platform_id(self, value: str) -> list[str]:
        """Who has an ID of the recruitment platform."""
        return self._register.with_platform_id(value)

    def progress(self) -> Progress:
        """How far people have come, by condition."""
        journeys, gone = [seat.journey for seat in self._register], withdrawn(self._table.journal.directory)
        return progress_of(self.study, journeys, self._register.finished(), gone)

    def withdrawals(self) -> tuple[int, str | None]:
        """How many have withdrawn, and whose deletion is under way: another with every withdrawal."""
        directory = self._table.journal.directory
        return withdrawn(directory), withdrawing(directory)

    async def _join(
        self, mark: str, lease: str, turn: int, act: Act, platform: Mapping[str, str]
    ) -> Seat | Literal["declined", "taken", "full"]:
        """Somebody agrees to take part, or not; nothing is kept before. Where they sit then, or why not."""
        if turn != 1:
            raise Refused("stale", "not the scene that is shown")
        if not isinstance(act, Agree):
            raise Refused("impossible", "nothing that can be done before somebody agrees to take part")
        if not act.agreed:
            return "declined"
        register = self._register
        async with self._door:
            if (seat := register.marked(mark)) is not None:  # in the meantime, by the same act sent twice
                return seat
            if (why := register.why_not(platform)) is not None:
                return why
            await register.make_room()
            if (why := register.why_not(platform)) is not None:
                return why
            if not (slots := register.assigned()):
                return "full"
            seat = register.add(mark, platform, slots)
            seat.lease = lease
            return seat

    async def _shown(self, token: str, seat: Seat) -> Shown:
        scene, journey = await seat.show(), seat.journey
        assert seat.lease is not None
        return Shown(
            token=token,
            lease=seat.lease,
            turn=journey.turn,
            scene=scene,
            identity=journey.identity,
            may_withdraw=True,
        )

    def _proof(self, token: str | None, lease: str) -> tuple[str, str]:
        """A token and by what it is known."""
        if token is None:
            raise Refused("forged", "no token")
        if not _LEASE.fullmatch(lease):
            raise Refused("malformed", "no such lease")
        return token, self._tokens.mark(token)

    def _check_lease(self, seat: Seat, lease: str) -> None:
        """Only the page that was loaded last may act; after a restart the one whose act is taken first goes on."""
        if seat.lease is not None and not secrets.compare_digest(seat.lease, lease):
            raise Refused("elsewhere", "open in another page")

    async def _release_if_late(self, seat: Seat) -> bool:
        if late := self._register.is_late(seat):
            await seat.release()
        return late

    async def _delete(self, seat: Seat) -> None:
        """Delete all that is kept of somebody, whose seat is locked. From the note on they cannot act."""
        await seat.let_go()
        self._finish()  # what was noted before and failed, perhaps this one
        if self._register.called(seat.journey.identity) is seat:
            note_withdrawal(self._table.journal, seat.journey.identity)
            seat.gone = True
            self._finish()

    def _finish(self) -> None:
        identity = finish_withdrawal(self._table.journal)
        if identity is not None and (seat := self._register.called(identity)) is not None:
            seat.gone = True
            self._register.remove(seat)


def _outside(token: str, lease: str, scene: Scene) -> Shown:
    """What somebody is shown who does not take part."""
    return Shown(token=token, lease=lease, turn=1, scene=scene, identity=None, may_withdraw=False)
