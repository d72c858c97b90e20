"""Participants' consent: asking for it, admission, and the diary line that records it.

The consent text is in ``texts/LANGUAGE.toml`` under ``[consent]``, or in the experimenter's copy. Nothing is stored
before a participant agrees. The record of consent is the first line of the diary, ``Joined``: the time and the texts.
"""

from __future__ import annotations

import asyncio
import re
import secrets
from collections.abc import Mapping

from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import Joined, Slot
from lockprobe.people.journey import Journey, fingerprint, stations
from lockprobe.people.open_study import OpenStudy
from lockprobe.people.refusals import ActRefused
from lockprobe.people.roster import Roster
from lockprobe.people.scenes import Closed, Consent
from lockprobe.people.session import Session
from lockprobe.people.tokens import Tokens
from lockprobe.people.withdrawal import has_withdrawn

CODE, PREVIEW = "code", "preview"
"""The parameters of the URL that may hold the code to join, and the key of a preview."""

_PLATFORM_VALUE = re.compile(r"[A-Za-z0-9_.-]{1,64}")


class Admission:
    """Asks people for consent and lets them join. ``lock`` is held while a participant joins."""

    def __init__(self, opened: OpenStudy, roster: Roster, tokens: Tokens) -> None:
        self.lock = asyncio.Lock()
        self._opened, self._roster, self._tokens = opened, roster, tokens

    def kept(self, platform: Mapping[str, str]) -> dict[str, str]:
        """The parameters of the URL that the experimenter keeps.

        Raises:
            ActRefused: As ``incomplete``, if the recruitment platform did not fill one in.
        """
        found = {name: platform[name] for name in self._opened.experiment.recruitment if name in platform}
        for name, value in found.items():
            if not _PLATFORM_VALUE.fullmatch(value):
                raise ActRefused("incomplete", f"{name} in the URL is not a value of a recruitment platform")
        return found

    def ask(self, platform: Mapping[str, str], code: str, *, preview: bool = False) -> Consent | Closed:
        """The first scene of a new visitor.

        Args:
            platform: The parameters that are kept.
            code: The code to join from the URL; empty for none.
            preview: Whether an experimenter looks at the study.

        Raises:
            ActRefused: As ``incomplete``, without a required ID of the recruitment platform.
        """
        if not preview:
            self.check_id(platform)
            if closed := self._closed_to(platform):
                return closed
        boxes = boxes_each(self._opened.study, self._opened.experiment)
        return self._opened.texts.consent(boxes, ask_code=not (preview or self._is_code(code)))

    def check_id(self, platform: Mapping[str, str]) -> None:
        """Require an ID of the recruitment platform, where the experimenter does.

        Raises:
            ActRefused: As ``incomplete``.
        """
        if self._opened.experiment.require_id and not self._roster.person(platform):
            raise ActRefused("incomplete", f"{self._opened.experiment.recruitment[0]} is missing in the URL")

    def check_code(self, given: str) -> None:
        """Require the code to join.

        Raises:
            ActRefused: As ``wrong-code``.
        """
        if not self._is_code(given):
            raise ActRefused("wrong-code", "not the code of this study")

    def is_another(self, session: Session, platform: Mapping[str, str]) -> bool:
        """Whether the recruitment platform reports that another person now uses the same browser."""
        person = self._roster.person(platform)
        return person is not None and self._roster.person(session.journey.joined.platform) not in (None, person)

    def is_preview(self, platform: Mapping[str, str]) -> bool:
        """Whether an experimenter looks at the study, with the key in the address that the server says."""
        return secrets.compare_digest(platform.get(PREVIEW, "").encode(), self._tokens.preview.encode())

    async def join(
        self, mark: str, lease: str, platform: Mapping[str, str], *, preview: bool = False
    ) -> Session | Closed:
        """Record consent and assign trials; or the scene of a person who cannot join.

        Args:
            mark: The mark of the browser's token.
            lease: The lease of its page.
            platform: The parameters that are kept.
            preview: Whether an experimenter looks at the study.

        Raises:
            BadFile: If it cannot be written; the participant has then not joined.
        """
        async with self.lock:
            if (known := self._roster.marked(mark)) is not None:  # the same act was sent twice
                return known
            if not preview:
                if (closed := self._closed_to(platform)) is not None:
                    return closed
                await self._roster.make_room()
                if (closed := self._closed_to(platform)) is not None:
                    return closed
            if not (slots := self._roster.assigned()):
                return self._opened.texts.closed("full")
            session = self._record(mark, platform, slots, preview=preview)
            session.lease = lease
            return session

    def _record(self, mark: str, platform: Mapping[str, str], slots: tuple[Slot, ...], *, preview: bool) -> Session:
        opened = self._opened
        while self._roster.called(identity := secrets.token_hex(4)) is not None:
            pass
        words = fingerprint(opened.words)
        joined = Joined(
            identity=identity, token=mark, at=opened.clock(), platform=dict(platform), slots=slots, words=words
        )
        way = stations(opened.experiment, opened.words, len(slots))
        session = Session(opened, Journey(joined, way), preview=preview)
        if not preview:
            session.write_first()
        self._roster.add(session)
        return session

    def _closed_to(self, platform: Mapping[str, str]) -> Closed | None:
        """The scene of a person who cannot join; None if they can, perhaps with trials of a late participant."""
        if (person := self._roster.person(platform)) and (session := self._roster.of_person(person)) is not None:
            return self._opened.texts.elsewhere(session.journey)
        if person and has_withdrawn(self._opened.journal, self._tokens.digest(person)):
            return self._opened.texts.closed("withdrawn")
        return self._opened.texts.closed("full") if self._roster.is_full() else None

    def _is_code(self, given: str) -> bool:
        """Whether this code admits; without a code to join every code does."""
        code = self._opened.experiment.join_code
        return not code or secrets.compare_digest(given.strip().encode(), code.encode())
