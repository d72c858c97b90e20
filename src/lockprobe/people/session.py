"""One participant who takes part now: what is shown, what is done, and that it is on disk before more is shown."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.participant import participant_spec
from lockprobe.errors import BadFile, BadValue
from lockprobe.people.answers import fits
from lockprobe.people.box_view import box_to_show, view_of_modality
from lockprobe.people.diary import PEOPLE_DIRECTORY, Broken, Diary, Did, Entry, Released
from lockprobe.people.directory import PeopleDirectory
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey
from lockprobe.people.paused_trial import Held, Played
from lockprobe.people.refusals import Refused
from lockprobe.people.responses import Act, Answer, Attempt, Next
from lockprobe.people.scenes import Ask, Box, Check, Page, Scene, TrialOver
from lockprobe.people.text_scenes import Texts
from lockprobe.people.texts import Words
from lockprobe.plan import Plan
from lockprobe.record import Fact, Trial
from lockprobe.studies.journal import Journal, Timing
from lockprobe.studies.picture_store import ALBUM
from lockprobe.studies.study import Study
from lockprobe.trial import Executor

__all__ = ["Seat", "Table"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """What all participants of a study share.

    Attributes:
        study: The study.
        experiment: How people take part.
        words: What is read.
        texts: The same with the facts of the study filled in.
        practice: The practice box as a trial; None without.
        journal: Where finished trials go.
        people: Where all else goes that is kept of them.
        place: Where plants do their work.
        clock: Seconds since 1970.
        page: Version of the page on which they play.
    """

    study: Study
    experiment: Experiment
    words: Words
    texts: Texts
    practice: Plan | None
    journal: Journal
    people: PeopleDirectory
    place: Executor
    clock: Callable[[], float]
    page: str


class Seat:
    """One participant.

    Args:
        table: What all share.
        journey: How far the participant has come.

    Attributes:
        journey: How far the participant has come.
        lock: Held by whoever acts for them; one at a time.
        lease: Of the page that may act; None before the first page asks.
        gone: Whether all that was kept of them has been deleted.
        used: When it was last asked for, seconds since 1970.
        on_line: Told of each line that was written.
    """

    def __init__(self, table: Table, journey: Journey) -> None:
        self.journey = journey
        self.lock = asyncio.Lock()
        self.lease: str | None = None
        self.gone = False
        self.used = table.clock()
        self.on_line: Callable[[Seat, Entry], None] = lambda seat, line: None
        self._table = table
        self._held: Held | None = None
        self._unrecorded: tuple[Trial, Timing] | None = None
        self._diary = Diary(self.path)

    @property
    def path(self) -> Path:
        """Of the diary."""
        return self._table.journal.directory / PEOPLE_DIRECTORY / f"{self.journey.identity}.jsonl"

    async def show(self) -> Scene:
        """The scene in which the participant stands.

        Raises:
            BadFile: If something cannot be written, or what would be shown is not what was shown before.
        """
        self.used = self._table.clock()
        self._record()
        while self.journey.station.kind == "box" and not self.journey.released:
            if self._is_played():
                await self._pass_over()
                continue
            held = await self._hold()
            if held.situation is not None:
                station, experiment = self.journey.station, self._table.experiment
                return box_to_show(
                    held.plan,
                    held.situation,
                    experiment=experiment,
                    number=station.box,
                    of=len(self.journey.joined.slots),
                )
            await self._broke(held)
        return self._table.texts.closed("late") if self.journey.released else self._table.texts.at(self.journey)

    async def do(self, act: Act) -> None:
        """Do one act in the scene that is shown, on disk when this returns.

        Raises:
            Refused: If it is nothing that can be done here; then nothing is written.
            BadFile: If it cannot be written; then it has not been done.
        """
        journey, turn = self.journey, self.journey.turn
        scene, station = await self.show(), self.journey.station
        if journey.turn != turn:  # the box broke in the meantime
            raise Refused("stale", "not the scene that is shown")
        match scene, act:
            case (Box(), Attempt()):
                await self._attempt(scene, act)
                return
            case (Page(), Next()) | (TrialOver(), Next()):
                right = None
            case (Check(), Answer()) if act.answer in scene.options:
                right = act.answer == self._table.experiment.checks[int(station.item) - 1].right
            case (Ask(), Answer()) if fits(scene, act):
                right = None
            case _:
                raise Refused("impossible", f"nothing that can be done in a scene of kind {scene.kind}")
        box = station.box if station.kind == "over" else None
        now = self._table.clock()
        self._write(Did(at=now, turn=journey.turn, scene=scene.kind, act=act, box=box, item=station.item, right=right))

    def write_first(self) -> None:
        """Put on disk that they take part.

        Raises:
            BadFile: If it cannot be written.
        """
        self._diary.write(self.journey.joined)

    async def release(self) -> None:
        """Give the trials that are not finished to others.

        Raises:
            BadFile: If it cannot be written.
        """
        self._write(Released(at=self._table.clock()))
        await self.let_go()

    @property
    def holds(self) -> bool:
        """Whether a trial is held."""
        return self._held is not None

    async def let_go(self) -> None:
        """Let go of the trial that is held; it is played again when it is needed."""
        held, self._held = self._held, None
        if held is not None:
            await held.close()

    async def record_again(self, box: int, played: Sequence[Played], began: float, ended: float) -> None:
        """Put a trial on disk that was over and was not written down, from the steps in the diary.

        Args:
            box: Which of their boxes.
            played: Its steps.
            began: When it was first shown, seconds since 1970.
            ended: When it was over.

        Raises:
            BadFile: If it cannot be played again as it was, or be written.
        """
        held = await self._begin(box, played)
        try:
            if held.trial is None or not held.sound:
                raise BadFile(self.path, f"box {box} does not end as it did when it was played")
            self._append(held.trial, began, ended)
        finally:
            await held.close()

    async def _attempt(self, scene: Box, act: Attempt) -> None:
        held, journey = self._held, self.journey
        if not self._table.experiment.device:
            act = act.model_copy(update={"pointer": None, "viewport": None})
        if act.joint not in {joint.label for joint in scene.panel.joints}:
            raise Refused("impossible", "no joint of this box")
        if (act.claimed is not None) != scene.ask or (act.claimed_rt is not None and not scene.ask):
            raise Refused("impossible", "what the last action did is said where it is asked, and only there")
        assert held is not None
        box, began, now = journey.station.box, journey.box_began, self._table.clock()
        async with AsyncExitStack() as undo:
            undo.push_async_callback(self.let_go)  # where it is not written down it has not been done
            told = await held.attempt(act.joint, act.claimed)
            self._write(
                Did(
                    at=now,
                    turn=journey.turn,
                    scene=scene.kind,
                    act=act,
                    box=box,
                    step=scene.step,
                    told=told,
                    page=self._table.page if box and scene.step == 1 else "",
                    ended=None if held.trial is None else held.trial.ending,
                )
            )
            undo.pop_all()
        if held.trial is not None:
            self._held = None
            if box:
                self._append(held.trial, began, now)

    async def _hold(self) -> Held:
        if self._held is None:
            self._held = await self._begin(self.journey.station.box, self.journey.played)
            if self._held.trial is not None and self._held.sound:
                await self.let_go()
                raise BadFile(self.path, f"box {self.journey.station.box} is over where it was not when it was played")
        return self._held

    async def _begin(self, box: int, played: Sequence[Played]) -> Held:
        plan, facts = self._plan(box)
        pictures = self._table.journal.directory / ALBUM if box else None
        try:
            return await Held.begin(plan, played, facts=facts, pictures=pictures, place=self._table.place)
        except BadValue as error:
            raise BadFile(self.path, str(error)) from None

    def _plan(self, box: int) -> tuple[Plan, Mapping[str, Fact]]:
        """What is played in a box, and on what."""
        if not box:
            assert self._table.practice is not None
            return self._table.practice, {}
        slot, experiment = self.journey.joined.slots[box - 1], self._table.experiment
        agent = participant_spec(self.journey.identity)
        facts: dict[str, Fact] = {
            "view": view_of_modality(slot.modality, experiment.view),
            "words": self.journey.joined.words,
            "page": self.journey.pages.get(box, self._table.page),
            "position": box,
            "design": experiment.design,
            "history": experiment.history,
            "history_open": experiment.history_open,
            "feedback": experiment.feedback,
        }
        return self._table.study.plan(
            agent, self._table.study.condition(slot.p, slot.modality), slot.repetition, slot.trial
        ), facts

    def _is_played(self) -> bool:
        """Whether somebody elsewhere has finished the trial in which they stand, and it was taken in here."""
        box = self.journey.station.box
        return box > 0 and not self._table.journal.owes(self._plan(box)[0].key)

    async def _pass_over(self) -> None:
        """Go on with what comes after a box whose trial is on record already; what was done in it stays written."""
        self._write(Broken(at=self._table.clock(), turn=self.journey.turn, box=self.journey.station.box))
        await self.let_go()

    async def _broke(self, held: Held) -> None:
        """Go on with what comes after a box that nobody can play."""
        assert held.trial is not None
        box, began, now = self.journey.station.box, self.journey.box_began, self._table.clock()
        self._write(Broken(at=now, turn=self.journey.turn, box=box))
        self._held = None
        if box:
            self._append(held.trial, began, now)

    def _append(self, trial: Trial, began: float, ended: float) -> None:
        self._unrecorded = trial, Timing(key=trial.key, seconds=max(0.0, ended - began), steps=len(trial.steps))
        self._record()

    def _record(self) -> None:
        """Put a trial on disk that is over, if there is one; where that failed it is tried again.

        A trial that is finished on record stays there as it is, whoever played it.
        """
        if self._unrecorded is not None:
            if self._table.journal.owes(self._unrecorded[0].key):
                self._table.journal.append(*self._unrecorded)
            self._unrecorded = None

    def _write(self, line: Entry) -> None:
        self._diary.write(line)
        self.journey.follow(line)
        self.on_line(self, line)
