"""The session of one participant: shows scenes, and writes each act to disk before the next."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack
from typing import Any, NamedTuple

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.people.assignment import practice_plan
from lockprobe.people.diary import Act, Attempt, Diary, Did, bad_diary, write_entry
from lockprobe.people.scenes import ActRefused, Scene, Scenes, Station, is_asked, view_of
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import ALBUM
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.trial.loop import Executor
from lockprobe.trial.plan import Plan


class OpenStudy(NamedTuple):
    """What all participants of a study share: its scenes, the records, where plants run, and the version of the page.

    ``clock`` gives seconds since 1970.
    """

    scenes: Scenes
    journal: Journal
    place: Executor
    clock: Callable[[], float]
    page: str


class Session:
    """The session of one participant.

    Attributes:
        diary: How far the participant has come.
        preview: Whether an experimenter looks at the study: nothing is written, and no place is taken.
        lock: Held while one request acts for the participant.
        gone: Whether all data of the participant have been deleted.
        used: When the participant last asked for something, seconds since 1970.
    """

    def __init__(self, opened: OpenStudy, diary: Diary, *, preview: bool = False) -> None:
        self.diary = diary
        self.preview = preview
        self.lock = asyncio.Lock()
        self.gone = False
        self.used = diary.last.at
        self._opened = opened
        self._way = opened.scenes.way(len(diary.joined.slots))
        self._trial: PausedTrial | None = None

    @property
    def station(self) -> Station:
        """The scene that the participant is in, unless they cannot go on."""
        return self._way[min(self.diary.place, len(self._way) - 1)]

    @property
    def progress(self) -> dict[str, float] | None:
        """The share of the scenes that lie behind the participant, [0, 1], and boxes done of theirs; None once late."""
        share, done = self.diary.place / (len(self._way) - 1), len(self.diary.endings.keys() - {0})
        return None if self.diary.late else {"share": share, "done": done, "of": len(self.diary.joined.slots)}

    async def show(self) -> Scene:
        """The scene that the participant is in."""
        trial, scenes, diary = await self._ready(), self._opened.scenes, self.diary
        if trial is None or trial.situation is None:
            return scenes.closed("late") if diary.late else scenes.at(self.station, diary)
        return scenes.box(trial.plan, trial.situation, self.station.box, len(diary.joined.slots))

    async def do(self, act: Act) -> None:
        """Do one act in the scene that is shown. It is on disk when this returns.

        Raises:
            ActRefused: If the scene does not allow the act; then nothing is written.
            BadFile: If it cannot be written; the act then has no effect.
        """
        diary = self.diary
        turn, trial = diary.turn, await self._ready()
        if diary.turn != turn:  # the box broke in the meantime
            raise ActRefused("stale", "not the scene that is shown")
        if trial is not None:
            await self._attempt(trial, act)
            return
        if diary.late:
            raise ActRefused("impossible", "nothing can be done any more")
        station = self.station
        item = str(len(diary.rounds) + 1) if station.kind == "comprehension" else station.item
        box = station.box if station.kind == "over" else None
        right = self._opened.scenes.right(station, act)
        self._write(scene=station.kind, act=act, box=box, item=item, right=right)

    async def release(self) -> None:
        """Give the trials that are not finished to others."""
        self._write(scene="late", act=None)
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

    async def record_owed(self) -> None:
        """Record the finished trials that are not on record, from the steps on disk, as after a kill or a full disk."""
        for box, ending in self.diary.endings.items():
            if self._records(box) and ending != "error" and self._opened.journal.owes(self._plan(box).key):
                played = await self._replayed(box)
                await played.close()
                if played.trial is None or not played.sound:
                    raise self._bad(f"the replay of box {box} ends differently from the play")
                self._append(box, played)

    async def _ready(self) -> PausedTrial | None:
        """The trial that waits for a joint; None where the scene is no box. Boxes that nobody can play are skipped."""
        self.used = self._opened.clock()
        if self.station.kind == "over":
            await self.record_owed()
        while (station := self.station).kind == "box" and not self.diary.late:
            self._trial = trial = self._trial or await self._replayed(station.box)
            if trial.situation is not None:
                return trial
            await self.let_go()
            if trial.sound:
                raise self._bad(f"the replay of box {station.box} ends earlier than the play")
            self._write(scene="box", act=None, box=station.box, ended="error")
            self._append(station.box, trial)
        return None

    async def _attempt(self, trial: PausedTrial, act: Act) -> None:
        situation, opened = trial.situation, self._opened
        assert situation is not None
        if not isinstance(act, Attempt) or act.joint not in situation.task.joints:
            raise ActRefused("impossible", "nothing that can be done in a box: it needs one of its joints")
        asked = is_asked(situation)
        if (act.claimed is not None) != asked or (act.claimed_rt is not None and not asked):
            raise ActRefused("impossible", "what the last action did is said where it is asked, and only there")
        if not opened.scenes.experiment.device:
            act = act.model_copy(update={"pointer": None, "viewport": None})
        box, step, now = self.station.box, len(situation.past) + 1, opened.clock()
        async with AsyncExitStack() as undo:
            undo.push_async_callback(self.let_go)  # an act that is not written has not been done
            told = await trial.attempt(act.joint, act.claimed)
            self._write(
                at=now,
                scene="box",
                act=act,
                box=box,
                step=step,
                told=told,
                shown="" if trial.situation is None else opened.scenes.read(trial.plan, trial.situation)[-1],
                ended=None if trial.trial is None else trial.trial.ending,
            )
            undo.pop_all()
        if trial.trial is not None:
            self._trial = None
            self._append(box, trial)

    async def _replayed(self, box: int) -> PausedTrial:
        """The trial of a box after the steps that are on disk."""
        opened, joined, plan = self._opened, self.diary.joined, self._plan(box)
        try:
            trial = PausedTrial(
                plan,
                facts={
                    "view": view_of(plan.modality),
                    "words": joined.words,
                    "page": joined.page,
                    "position": box,
                    "history": opened.scenes.experiment.history,
                    "feedback": opened.scenes.experiment.feedback,
                },
                words_alone=True,
                pictures=opened.journal.directory / ALBUM if self._records(box) else None,
                place=opened.place,
            )
            return await trial.begin(self.diary.attempts(box))
        except BadValue as error:
            raise self._bad(str(error)) from None

    def _plan(self, box: int) -> Plan:
        scenes, diary = self._opened.scenes, self.diary
        practice = (scenes.study, scenes.experiment, diary.identity)
        return diary.plan(scenes.study, box) if box else practice_plan(*practice)

    def _records(self, box: int) -> bool:
        """Whether a box goes on record: not the practice, and nothing of a preview."""
        return bool(box) and not self.preview

    def _append(self, box: int, played: PausedTrial) -> None:
        """Record a finished trial, unless the record holds it, whoever played it."""
        trial, journal = played.trial, self._opened.journal
        assert trial is not None
        if self._records(box) and journal.owes(trial.key):
            journal.append(trial, max(0.0, self.diary.seconds(box)))

    def _write(self, *, at: float | None = None, **what: Any) -> None:
        """Write an entry of what happened now, or earlier."""
        did = Did(at=self._opened.clock() if at is None else at, turn=self.diary.turn, **what)
        if not self.preview:
            write_entry(self._opened.journal.store, self.diary.identity, did.turn, did)
        self.diary.lines.append(did)

    def _bad(self, why: str) -> BadFile:
        return bad_diary(self._opened.journal.store.path, self.diary.identity, why)
