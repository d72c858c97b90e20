"""The session of one participant: shows scenes, and writes each act to disk before the next."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AsyncExitStack

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.people.box_view import box_to_show, is_asked, read_of_step, view_of_modality
from lockprobe.people.diary import Broken, Diary, Did, Entry, Released, bad_diary, write_entry
from lockprobe.people.journey import Journey, stations
from lockprobe.people.open_study import OpenStudy
from lockprobe.people.practice import practice_plan
from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Act, Answer, Answers, Attempt, Next, fits
from lockprobe.people.right_answers import missed
from lockprobe.people.scenes import Ask, Check, ComprehensionQuestions, InstructionPage, Scene, TrialOver
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.paused_trial import PausedTrial, RecordedAttempt
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Fact, Trial


class Session:
    """The session of one participant.

    Attributes:
        journey: How far the participant has come.
        preview: Whether an experimenter looks at the study: nothing is written, and no place is taken.
        lock: Held while one request acts for the participant.
        lease: The lease of the page that may act; None before the first page asks.
        gone: Whether all data of the participant have been deleted.
        used: When the participant last asked for something, seconds since 1970.
        on_line: Called with each line after it is written.
    """

    def __init__(self, opened: OpenStudy, journey: Journey, *, preview: bool = False) -> None:
        self.journey = journey
        self.preview = preview
        self.lock = asyncio.Lock()
        self.lease: str | None = None
        self.gone = False
        self.used = journey.at
        self.on_line: Callable[[Session, Entry], None] = lambda session, line: None
        self._opened = opened
        self._trial: PausedTrial | None = None
        self._unrecorded: tuple[Trial, Timing] | None = None
        (self._lines,) = opened.journal.store.one(
            "select count(*) from act where participant = ?", journey.joined.identity
        )

    @classmethod
    async def restore(cls, opened: OpenStudy, diary: Diary) -> Session:
        """A session for a participant who joined before. Replays and records a finished, unrecorded trial.

        Raises:
            BadFile: If the diary belongs to another study, its steps differ from the record, or a replayed trial
                differs from what was shown.
        """
        diary.check_slots(opened.study, opened.journal.directory)
        way = stations(opened.experiment, opened.words, len(diary.joined.slots))
        session = cls(opened, Journey.of(diary, way))
        for box, ending in session.journey.endings.items():
            if ending == "error":
                continue
            key = diary.joined.slots[box - 1].plan(opened.study, diary.identity).key
            if opened.journal.owes(key):
                await session._record_again(box, diary)
            elif not _as_recorded(diary.attempts(box), opened.journal.read(key)[0], diary.spec):
                raise session._bad(f"its steps differ from the record of {key}")
        return session

    def _bad(self, why: str) -> BadFile:
        return bad_diary(self._opened.journal.store.path, self.journey.joined.identity, why)

    async def show(self) -> Scene:
        """The scene that the participant is in.

        Raises:
            BadFile: If something cannot be written, or a replayed trial differs from what was shown.
        """
        trial = await self._ready()
        if trial is None or trial.situation is None:
            return self._text_scene()
        return box_to_show(
            trial.plan,
            trial.situation,
            self._opened.words.page,
            experiment=self._opened.experiment,
            number=self.journey.station.box,
            of=len(self.journey.joined.slots),
        )

    async def do(self, act: Act) -> None:
        """Do one act in the scene that is shown. It is on disk when this returns.

        Raises:
            ActRefused: If the scene does not allow the act; then nothing is written.
            BadFile: If it cannot be written; the act then has no effect.
        """
        journey, turn = self.journey, self.journey.turn
        trial, station = await self._ready(), self.journey.station
        if journey.turn != turn:  # the box broke in the meantime
            raise ActRefused("stale", "not the scene that is shown")
        if trial is not None:
            await self._attempt(trial, act)
            return
        scene, right, item = self._text_scene(), None, station.item
        match scene, act:
            case (InstructionPage(), Next()) | (TrialOver(), Next()):
                pass
            case (ComprehensionQuestions(), Answers()) if _chosen(scene, act):
                right = not missed(self._opened.texts.comprehension(journey.joined), act.answers)
                item = str(journey.rounds + 1)
            case (Check(), Answer()) if act.answer in scene.options:
                right = act.answer == self._opened.experiment.checks[int(station.item) - 1].right
            case (Ask(), Answer()) if fits(scene, act):
                pass
            case _:
                raise _impossible(scene.kind)
        box = station.box if station.kind == "over" else None
        now = self._opened.clock()
        self._write(Did(at=now, turn=journey.turn, scene=scene.kind, act=act, box=box, item=item, right=right))

    def write_first(self) -> None:
        """Write the line ``joined``, the record of consent.

        Raises:
            BadFile: If it cannot be written.
        """
        self._opened.journal.used = True
        self._keep(self.journey.joined)

    async def release(self) -> None:
        """Give the trials that are not finished to others.

        Raises:
            BadFile: If it cannot be written.
        """
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
        self.used = self._opened.clock()
        self._record()
        if self._is_screened_out():
            self._write(Released(at=self._opened.clock(), why="screened"))
        while self.journey.station.kind == "box" and not self.journey.shut:
            box = self.journey.station.box
            if self._is_played():
                self._write(Broken(at=self._opened.clock(), turn=self.journey.turn, box=box))
                await self.let_go()
                continue
            trial = await self._begun()
            if trial.situation is not None:
                return trial
            began, now = self.journey.box_began, self._opened.clock()
            self._write(Broken(at=now, turn=self.journey.turn, box=box))
            self._trial = None
            self._append(box, trial, began, now)
        return None

    def _is_screened_out(self) -> bool:
        """Whether the questions on the instructions were answered wrong as often as they may be."""
        most, journey = self._opened.experiment.comprehension.rounds, self.journey
        return most is not None and journey.misread is not None and journey.rounds >= most and not journey.shut

    def _text_scene(self) -> Scene:
        texts = self._opened.texts
        return texts.closed(self.journey.shut) if self.journey.shut else texts.at(self.journey)

    async def _attempt(self, trial: PausedTrial, act: Act) -> None:
        situation, journey = trial.situation, self.journey
        assert situation is not None
        if not isinstance(act, Attempt):
            raise _impossible("box")
        if not self._opened.experiment.device:
            act = act.model_copy(update={"pointer": None, "viewport": None})
        if act.joint not in situation.task.joints:
            raise ActRefused("impossible", "no joint of this box")
        asked = is_asked(situation)
        if (act.claimed is not None) != asked or (act.claimed_rt is not None and not asked):
            raise ActRefused("impossible", "what the last action did is said where it is asked, and only there")
        box, step, began = journey.station.box, len(situation.past) + 1, journey.box_began
        now = self._opened.clock()
        async with AsyncExitStack() as undo:
            undo.push_async_callback(self.let_go)  # an act that is not written has not been done
            told, words = await trial.attempt(act.joint, act.claimed), self._opened.words.page
            self._write(
                Did(
                    at=now,
                    turn=journey.turn,
                    scene="box",
                    act=act,
                    box=box,
                    step=step,
                    told=told,
                    shown=read_of_step(trial.plan, trial.situation, words) if trial.situation else "",
                    page=self._opened.page if box and step == 1 else "",
                    ended=None if trial.trial is None else trial.trial.ending,
                )
            )
            undo.pop_all()
        if trial.trial is not None:
            self._trial = None
            self._append(box, trial, began, now)

    async def _begun(self) -> PausedTrial:
        """The trial in which the participant stands."""
        if self._trial is None:
            box = self.journey.station.box
            self._trial = await self._begin(box, self.journey.played)
            if self._trial.trial is not None and self._trial.sound:
                await self.let_go()
                raise self._bad(f"the replay of box {box} ends earlier than the play")
        return self._trial

    async def _begin(self, box: int, played: Iterable[Did]) -> PausedTrial:
        plan, facts = self._plan(box)
        pictures = self._opened.journal.directory / ALBUM if box and not self.preview else None
        steps = [
            RecordedAttempt(did.act.joint, did.act.claimed, did.told) for did in played if isinstance(did.act, Attempt)
        ]
        try:
            return await PausedTrial.begin(
                plan, steps, facts=facts, words_alone=True, pictures=pictures, place=self._opened.place
            )
        except BadValue as error:
            raise self._bad(str(error)) from None

    def _plan(self, box: int) -> tuple[Plan, Mapping[str, Fact]]:
        """The trial of a box, and the settings of the page for its record."""
        experiment = self._opened.experiment
        if not box:
            practice = practice_plan(self._opened.study, experiment, self.journey.joined.identity)
            assert practice is not None
            return practice, {}
        slot = self.journey.joined.slots[box - 1]
        plan = slot.plan(self._opened.study, self.journey.joined.identity)
        facts: dict[str, Fact] = {
            "view": view_of_modality(plan.modality),
            "words": self.journey.joined.words,
            "page": self.journey.pages.get(box, self._opened.page),
            "position": box,
            "design": experiment.design,
            "history": experiment.history,
            "history_open": experiment.history_open,
            "feedback": experiment.feedback,
        }
        return plan, facts

    def _is_played(self) -> bool:
        """Whether the record already holds the trial of this box: it was played elsewhere and imported."""
        box = self.journey.station.box
        return box > 0 and not self.preview and not self._opened.journal.owes(self._plan(box)[0].key)

    async def _record_again(self, box: int, diary: Diary) -> None:
        """Record a finished trial from the steps in the diary.

        Raises:
            BadFile: If the replay ends differently, or the record cannot be written.
        """
        trial = await self._begin(box, diary.attempts(box))
        try:
            if trial.trial is None or not trial.sound:
                raise self._bad(f"the replay of box {box} ends differently from the play")
            self._append(box, trial, *diary.times(box))
        finally:
            await trial.close()

    def _append(self, box: int, trial: PausedTrial, began: float, ended: float) -> None:
        """Record a finished trial, unless it is the practice."""
        assert trial.trial is not None
        if box and not self.preview:
            timing = Timing(key=trial.trial.key, seconds=max(0.0, ended - began), steps=len(trial.trial.steps))
            self._unrecorded = trial.trial, timing
            self._record()

    def _record(self) -> None:
        """Write the finished trial, if one waits; retry where writing failed before.

        A trial that the record already holds stays as it is, whoever played it.
        """
        if self._unrecorded is not None:
            if self._opened.journal.owes(self._unrecorded[0].key):
                self._opened.journal.append(*self._unrecorded)
            self._unrecorded = None

    def _write(self, line: Entry) -> None:
        if not self.preview:
            self._keep(line)
        self.journey.follow(line)
        self.on_line(self, line)

    def _keep(self, line: Entry) -> None:
        write_entry(self._opened.journal.store, self.journey.joined.identity, self._lines + 1, line)
        self._lines += 1


def _impossible(kind: str) -> ActRefused:
    return ActRefused("impossible", f"nothing that can be done in a scene of kind {kind}")


def _chosen(scene: ComprehensionQuestions, act: Answers) -> bool:
    """Whether there is one of its options for each question."""
    return len(act.answers) == len(scene.questions) and all(
        answer in one.options for answer, one in zip(act.answers, scene.questions, strict=True)
    )


def _as_recorded(steps: Sequence[Did], trial: Trial, agent: str) -> bool:
    """Whether a diary's steps are those of a recorded trial, if the trial is this agent's and holds its steps."""
    theirs = trial.agent == agent and bool(trial.steps)
    joints = [step.act.joint for step in steps if isinstance(step.act, Attempt)]
    return not theirs or joints == [step.decision.joint for step in trial.steps]
