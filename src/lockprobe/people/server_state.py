"""The participants' server without HTTP: load the page, agree, act, resume, withdraw.

Everything runs in one event loop. A token identifies a participant, a lease the page that may act, and a turn the
scene that an act answers. So no act counts twice, no act is lost after its outcome was shown, and two pages cannot
play one box. Nothing is stored before a participant agrees; the record of consent is the first entry of the diary,
``Joined``: the time and the texts. No network address is stored.
"""

from __future__ import annotations

import asyncio
import re
import secrets
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import Joined
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, fingerprint, stations
from lockprobe.people.open_study import OpenStudy, open_study
from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Act, Agree
from lockprobe.people.roster import Roster
from lockprobe.people.scenes import Closed, Scene
from lockprobe.people.session import Session
from lockprobe.people.texts import Words
from lockprobe.people.tokens import TOKENS, Tokens
from lockprobe.people.withdrawal import has_withdrawn, withdraw
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.study import Study

CODE, PREVIEW = "code", "preview"
"""The parameters of the URL that may hold the code to join, and the key of a preview."""

_LEASE = re.compile(r"[A-Za-z0-9_-]{1,64}")

_PLATFORM_VALUE = re.compile(r"[A-Za-z0-9_.-]{1,64}")


@dataclass(frozen=True, slots=True, kw_only=True)
class PageReply:
    """The answer to a page.

    Attributes:
        token: Identifies the participant; the browser keeps it where scripts cannot read it.
        lease: The page sends it with every act.
        turn: The number of the scene, from 1.
        identity: The participant, who has data to delete; None for who does not take part, or not yet.
        progress: How far the participant is: the ``share`` of the study that is behind them, [0, 1], and boxes ``done``
            ``of`` theirs; None for people who do not take part, or no longer.
    """

    token: str
    lease: str
    turn: int
    scene: Scene
    identity: str | None
    progress: Mapping[str, float] | None = None


class ServerState:
    """All participants of a study. Use :meth:`open`."""

    def __init__(self, opened: OpenStudy, tokens: Tokens, roster: Roster) -> None:
        self._opened = opened
        self._tokens = tokens
        self._roster = roster
        self._joining = asyncio.Lock()

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
    ) -> AsyncIterator[ServerState]:
        """Open a new study for people, or continue one.

        Args:
            directory: The directory of the study, created if missing. Models may have played there before.
            study: The study; its agents do not matter.
            experiment: How people take part.
            words: The texts that they read.
            clock: Seconds since 1970.
            page: Version of the page, for the record.

        Raises:
            SettingsChanged: If the directory holds another study, or people joined under other settings.
            DirectoryBusy: If another process is writing there.
            BadFile: If a file in it is damaged, or a replayed trial differs from what was shown.
            UserMistake: If the plant is not available.
        """
        async with open_study(directory, study, experiment, words, clock=clock, page=page) as opened:
            roster = await Roster.read(opened)
            given = any(session.journey.joined.token for session in roster)
            tokens = Tokens(directory / PEOPLE_DIRECTORY / TOKENS, given=given)
            try:
                yield cls(opened, tokens, roster)
            finally:
                await roster.let_go()

    @property
    def preview(self) -> str:
        """What the address of a preview ends with."""
        return f"?{PREVIEW}={self._tokens.preview}"

    def check(self) -> None:
        """Check that no other process has changed the records.

        Raises:
            BadFile: If one has.
        """
        self._opened.journal.store.check()

    def invite(self) -> None:
        """People can come from now on. If the start fails later, its files stay."""
        self._opened.invited.set()

    async def enter(self, token: str | None, platform: Mapping[str, str]) -> PageReply:
        """Answer a page that was just loaded. The participant resumes here; older pages can act no longer.

        Args:
            token: The browser's token; None if it has none.
            platform: The parameters of the URL.

        Raises:
            ActRefused: As ``forged``, or as ``incomplete`` if a required parameter is missing or not filled in.
            BadFile: If something cannot be written or read.
        """
        preview, kept, code = self._come_from(platform)
        lease = secrets.token_hex(16)
        session = None if token is None else self._roster.marked(self._tokens.mark(token))
        await self._roster.let_go_of_idle(session)
        if token is None or (session is not None and self._is_another(session, kept, preview=preview)):
            token, session = self._tokens.new(), None
        if session is not None:
            async with session.lock:
                session.lease = lease
                if not session.gone:
                    return await self._reply(token, lease, session)
        if not preview:
            self._check_admitted(kept)
            if closed := self._closed_to(kept):
                return _outside(token, lease, closed)
        boxes = boxes_each(self._opened.study, self._opened.experiment)
        ask_code = not (preview or self._is_code(code))
        return _outside(token, lease, self._opened.texts.consent(boxes, ask_code=ask_code))

    async def act(self, token: str | None, lease: str, turn: int, act: Act, platform: Mapping[str, str]) -> PageReply:
        """Do an act and return the next scene. The act is on disk before this returns.

        Args:
            token: The browser's token; None if it has none.
            lease: The lease that the page got when it was loaded.
            turn: The number of the scene that the act answers.
            act: The act.
            platform: The parameters of the URL.

        Raises:
            ActRefused: As ``forged``; ``elsewhere`` if a newer page was loaded; ``stale`` if another scene is shown;
                ``impossible`` if this scene does not allow the act; ``malformed``; ``incomplete``; ``wrong-code``.
                Nothing is then written, except that a box broke.
            BadFile: If something cannot be written or read; the act then has no effect.
        """
        token, mark = self._proof(token, lease)
        session = self._roster.marked(mark)
        await self._roster.let_go_of_idle(session)
        if session is None:
            if turn != 1:
                raise ActRefused("stale", "not the scene that is shown")
            if not isinstance(act, Agree):
                raise ActRefused("impossible", "nothing that can be done before somebody agrees to take part")
            joined = await self._joined(mark, act, platform)
            if isinstance(joined, Closed):
                return _outside(token, lease, joined)
            session = joined
            session.lease = session.lease or lease
        if isinstance(act, Agree):
            act = Agree(agreed=act.agreed)  # the code is kept nowhere
        async with session.lock:
            self._check_lease(session, lease)
            again = turn == session.journey.turn - 1 and act == session.journey.last  # its reply was lost
            if session.gone or not (again or turn == session.journey.turn):
                raise ActRefused("stale", "not the scene that is shown")
            if not (again or session.journey.shut == "late"):  # a late one learns that the place was given away
                await session.do(act)
            session.lease = lease
            return await self._reply(token, lease, session)

    async def withdraw(self, token: str | None, lease: str) -> PageReply:
        """Delete all data of the participant, at the participant's request.

        Raises:
            ActRefused: As ``forged``, ``elsewhere`` or ``malformed``.
            BadFile: If it cannot be written; the next opening of the study then finishes the deletion.
        """
        token, mark = self._proof(token, lease)
        async with self._joining:  # they may be about to join
            session = self._roster.marked(mark)
        if session is not None:
            async with session.lock:
                self._check_lease(session, lease)
                await session.let_go()
                joined = session.journey.joined
                if not session.preview and self._roster.called(joined.identity) is session:
                    person = self._roster.person(joined.platform)
                    withdraw(self._opened.journal, joined.identity, self._tokens.digest(person) if person else "")
                session.gone = True
                self._roster.remove(session)
        self._opened.journal.erase()  # also what failed before
        return _outside(token, lease, self._opened.texts.closed("withdrawn"))

    async def _joined(self, mark: str, act: Agree, came: Mapping[str, str]) -> Session | Closed:
        """Record consent and assign trials; or the scene of a person who does not take part, or cannot.

        Raises:
            ActRefused: Without a required ID or the code to join.
            BadFile: If it cannot be written; the participant has then not joined.
        """
        opened, roster = self._opened, self._roster
        if not act.agreed:
            return opened.texts.closed("declined")
        preview, platform, code = self._come_from(came)
        if not preview:
            self._check_admitted(platform, act.code or code)
        async with self._joining:
            if (known := roster.marked(mark)) is not None:  # the same act was sent twice
                return known
            for makes_room in () if preview else (False, True):
                if makes_room:
                    await roster.make_room()
                if (closed := self._closed_to(platform)) is not None:
                    return closed
            if not (slots := roster.assigned()):
                return opened.texts.closed("full")
            while roster.called(identity := secrets.token_hex(4)) is not None:
                pass
            words, way = fingerprint(opened.words), stations(opened.experiment, opened.words, len(slots))
            joined = Joined(
                identity=identity, token=mark, at=opened.clock(), platform=dict(platform), slots=slots, words=words
            )
            session = Session(opened, Journey(joined, way), preview=preview)
            if not preview:
                session.write_first()
            roster.add(session)
            return session

    def _come_from(self, platform: Mapping[str, str]) -> tuple[bool, dict[str, str], str]:
        """What the parameters of a URL say: whether it is a preview, those that are kept, and the code to join.

        Raises:
            ActRefused: As ``incomplete``, if the recruitment platform did not fill one in.
        """
        if secrets.compare_digest(platform.get(PREVIEW, "").encode(), self._tokens.preview.encode()):
            return True, {}, ""
        kept = {name: platform[name] for name in self._opened.experiment.recruitment if name in platform}
        for name, value in kept.items():
            if not _PLATFORM_VALUE.fullmatch(value):
                raise ActRefused("incomplete", f"{name} in the URL is not a value of a recruitment platform")
        return False, kept, platform.get(CODE, "")

    def _check_admitted(self, platform: Mapping[str, str], code: str | None = None) -> None:
        """Require an ID of the recruitment platform and, of who joins, the code, where the experimenter does."""
        if self._opened.experiment.require_id and not self._roster.person(platform):
            raise ActRefused("incomplete", f"{self._opened.experiment.recruitment[0]} is missing in the URL")
        if code is not None and not self._is_code(code):
            raise ActRefused("wrong-code", "not the code of this study")

    def _is_another(self, session: Session, platform: Mapping[str, str], *, preview: bool) -> bool:
        """Whether another person now uses the browser, as the recruitment platform says or the kind of visit."""
        person = self._roster.person(platform)
        known = self._roster.person(session.journey.joined.platform)
        return session.preview != preview or (person is not None and known not in (None, person))

    def _closed_to(self, platform: Mapping[str, str]) -> Closed | None:
        """The scene of a person who cannot join; None if they can, perhaps with trials of a late participant."""
        if person := self._roster.person(platform):
            if (session := self._roster.of_person(person)) is not None:
                return self._opened.texts.elsewhere(session.journey)
            if has_withdrawn(self._opened.journal, self._tokens.digest(person)):
                return self._opened.texts.closed("withdrawn")
        return self._opened.texts.closed("full") if self._roster.is_full() else None

    def _is_code(self, given: str) -> bool:
        """Whether this code admits; without a code to join every code does."""
        code = self._opened.experiment.join_code
        return not code or secrets.compare_digest(given.strip().encode(), code.encode())

    async def _reply(self, token: str, lease: str, session: Session) -> PageReply:
        scene, journey = await session.show(), session.journey
        done, of = len(journey.closed_boxes), len(journey.joined.slots)
        return PageReply(
            token=token,
            lease=lease,
            turn=journey.turn,
            scene=scene,
            identity=journey.joined.identity,
            progress=None if journey.shut else {"share": round(journey.share, 3), "done": done, "of": of},
        )

    def _proof(self, token: str | None, lease: str) -> tuple[str, str]:
        """A token and its mark."""
        if token is None:
            raise ActRefused("forged", "no token")
        if not _LEASE.fullmatch(lease):
            raise ActRefused("malformed", "no such lease")
        return token, self._tokens.mark(token)

    def _check_lease(self, session: Session, lease: str) -> None:
        """Only the page that was loaded last may act. After a restart, the page that acts first may."""
        if session.lease is not None and not secrets.compare_digest(session.lease, lease):
            raise ActRefused("elsewhere", "open in another page")


def _outside(token: str, lease: str, scene: Scene) -> PageReply:
    """The reply to a person who does not take part."""
    return PageReply(token=token, lease=lease, turn=1, scene=scene, identity=None)
