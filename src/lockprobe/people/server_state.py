"""The participants' server without HTTP: load the page, agree, act, resume, withdraw, and who has which place.

Everything runs in one event loop. A token identifies a participant, a lease the page that may act, and a turn the
scene that an act answers. So no act counts twice, no act is lost after its outcome was shown, and two pages cannot
play one box. Nothing is stored before a participant agrees; the record of consent is the first entry of the diary,
``Joined``: the time and the texts. No network address is stored.
"""

from __future__ import annotations

import asyncio
import json
import re
import secrets
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from lockprobe.foundation.errors import BadValue, SettingsChanged
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE, group_of, spec_name
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.people.assignment import Given, assigned, boxes_each, conditions_of
from lockprobe.people.box_view import Scene
from lockprobe.people.diary import Act, Agree, Diary, Joined, make_private, read_diaries
from lockprobe.people.experiment import EXPERIMENT, SECRET, Experiment, kept_experiment
from lockprobe.people.journey import Journey, stations
from lockprobe.people.practice import examples_of, practice_plan
from lockprobe.people.scenes import ActRefused, Scenes
from lockprobe.people.session import OpenStudy, Session
from lockprobe.people.texts import TEXTS, Words, words_file
from lockprobe.people.tokens import TOKENS, Tokens
from lockprobe.people.withdrawal import delete_unnamed_pictures, has_withdrawn, withdraw, withdrawn
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.file_names import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.records.directory import read_study, write_settings
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.playable import PERSON, check_playable
from lockprobe.studies.running.trial_setup import own_thread
from lockprobe.studies.study import Study
from lockprobe.trial.loop import here

CODE, PREVIEW = "code", "preview"
"""The parameters of the URL that may hold the code to join, and the key of a preview."""

_MOST_HELD, _MOST_WITH_CAMERA = 2048, 32
"""The most trials in memory; fewer where each holds a plant with a camera, of 60 to 70 MiB."""

_ENGLISH = frozenset({"nudge", "remark", "distract", "warn", "correction"})
"""Interventions whose words reach the page as they are."""

_MAY_CHANGE = {"participants", "away_minutes", "language", "require_id", *SECRET}
"""Settings that change nothing of what a participant sees in a box. Texts count by content, not by language."""

_LEASE, _PLATFORM_VALUE = re.compile(r"[A-Za-z0-9_-]{1,64}"), re.compile(r"[A-Za-z0-9_.-]{1,64}")


class Reply(NamedTuple):
    """The answer to a page.

    Attributes:
        token: Identifies the participant; the browser keeps it where scripts cannot read it.
        body: The scene; its ``turn``, from 1; the ``lease``, which the page sends with every act; the ``participant``,
            None for who does not take part, or not yet; whether there are data to ``withdraw``; and of participants
            the ``progress``: the share of the study that is behind them, [0, 1], and boxes done of theirs.
    """

    token: str
    body: Mapping[str, Any]


class ServerState:
    """All participants of a study. Use :meth:`open`."""

    def __init__(self, opened: OpenStudy, tokens: Tokens) -> None:
        self._opened, self._tokens = opened, tokens
        self._joining = asyncio.Lock()
        self._sessions: dict[str, Session] = {}
        """Everybody who takes part, by their identity."""
        self._marked: dict[str, Session] = {}
        """Those of this server, and previews, by the mark of their token."""
        cameras = any(resolve_plant(one).has_camera for one in opened.study.plants)
        self._most = _MOST_WITH_CAMERA if cameras else _MOST_HELD

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
        with (
            Journal.open(directory, replace(study, agents=there.agents)) as journal,
            own_thread() if study.simulated else nullcontext(here) as place,
        ):
            write_settings(directory, study)
            make_private(directory)
            diaries = read_diaries(directory)
            tokens = Tokens(directory / PEOPLE_DIRECTORY / TOKENS, given=any(one.joined.token for one in diaries))
            _settle(directory, experiment, words, diaries)
            scenes = Scenes(words, study, experiment, await examples_of(study, words.page, place))
            state = cls(
                OpenStudy(
                    study=study,
                    experiment=experiment,
                    words=words,
                    scenes=scenes,
                    journal=journal,
                    place=place,
                    clock=clock,
                    page=page,
                ),
                tokens,
            )
            for diary in diaries:
                state._add(await Session.restore(state._opened, diary))
            try:
                yield state
            finally:
                for session in (*state._sessions.values(), *state._marked.values()):
                    await session.let_go()
            if withdrawn(directory):
                delete_unnamed_pictures(journal)

    @property
    def preview(self) -> str:
        """What the address of a preview ends with."""
        return f"?{PREVIEW}={self._tokens.preview}"

    def check(self) -> None:
        """Raise BadFile if another process has changed the records."""
        self._opened.journal.store.check()

    def invite(self) -> None:
        """People can come from now on: if the server fails later, all of the study stays."""
        self._opened.journal.used = True

    async def enter(self, token: str | None, platform: Mapping[str, str]) -> Reply:
        """Answer a page that was just loaded under an URL with these parameters.

        The participant with this token resumes here; older pages can act no longer.

        Raises:
            ActRefused: As ``forged``, or as ``incomplete`` if a required parameter is missing or not filled in.
        """
        preview, kept, code = self._come_from(platform)
        lease = secrets.token_hex(16)
        session = None if token is None else self._marked.get(self._tokens.mark(token))
        await self._let_go_of_others(session)
        if session is not None and token is not None and not self._is_another(session, kept, preview=preview):
            async with session.lock:
                session.lease = lease
                if not session.gone:
                    return await self._reply(token, lease, session)
        if token is None or session is not None:
            token = self._tokens.new()
        if not preview:
            self._check_admitted(kept)
            if closed := self._closed_to(kept):
                return _reply(token, lease, 1, closed)
        boxes = boxes_each(self._opened.study, self._opened.experiment)
        ask_code = not (preview or self._is_code(code))
        return _reply(token, lease, 1, self._opened.scenes.consent(boxes, ask_code=ask_code))

    async def act(self, token: str | None, lease: str, turn: int, act: Act, platform: Mapping[str, str]) -> Reply:
        """Do an act that answers scene number ``turn``. It is on disk before this returns the next scene.

        Raises:
            ActRefused: As ``forged``; ``elsewhere`` if a newer page was loaded; ``stale`` if another scene is shown;
                ``impossible`` if this scene does not allow the act; ``malformed``; ``incomplete``; ``wrong-code``.
                Nothing is then written, except that a box broke.
            BadFile: If it cannot be written; the act then has no effect.
        """
        token, mark = self._proof(token, lease)
        session = self._marked.get(mark)
        await self._let_go_of_others(session)
        if session is None:
            if turn != 1:
                raise ActRefused("stale", "not the scene that is shown")
            if not isinstance(act, Agree):
                raise ActRefused("impossible", "nothing that can be done before somebody agrees to take part")
            joined = await self._joined(mark, act, platform)
            if not isinstance(joined, Session):
                return _reply(token, lease, 1, joined)
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

    async def withdraw(self, token: str | None, lease: str) -> Reply:
        """Delete all data of the participant, at their request; what fails the next opening of the study finishes."""
        token, mark = self._proof(token, lease)
        async with self._joining:  # they may be about to join
            session = self._marked.get(mark)
        if session is not None:
            async with session.lock:
                self._check_lease(session, lease)
                await session.let_go()
                joined = session.journey.joined
                if not (session.preview or session.gone):
                    person = self._person(joined.platform)
                    withdraw(self._opened.journal, joined.identity, self._tokens.digest(person) if person else "")
                session.gone = True
                self._sessions.pop(joined.identity, None)
                self._marked.pop(mark, None)
        self._opened.journal.erase()  # also what failed before
        return _reply(token, lease, 1, self._opened.scenes.closed("withdrawn"))

    async def _joined(self, mark: str, act: Agree, came: Mapping[str, str]) -> Session | Scene:
        """Record consent and assign trials; or the scene of a person who does not take part, or cannot."""
        opened = self._opened
        if not act.agreed:
            return opened.scenes.closed("declined")
        preview, platform, code = self._come_from(came)
        if not preview:
            self._check_admitted(platform, act.code or code)
        async with self._joining:
            if (known := self._marked.get(mark)) is not None:  # the same act was sent twice
                return known
            for makes_room in () if preview else (False, True):
                if makes_room:
                    await self._make_room()
                if (closed := self._closed_to(platform)) is not None:
                    return closed
            if not (slots := assigned(opened.study, opened.experiment, self._given())):
                return opened.scenes.closed("full")
            while (identity := secrets.token_hex(4)) in self._sessions:
                pass
            now, texts = opened.clock(), opened.words.fingerprint
            joined = Joined(identity=identity, token=mark, at=now, platform=platform, slots=slots, words=texts)
            journey = Journey(joined, stations(opened.experiment, opened.words, len(slots)))
            session = Session(opened, journey, preview=preview)
            if not preview:
                session.write_first()
            self._add(session)
            return session

    def _add(self, session: Session) -> None:
        """Add a participant, or a preview, which takes no place. Imported participants have no token."""
        joined = session.journey.joined
        if joined.token:
            self._marked[joined.token] = session
        if not session.preview:
            self._sessions[joined.identity] = session

    def _given(self) -> Given:
        """The trials that were given out to people who take part, or are on record."""
        given = Given()
        for session in self._sessions.values():
            given.give(session.journey.joined.slots, session.journey.slots_kept)
        given.take(
            (trial.condition, trial.repetition, trial.trial)
            for trial in self._opened.journal.trials.values()
            if group_of(trial.agent) == PEOPLE and not trial.owed_again
        )
        return given

    def _late(self) -> list[Session]:
        """Who was away so long that others can get their unfinished trials, longest away first.

        Nothing else releases them: as long as nobody needs the place, a late participant who comes back goes on.
        """
        latest = self._opened.clock() - self._opened.experiment.away_minutes * 60
        sessions = (one for one in self._sessions.values() if max(one.journey.at, one.used) < latest)
        late = (one for one in sessions if not (one.gone or one.journey.shut or one.journey.boxes_done))
        return sorted(late, key=lambda session: session.journey.at)

    async def _make_room(self) -> None:
        """Release the trials of late participants, longest away first, as far as a new one needs them."""
        study, experiment = self._opened.study, self._opened.experiment
        for session in self._late():
            if session.lock.locked():
                continue
            async with session.lock:
                whole = len(assigned(study, experiment, self._given())) >= boxes_each(study, experiment)
                if whole and self._has_places(self._taking_part()):
                    return
                if session in self._late():  # still, and not deleted while another was released
                    await session.release()

    def _taking_part(self) -> int:
        return sum(not session.journey.shut for session in self._sessions.values())

    def _has_places(self, people: int) -> bool:
        """Whether the experimenter wants more people than so many."""
        limit = self._opened.experiment.participants
        return limit is None or people < limit

    def _is_full(self) -> bool:
        """Whether no new participant can join, even if late ones make room."""
        study, late = self._opened.study, len(self._late())
        if not self._has_places(self._taking_part() - late):
            return True
        every = len(conditions_of(study)) * study.repetitions * study.trials
        return not late and len(self._given().taken) >= every

    def _closed_to(self, platform: Mapping[str, str]) -> Scene | None:
        """The scene of a person who cannot join; None if they can, perhaps with trials of a late participant."""
        if person := self._person(platform):
            journeys = [session.journey for session in self._sessions.values()]
            theirs = [one for one in journeys if self._person(one.joined.platform) == person]
            if theirs:
                return self._opened.scenes.elsewhere(max(theirs, key=lambda one: bool(one.finished or one.shut)))
            if has_withdrawn(self._opened.journal, self._tokens.digest(person)):
                return self._opened.scenes.closed("withdrawn")
        return self._opened.scenes.closed("full") if self._is_full() else None

    def _person(self, platform: Mapping[str, str]) -> str | None:
        """A person's ID on the recruitment platform."""
        names = self._opened.experiment.recruitment
        return platform.get(names[0]) if names else None

    def _come_from(self, platform: Mapping[str, str]) -> tuple[bool, dict[str, str], str]:
        """What the parameters of a URL say: whether it is a preview, those that are kept, and the code to join."""
        if secrets.compare_digest(platform.get(PREVIEW, "").encode(), self._tokens.preview.encode()):
            return True, {}, ""
        kept = {name: platform[name] for name in self._opened.experiment.recruitment if name in platform}
        for name, value in kept.items():
            if not _PLATFORM_VALUE.fullmatch(value):
                raise ActRefused("incomplete", f"{name} in the URL is not a value of a recruitment platform")
        return False, kept, platform.get(CODE, "")

    def _check_admitted(self, platform: Mapping[str, str], code: str | None = None) -> None:
        """Require an ID of the recruitment platform and, of who joins, the code, where the experimenter does."""
        if self._opened.experiment.require_id and not self._person(platform):
            raise ActRefused("incomplete", f"{self._opened.experiment.recruitment[0]} is missing in the URL")
        if code is not None and not self._is_code(code):
            raise ActRefused("wrong-code", "not the code of this study")

    def _is_code(self, given: str) -> bool:
        """Whether this code admits; without a code to join every code does."""
        code = self._opened.experiment.join_code
        return not code or secrets.compare_digest(given.strip().encode(), code.encode())

    def _is_another(self, session: Session, platform: Mapping[str, str], *, preview: bool) -> bool:
        """Whether another person now uses the browser, as the recruitment platform says or the kind of visit."""
        person, known = self._person(platform), self._person(session.journey.joined.platform)
        return session.preview != preview or (person is not None and known not in (None, person))

    async def _let_go_of_others(self, comes: Session | None) -> None:
        """Drop the longest waiting trials from memory, where too many are held beside that of who comes."""
        held = [one for one in self._marked.values() if one.holds and one is not comes]
        for session in sorted(held, key=lambda one: one.used)[: max(0, len(held) - self._most + 1)]:
            if not session.lock.locked():
                async with session.lock:
                    await session.let_go()

    async def _reply(self, token: str, lease: str, session: Session) -> Reply:
        scene, journey = await session.show(), session.journey
        done, of = len(journey.closed_boxes), len(journey.joined.slots)
        progress = None if journey.shut else {"share": round(journey.share, 3), "done": done, "of": of}
        return _reply(token, lease, journey.turn, scene, journey.joined.identity, progress)

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


def _reply(
    token: str,
    lease: str,
    turn: int,
    scene: Scene,
    participant: str | None = None,
    progress: Mapping[str, float] | None = None,
) -> Reply:
    said = {"lease": lease, "turn": turn, "scene": scene, "withdraw": participant is not None}
    return Reply(token, {**said, "participant": participant, "progress": progress})


def _check(study: Study, experiment: Experiment, words: Words) -> None:
    """Refuse what cannot be had before anything is written: a plant, a condition, settings of another study."""
    study.check_agents()
    check_playable(study.conditions, PERSON)
    luck, boxes = study.repetitions * study.trials, boxes_each(study, experiment)
    if (experiment.trials_each or 1) > luck:
        raise BadValue("trials_each", experiment.trials_each, f"at most {luck}, the trials of a condition")
    for check in experiment.checks:
        if check.after > boxes:
            raise BadValue("checks, after", check.after, f"at most {boxes}, the boxes of a participant")
    if words.language.partition("-")[0].lower() != "en":
        for spec in (spec for condition in study.conditions_of(PEOPLE) for spec in condition.specs):
            if spec_name(spec) in _ENGLISH:
                raise BadValue("texts", words.language, f"English ones with {spec}, whose words are English")
    practice = practice_plan(study, experiment)
    for plant in map(resolve_plant, dict.fromkeys((*study.plants, study.plant))):
        for box in (*study.boxes, *([practice.box] if practice else [])):
            plant.check(box)


def _settle(directory: Path, experiment: Experiment, words: Words, diaries: Sequence[Diary]) -> None:
    """Write settings and texts; refuse them if people have joined under other ones.

    Imported participants may have read other texts, since they do not resume here.
    """
    people = directory / PEOPLE_DIRECTORY
    asked, known = experiment.model_dump(mode="json"), kept_experiment(directory)
    read = {diary.joined.words for diary in diaries if diary.joined.token}
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
