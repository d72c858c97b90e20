"""The participants' server without HTTP: load the page, agree, act, resume, withdraw, and who has which place.

Everything runs in one event loop. A token identifies a participant, and a turn the scene that an act answers. So no act
counts twice, none is lost after its outcome was shown, and of two pages one learns that the other was quicker. Nothing
is stored before a participant agrees; the record of consent is the first entry of the diary, ``Joined``: the time and
the texts. No network address is stored.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
import secrets
import sys
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from lockprobe.boxes.families import box as named_box
from lockprobe.foundation.errors import BadValue, SettingsChanged
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE, group_of, spec_name
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.assignment import assigned, boxes_each
from lockprobe.people.diary import Act, Agree, Diary, Joined, Slot, make_private, read_diaries, write_entry
from lockprobe.people.experiment import EXPERIMENT, TEXTS, Experiment, Words, kept_experiment, words_file
from lockprobe.people.scenes import ActRefused, Scene, Scenes
from lockprobe.people.session import OpenStudy, Session
from lockprobe.people.withdrawal import delete_unnamed_pictures, has_withdrawn, keyed_digest, withdraw, withdrawn
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.playable import PERSON, check_playable
from lockprobe.studies.running.trial_setup import plants_place
from lockprobe.studies.study import Study

CODE, PREVIEW = "code", "preview"
"""The parameters of the URL that hold the code to join, and the key of a preview."""

_MOST_WITH_CAMERA = 32
"""The most trials in memory where each holds a plant with a camera, of 60 to 70 MiB."""

_ENGLISH = frozenset({"nudge", "remark", "distract", "warn", "correction"})
"""Interventions whose words reach the page as they are."""

_MAY_CHANGE = {"participants", "away_minutes", "language", "require_id", "join_code"}
_MAY_CHANGE |= {"completion_url", "completion_code", "left_url", "left_code"}
"""Settings that change nothing of what a participant sees in a box. Texts count by content, not by language."""

_TOKEN, _PLATFORM_VALUE = re.compile(r"[0-9a-f]{64}"), re.compile(r"[A-Za-z0-9_.-]{1,64}")


class Reply(NamedTuple):
    """The answer to a page.

    Attributes:
        token: Identifies the participant; the browser keeps it where scripts cannot read it.
        turn: The number of the scene, from 1.
        participant: Their ID; None for who does not take part, or not yet.
        progress: :attr:`Session.progress`.
    """

    token: str
    scene: Scene
    turn: int = 1
    participant: str | None = None
    progress: Mapping[str, float] | None = None


class ServerState:
    """All participants of a study. Use :meth:`open`."""

    def __init__(self, opened: OpenStudy) -> None:
        self._opened, self._scenes = opened, opened.scenes
        self._study, self._experiment = opened.scenes.study, opened.scenes.experiment
        self._id = next(iter(self._experiment.recruitment), "")
        """The parameter of the URL that identifies a person; empty without one."""
        cameras = any(resolve_plant(one).has_camera for one in self._study.plants)
        self._most = _MOST_WITH_CAMERA if cameras else sys.maxsize
        self._joining = asyncio.Lock()
        self._sessions: dict[str, Session] = {}
        """Everybody who takes part, and previews, by the mark of their token."""
        self.preview = keyed_digest(opened.journal.directory, PREVIEW)[:16]
        """The key of a preview."""

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
        """Open a new study for people, or continue one, beside models that may have played there.

        The agents of ``study`` do not matter; ``page`` is the version of the page, for the record.

        Raises:
            SettingsChanged: If the directory holds another study, or people joined under other settings.
            UserMistake: If the plant is not available, there is no such practice box, nobody can play a condition, a
                file is damaged, or a replayed trial differs from what was shown.
        """
        there = read_study(directory) if (directory / SETTINGS).exists() else study
        study = replace(study, agents=tuple(dict.fromkeys((*there.agents, PEOPLE))), names=there.names)
        study = study.ordered_as(there)  # people play the conditions in an order that is drawn from this one
        _check(study, experiment, words)
        with Journal.open(directory, study) as journal, plants_place(study.simulated) as place:
            make_private(directory)
            diaries = read_diaries(directory)
            _settle(directory, experiment, words, diaries)
            scenes = Scenes(words, study, experiment)
            state = cls(OpenStudy(scenes=scenes, journal=journal, place=place, clock=clock, page=page))
            for diary in diaries:
                diary.check_slots(study, directory)
                state._sessions[diary.joined.token] = session = Session(state._opened, diary)
                await session.record_owed()
            try:
                yield state
            finally:
                for session in state._sessions.values():
                    await session.let_go()
            if withdrawn(directory):
                delete_unnamed_pictures(journal)

    async def enter(self, token: str | None, platform: Mapping[str, str]) -> Reply:
        """Answer a page that was just loaded under an URL with these parameters.

        The participant with this token resumes here.

        Raises:
            ActRefused: As ``incomplete``, if a required parameter is missing, wrong or not filled in.
        """
        preview = self._is_preview(platform)
        person = "" if preview else platform.get(self._id, "")
        session = self._sessions.get(_mark(token or ""))
        if session is not None:
            known = session.diary.joined.platform.get(self._id, "")
            another = session.preview != preview or bool(person and known and known != person)  # at the same browser
            async with session.lock:
                if not (another or session.gone):
                    return await self._reply(token or "", session)
        closed = None if preview else self._closed_to(self._admitted(platform))
        scene = closed or self._scenes.consent(boxes_each(self._study, self._experiment))
        return Reply(secrets.token_hex(32), scene)

    async def act(self, token: str | None, turn: int, act: Act, platform: Mapping[str, str]) -> Reply:
        """Do an act that answers scene number ``turn``. It is on disk before this returns the next scene.

        Raises:
            ActRefused: As ``malformed`` without a token; ``stale`` if another scene is shown; ``impossible`` if this
                scene does not allow the act; ``incomplete``. Nothing is then written, except that a box broke.
            BadFile: If it cannot be written; the act then has no effect.
        """
        token, mark = _proof(token)
        session = self._sessions.get(mark)
        if session is None:
            if turn != 1:
                raise ActRefused("stale", "not the scene that is shown")
            if not isinstance(act, Agree):
                raise ActRefused("impossible", "nothing that can be done before somebody agrees to take part")
            joined = await self._joined(mark, platform) if act.agreed else self._scenes.closed("declined")
            if not isinstance(joined, Session):
                return Reply(token, joined)
            session = joined
        async with session.lock:
            again = turn == session.diary.turn - 1 and act == session.diary.last.act  # its reply was lost
            if session.gone or not (again or turn == session.diary.turn):
                raise ActRefused("stale", "not the scene that is shown")
            if not again:
                await session.do(act)
            return await self._reply(token, session)

    async def withdraw(self, token: str | None) -> Reply:
        """Delete all data of the participant, at their request; what fails the next opening of the study finishes."""
        token, mark = _proof(token)
        async with self._joining:  # they may be about to join
            session = self._sessions.get(mark)
        if session is not None:
            async with session.lock:
                await session.let_go()
                joined = session.diary.joined
                if not (session.preview or session.gone):
                    withdraw(self._opened.journal, joined.identity, joined.platform.get(self._id, ""))
                session.gone = True
                self._sessions.pop(mark, None)
        self._opened.journal.erase()  # also what failed before
        return Reply(token, self._scenes.closed("withdrawn"))

    async def _joined(self, mark: str, platform: Mapping[str, str]) -> Session | Scene:
        """Record consent and assign trials; or the scene of a person who cannot take part."""
        preview = self._is_preview(platform)
        kept = {} if preview else self._admitted(platform)
        async with self._joining:
            if (known := self._sessions.get(mark)) is not None:  # the same act was sent twice
                return known
            if not preview:
                if closed := self._closed_to(kept):
                    return closed
                for late in self._late():
                    if len(self._free()) >= boxes_each(self._study, self._experiment):
                        break
                    async with late.lock:
                        if late in self._late():  # still, and not deleted while another was released
                            await late.release()
            if not (slots := self._free(preview=preview)):
                return self._scenes.closed("full")
            joined = Joined(
                identity=secrets.token_hex(4),  # one that is there already is refused when it is written
                token=mark,
                at=self._opened.clock(),
                platform=kept,
                slots=slots,
                words=self._scenes.words.fingerprint,
                page=self._opened.page,
            )
            if not preview:
                write_entry(self._opened.journal.store, joined.identity, 1, joined)
            self._sessions[mark] = session = Session(self._opened, Diary(joined, []), preview=preview)
            return session

    @property
    def _people(self) -> list[Session]:
        """Everybody who takes part."""
        return [session for session in self._sessions.values() if not session.preview]

    def _free(self, *, preview: bool = False) -> tuple[Slot, ...]:
        """The trials of a participant who joins now; none where no place is left. Every trial is given out once."""
        limit = self._experiment.participants
        if limit is not None and not preview and sum(not one.diary.late for one in self._people) >= limit:
            return ()
        given = [one.diary for one in self._people]
        on_record = [
            (trial.condition, trial.repetition, trial.trial)
            for trial in self._opened.journal.trials.values()
            if group_of(trial.agent) == PEOPLE and not trial.owed_again
        ]
        return assigned(self._study, self._experiment, given, on_record)

    def _late(self) -> list[Session]:
        """Who was away so long that others can get their unfinished trials, longest away first.

        As long as nobody needs the place, a late participant who comes back goes on.
        """
        latest = self._opened.clock() - self._experiment.away_minutes * 60
        late = [one for one in self._people if one.used < latest and not (one.gone or one.diary.late)]
        return sorted((one for one in late if not one.diary.boxes_done), key=lambda session: session.used)

    def _closed_to(self, platform: Mapping[str, str]) -> Scene | None:
        """The scene of a person who cannot join; None if they can, perhaps with trials of a late participant."""
        if person := platform.get(self._id, ""):
            theirs = [one for one in self._people if one.diary.joined.platform.get(self._id) == person]
            if any(one.diary.late for one in theirs):
                return self._scenes.closed("late")
            if theirs:
                return self._scenes.closed("finished" if theirs[0].station.kind == "debrief" else "taken")
            if has_withdrawn(self._opened.journal, person):
                return self._scenes.closed("withdrawn")
        return None if self._late() or self._free() else self._scenes.closed("full")

    def _is_preview(self, platform: Mapping[str, str]) -> bool:
        return secrets.compare_digest(platform.get(PREVIEW, "").encode(), self.preview.encode())

    def _admitted(self, platform: Mapping[str, str]) -> dict[str, str]:
        """The parameters of a URL that are kept, of who may join."""
        experiment = self._experiment
        kept = {name: platform[name] for name in experiment.recruitment if name in platform}
        for name, value in kept.items():
            if not _PLATFORM_VALUE.fullmatch(value):
                raise ActRefused("incomplete", f"{name} in the URL is not a value of a recruitment platform")
        if experiment.require_id and not kept.get(self._id):
            raise ActRefused("incomplete", f"{self._id} is missing in the URL")
        code = experiment.join_code
        if code and not secrets.compare_digest(platform.get(CODE, "").encode(), code.encode()):
            raise ActRefused("incomplete", f"{CODE} in the URL is not the code of this study")
        return kept

    async def _reply(self, token: str, session: Session) -> Reply:
        scene, diary = await session.show(), session.diary
        held = [one for one in self._sessions.values() if one.holds and not (one is session or one.lock.locked())]
        for other in sorted(held, key=lambda one: one.used)[: max(0, len(held) - self._most + 1)]:
            async with other.lock:
                await other.let_go()
        return Reply(token, scene, diary.turn, diary.identity, session.progress)


def _mark(token: str) -> str:
    """SHA-256 of a token, under which it is stored. The token cannot be derived from it."""
    return hashlib.sha256(token.encode()).hexdigest()


def _proof(token: str | None) -> tuple[str, str]:
    """A token that can have been given out, and its mark."""
    if token is None or not _TOKEN.fullmatch(token):
        raise ActRefused("malformed", "no token")
    return token, _mark(token)


def _check(study: Study, experiment: Experiment, words: Words) -> None:
    """Refuse what cannot be had before anything is written: a plant, a condition, settings of another study."""
    study.check_agents()
    check_playable(study.conditions, PERSON)
    boxes = boxes_each(study, experiment)
    after = max((check.after for check in experiment.checks), default=0)
    for setting, number in (("trials_each", experiment.trials_each or 1), ("checks, after", after)):
        if number > boxes:
            raise BadValue(setting, number, f"at most {boxes}, the boxes that are there for a participant")
    if words.language.partition("-")[0].lower() != "en":
        for spec in (spec for condition in study.conditions_of(PEOPLE) for spec in condition.specs):
            if spec_name(spec) in _ENGLISH:
                raise BadValue("texts", words.language, f"English ones with {spec}, whose words are English")
    practice = [named_box(experiment.practice)] if experiment.practice else []
    for plant in map(resolve_plant, dict.fromkeys((*study.plants, study.plant))):
        for box in (*study.boxes, *practice):
            plant.check(box)


def _settle(directory: Path, experiment: Experiment, words: Words, diaries: Sequence[Diary]) -> None:
    """Write settings and texts; refuse them if people have joined under other ones."""
    people = directory / PEOPLE_DIRECTORY
    asked, known = experiment.model_dump(mode="json"), kept_experiment(directory)
    read = {diary.joined.words for diary in diaries}
    different: dict[str, tuple[object, object]] = {}
    if read - {words.fingerprint}:
        different["texts"] = (", ".join(sorted(read)), words.fingerprint)
    if known is not None and diaries:
        there = known.model_dump(mode="json")
        changed = (name for name in asked if name not in _MAY_CHANGE and there[name] != asked[name])
        different |= {name: (there[name], asked[name]) for name in changed}
    if different:
        raise SettingsChanged(people, different)
    write_private(people / EXPERIMENT, f"{json.dumps(asked, indent=2)}\n")
    if not diaries and (texts := words_file(experiment.language)).is_file():
        write_private(people / TEXTS, read_input(texts))
