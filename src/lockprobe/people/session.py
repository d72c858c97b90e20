"""The session of one participant: shows scenes, and writes each act to disk before the next."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.people.box_view import Scene, box_to_show, is_asked, read_of_step, view_of_modality
from lockprobe.people.diary import Act, Answers, Attempt, Broken, Diary, Did, Entry, Released, bad_diary, write_entry
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, stations
from lockprobe.people.practice import practice_plan
from lockprobe.people.scenes import ActRefused, Scenes
from lockprobe.people.texts import Words
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.studies.study import Study
from lockprobe.trial.loop import Executor
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Fact


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenStudy:
    """What all participants of a study share.

    Attributes:
        study: The study, with people among its agents.
        experiment: How people take part.
        words: The texts that participants read.
        scenes: The scenes made of these texts.
        journal: Records finished trials.
        place: Where plants run.
        clock: Seconds since 1970.
        page: Version of the page.
    """

    study: Study
    experiment: Experiment
    words: Words
    scenes: Scenes
    journal: Journal
    place: Executor
    clock: Callable[[], float]
    page: str


class Session:
    """The session of one participant.

    Attributes:
        journey: How far the participant has come.
        preview: Whether an experimenter looks at the study: nothing is written, and no place is taken.
        lock: Held while one request acts for the participant.
        lease: The lease of the page that may act; None before the first page asks.
        gone: Whether all data of the participant have been deleted.
        used: When the participant last asked for something, seconds since 1970.
    """

    def __init__(self, opened: OpenStudy, journey: Journey, *, lines: int = 0, preview: bool = False) -> None:
        self.journey = journey
        self.preview = preview
        self.lock = asyncio.Lock()
        self.lease: str | None = None
        self.gone = False
        self.used = journey.at
        self._opened = opened
        self._trial: PausedTrial | None = None
        self._lines = lines
        self._recorded = set[int]()

    @classmethod
    async def restore(cls, opened: OpenStudy, diary: Diary) -> Session:
        """A session for a participant who joined before. Replays and records finished, unrecorded trials."""
        diary.check_slots(opened.study, opened.journal.directory)
        way = stations(opened.experiment, opened.words, len(diary.joined.slots))
        session = cls(opened, Journey.of(diary, way), lines=1 + len(diary.lines))
        await session._record_owed()
        return session

    async def show(self) -> Scene:
        """The scene that the participant is in."""
        trial, opened, journey = await self._ready(), self._opened, self.journey
        if trial is None or trial.situation is None:
            return opened.scenes.closed(journey.shut) if journey.shut else opened.scenes.at(journey)
        number, of = journey.station.box, len(journey.joined.slots)
        return box_to_show(
            trial.plan, trial.situation, opened.words.page, experiment=opened.experiment, number=number, of=of
        )

    async def do(self, act: Act) -> None:
        """Do one act in the scene that is shown. It is on disk when this returns.

        Raises:
            ActRefused: If the scene does not allow the act; then nothing is written.
            BadFile: If it cannot be written; the act then has no effect.
        """
        journey, turn = self.journey, self.journey.turn
        trial, station = await self._ready(), journey.station
        if journey.turn != turn:  # the box broke in the meantime
            raise ActRefused("stale", "not the scene that is shown")
        if trial is not None:
            await self._attempt(trial, act)
            return
        right = self._opened.scenes.answered(journey, act)
        item = str(journey.rounds + 1) if isinstance(act, Answers) else station.item
        box = station.box if station.kind == "over" else None
        now = self._opened.clock()
        self._write(Did(at=now, turn=turn, scene=station.kind, act=act, box=box, item=item, right=right))

    def write_first(self) -> None:
        """Write the line ``joined``, the record of consent."""
        self._opened.journal.used = True
        self._keep(self.journey.joined)

    async def release(self) -> None:
        """Give the trials that are not finished to others."""
        self._write(Released(at=self._opened.clock()))
        await self.let_go()

    @property
    def holds(self) -> bool:
        """Whether a trial is paused in memory."""
        return self._trial is not None

    async def let_go(self) -> None:
        """Drop the paused trial from memory; it is replayed when it is needed."""
        trial, self._trial = self._trial, None
        if trial is not None:
            await trial.close()

    async def _ready(self) -> PausedTrial | None:
        """The trial that waits for a joint; None where the scene is no box. Boxes that nobody can play are skipped."""
        journey, opened = self.journey, self._opened
        self.used = opened.clock()
        await self._record_owed()
        most = opened.experiment.comprehension.rounds
        if most is not None and journey.misread is not None and journey.rounds >= most and not journey.shut:
            self._write(Released(at=opened.clock(), why="screened"))
        while (station := journey.station).kind == "box" and not journey.shut:
            elsewhere = bool(station.box) and not self._is_owed(station.box)  # played there, and imported
            trial = None if elsewhere else await self._begun(station.box)
            if trial is not None and trial.situation is not None:
                return trial
            began = journey.since
            self._write(Broken(at=opened.clock(), turn=journey.turn, box=station.box))
            await self.let_go()
            if trial is not None:
                self._append(station.box, trial, journey.at - began)
        return None

    async def _attempt(self, trial: PausedTrial, act: Act) -> None:
        situation, journey, opened = trial.situation, self.journey, self._opened
        assert situation is not None
        if not isinstance(act, Attempt) or act.joint not in situation.task.joints:
            raise ActRefused("impossible", "nothing that can be done in a box: it needs one of its joints")
        if not opened.experiment.device:
            act = act.model_copy(update={"pointer": None, "viewport": None})
        asked = is_asked(situation)
        if (act.claimed is not None) != asked or (act.claimed_rt is not None and not asked):
            raise ActRefused("impossible", "what the last action did is said where it is asked, and only there")
        box, step, now = journey.station.box, len(situation.past) + 1, opened.clock()
        async with AsyncExitStack() as undo:
            undo.push_async_callback(self.let_go)  # an act that is not written has not been done
            told = await trial.attempt(act.joint, act.claimed)
            self._write(
                Did(
                    at=now,
                    turn=journey.turn,
                    scene="box",
                    act=act,
                    box=box,
                    step=step,
                    told=told,
                    shown=read_of_step(trial.plan, trial.situation, opened.words.page) if trial.situation else "",
                    page=opened.page if box and step == 1 else "",
                    ended=None if trial.trial is None else trial.trial.ending,
                )
            )
            undo.pop_all()
        if trial.trial is not None:
            self._trial = None
            self._append(box, trial, journey.seconds(box))

    async def _begun(self, box: int) -> PausedTrial:
        """The trial in which the participant stands."""
        if self._trial is None:
            self._trial = await self._replayed(box)
            if self._trial.trial is not None and self._trial.sound:
                await self.let_go()
                raise self._bad(f"the replay of box {box} ends earlier than the play")
        return self._trial

    async def _replayed(self, box: int) -> PausedTrial:
        """The trial of a box after the steps that are on disk."""
        try:
            return await PausedTrial.begin(
                self._plan(box),
                self.journey.attempts(box),
                facts=self._facts(box),
                words_alone=True,
                pictures=self._opened.journal.directory / ALBUM if box and not self.preview else None,
                place=self._opened.place,
            )
        except BadValue as error:
            raise self._bad(str(error)) from None

    def _plan(self, box: int) -> Plan:
        opened, joined = self._opened, self.journey.joined
        if box:
            return joined.slots[box - 1].plan(opened.study, joined.identity)
        practice = practice_plan(opened.study, opened.experiment, joined.identity)
        assert practice is not None
        return practice

    def _facts(self, box: int) -> Mapping[str, Fact]:
        """The settings of the page, for the record of a box."""
        if not box:
            return {}
        experiment, begun = self._opened.experiment, self.journey.steps.get(box)
        return {
            "view": view_of_modality(self._plan(box).modality),
            "words": self.journey.joined.words,
            "page": (begun[0].page if begun else "") or self._opened.page,
            "position": box,
            "design": experiment.design,
            "history": experiment.history,
            "history_open": experiment.history_open,
            "feedback": experiment.feedback,
        }

    async def _record_owed(self) -> None:
        """Record the finished trials that are not on record, from the steps on disk, as after a kill or a full disk."""
        for box, ending in self.journey.endings.items():
            if not box or self.preview or box in self._recorded:
                continue
            if ending != "error" and self._is_owed(box):
                trial = await self._replayed(box)
                try:
                    if trial.trial is None or not trial.sound:
                        raise self._bad(f"the replay of box {box} ends differently from the play")
                    self._append(box, trial, self.journey.seconds(box))
                finally:
                    await trial.close()
            self._recorded.add(box)

    def _is_owed(self, box: int) -> bool:
        """Whether the record lacks the trial of a box; that of a preview is never looked for."""
        return self.preview or self._opened.journal.owes(self._plan(box).key)

    def _append(self, box: int, played: PausedTrial, seconds: float) -> None:
        """Record a finished trial, unless it is the practice, or the record holds it, whoever played it."""
        trial = played.trial
        assert trial is not None
        if box and not self.preview and self._opened.journal.owes(trial.key):
            timing = Timing(key=trial.key, seconds=max(0.0, seconds), steps=len(trial.steps))
            self._opened.journal.append(trial, timing)

    def _write(self, line: Entry) -> None:
        if not self.preview:
            self._keep(line)
        self.journey.follow(line)

    def _keep(self, line: Entry) -> None:
        write_entry(self._opened.journal.store, self.journey.joined.identity, self._lines + 1, line)
        self._lines += 1

    def _bad(self, why: str) -> BadFile:
        return bad_diary(self._opened.journal.store.path, self.journey.joined.identity, why)
