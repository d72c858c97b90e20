"""The closed loop: the only place where plant, interventions and agent meet (paper, Sec. 2.2).

One step: memories decide what is *remembered* and prompts what is *asked*; the agent decides; actuators turn its choice
into what is *done*; the plant acts; channels decide what is *told*.
"""

from __future__ import annotations

import asyncio
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from traceback import walk_tb
from types import TracebackType
from typing import Any, Protocol, TypeVar

from lockprobe.boxes.box import bits
from lockprobe.foundation.errors import (
    ChannelFault,
    LockprobeError,
    ModelFault,
    PlantFault,
    ReplyFault,
    TrialFault,
    kind_and_words,
)
from lockprobe.foundation.redaction import without_keys
from lockprobe.trial.model_call import Usage
from lockprobe.trial.patience import PATIENCE, own_line
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.places import Placed, Places
from lockprobe.trial.plan import Fork, Plan
from lockprobe.trial.protocols import Agent, Intervention, Plant
from lockprobe.trial.record import (
    Briefing,
    Decision,
    Ending,
    Fact,
    Moment,
    Percept,
    Situation,
    Snapshot,
    Step,
    Trial,
    TrialError,
    Turn,
    facts_of,
)
from lockprobe.trial.source import said, source_of, with_reading
from lockprobe.trial.trial_json import usable

_T = TypeVar("_T")
_V = TypeVar("_V")

_TOGETHER = -1
"""Stands for all interventions together among the numbers of those that changed a step."""


class Executor(Protocol):
    """Runs the blocking work of plants and channels: here, or in another thread or process."""

    async def __call__(self, work: Callable[[], _T], /) -> _T:
        """The result of the work, which is run there."""
        ...


async def here(work: Callable[[], _T], /) -> _T:
    """Run the work in the calling thread."""
    return work()


_PASSING = (LockprobeError, KeyboardInterrupt, GeneratorExit)
"""What passes every boundary. An agent's sys.exit() does not: it ends its trial, not the study."""


class Boundary:
    """Turns any error inside into one kind of fault. Lockprobe's own errors pass unchanged.

    ``part`` is what the message calls code that somebody wrote for this part; its file and line are named then.
    """

    __slots__ = ("_fault", "_part")

    def __init__(self, fault: type[TrialFault], part: str = "") -> None:
        self._fault, self._part = fault, part

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None or isinstance(error, _PASSING):
            return
        if isinstance(error, asyncio.CancelledError):  # one that only says so, as after a timeout inside, is an error
            with suppress(RuntimeError):  # nothing here can be cancelled
                if (task := asyncio.current_task()) is not None and task.cancelling() > 0:
                    return
        line = own_line(walk_tb(trace)) if self._part else ""
        where = f"in {self._part} ({line}): " if line else ""
        raise self._fault(f"{where}{kind_and_words(error)}") from error


AGENT = Boundary(ModelFault, "the agent")
INTERVENTIONS, PLANT = Boundary(ChannelFault), Boundary(PlantFault)


async def play(
    plan: Plan,
    *,
    plant: Plant,
    interventions: Sequence[Intervention] | Places,
    agent: Agent,
    on_step: Callable[[Step], None] | None = None,
    keep: Callable[[Picture], None] | None = None,
    place: Executor = here,
) -> Trial:
    """Play one trial to its end.

    The truth decides when it ends: the trial is solved when the target really moves, whatever is told of it. An error
    ends it as ``error`` with the steps played so far; an error is never scored as a failure. A user's mistake, such as
    a missing key, and a budget that is reached pass.

    Args:
        plan: The trial to play.
        plant: A fresh plant that holds ``plan.box``.
        interventions: In the order in which they act, or their places, which all trials of a condition have alike.
        agent: The agent that decides.
        on_step: Called after every step.
        keep: Called with every picture that the record names; without it the pictures are lost.
        place: Runs the work of plant and channels.
    """
    places = interventions if isinstance(interventions, Places) else Places(interventions)
    loop = _Loop(plan, plant, places, agent, keep, place)
    ending: Ending = "budget"
    fault: TrialFault | None = None
    try:
        await loop.open()
        for _ in range(plan.budget):
            step = await loop.step()
            if on_step is not None:
                on_step(step)
            if step.moved and step.joint == plan.box.target:
                ending = "solved"
                break
    except TrialFault as broke:
        ending, fault = "error", broke
    facts, made = dict[str, Fact](), dict[str, Fact]()
    try:
        with AGENT:
            facts = facts_of(agent.facts)
        with PLANT:
            made = facts_of({"plant": plan.plant, **plant.facts}) if plant.facts else {}
    except TrialFault as broke:
        ending, fault = "error", fault or broke
    acting = {"channels": places.channel_facts, "interventions": places.other_facts}
    return _record(plan, ending, fault, tuple(loop.steps), facts=facts, plant=made, **acting, **loop.played())


def broken(plan: Plan, fault: TrialFault) -> Trial:
    """The record of a trial that broke before its first step, for example because its process died."""
    return _record(plan, "error", fault, (), facts={}, channels=(), opening="")


_OF_PLAN = (
    *("key", "study", "agent", "called", "modality", "repetition", "trial"),
    *("seed", "budget", "assessment", "hypothesis"),
)
"""What a record has as its plan has it."""


def _record(plan: Plan, ending: Ending, fault: TrialFault | None, steps: tuple[Step, ...], **played: Any) -> Trial:
    """The record of a trial: what its plan says of it, and what was played; a fault is of the step after the last."""
    error: TrialError | None = None
    if fault is not None:
        replies, spent = (fault.replies, fault.usage) if isinstance(fault, ReplyFault) else ((), {})
        error = TrialError(
            boundary=fault.boundary,
            message=str(fault),
            step=len(steps) + 1,
            replies=tuple(map(without_keys, replies)),
            usage=Usage(**spent) if spent else None,
        )
    return Trial(
        **{name: getattr(plan, name) for name in _OF_PLAN},
        box=plan.box.name,
        condition=plan.label,
        specs=plan.condition.specs,
        doses=plan.condition.doses,
        joints=plan.box.names,
        labels=plan.names.labels,
        listing=plan.names.listing,
        target=plan.box.target,
        steps=steps,
        ending=ending,
        error=error,
        fork=plan.fork.name if plan.fork is not None else None,
        **played,
    )


class _Loop:
    """The state of one trial while it runs.

    Its moments are those so far, so their number is the number of the step, or, for a report, that of the step whose
    decision it precedes less one.
    """

    def __init__(
        self,
        plan: Plan,
        plant: Plant,
        places: Places,
        agent: Agent,
        keep: Callable[[Picture], None] | None,
        place: Executor,
    ) -> None:
        self.steps = list[Step]()
        self._opening_pictures: Mapping[PictureKind, str] = {}
        self._opening_sensed: Mapping[str, Fact] = {}
        self._plan, self._plant, self._agent, self._keep, self._at = plan, plant, agent, keep, place
        self._places, self._names, self._task, self._luck = places, plan.names, plan.names.task, plan.luck
        self._ours = type(agent).__module__.startswith("lockprobe.")
        self._unsaid = Briefing(hypothesis=plan.hypothesis)
        self._source = source_of(plan.condition.modality)
        self._said: Snapshot | None = None  # by the source, last
        self._on_record = plan.fork is not None  # whether all is as on record up to now
        self._turns: tuple[Turn, ...] = ()
        self._moments: tuple[Moment, ...] = ()
        self._state = ""  # the true configuration
        self._shown: tuple[bool, ...] | None = None  # the last positions told or pictured
        self._changers: dict[int, set[int]] = defaultdict(set)  # step -> the numbers of those that changed it

    async def open(self) -> None:
        """Look at the box for the first time."""
        with PLANT:
            snapshot, self._state, first = await self._at(self._happened)
            self._opening_sensed = facts_of(snapshot.sensed)
        self._moments, self._shown = (first,), first.shown
        self._opening_pictures = self._kept(first.told)

    async def step(self) -> Step:
        """Ask the agent, attempt a joint, tell it what happened."""
        past, number, at, box = self._moments, len(self._moments), self._places.at, self._plan.box.joints
        turns, briefing, report = self._turns, self._unsaid, past[-1].told
        if at["remembered"] or at["asked"]:  # their luck is that of the report
            with INTERVENTIONS:
                turns = self._passed(at["remembered"], turns, number - 1, number)
                if not isinstance(turns, tuple):
                    raise ChannelFault(f"recall returned {type(turns).__name__}, and no tuple of turns")
                briefing = self._passed(at["asked"], briefing, number - 1, number)
                briefing.remark.encode()  # breaks if it cannot be written
        with AGENT:
            decision = await self._decision(Situation(task=self._task, past=turns, percept=report, briefing=briefing))
        decision = usable(decision, self._task)
        label = decision.joint
        if at["done"]:
            with INTERVENTIONS:
                label = self._passed(at["done"], label, number, number)
                if label not in self._task.joints:
                    raise ChannelFault(f"{label!r} is not a joint")
        joint = self._names.labels.index(label)
        with PLANT:
            snapshot, state, moment = await self._at(partial(self._happened, joint, decision.joint, label))
            sensed = facts_of(snapshot.sensed) if snapshot.sensed else {}
        moved = snapshot.outcome == "moved"
        told_moved, told_state = self._compared(moment, state, moved=moved)
        step = Step(
            step=number,
            state=self._state,
            joint=box[joint].name,
            moved=moved,
            told_moved=told_moved,
            told_state=told_state,
            told=moment.told.text,
            decision=decision,
            sensed=sensed,
            pictures=self._kept(moment.told) if moment.told.pictures else {},
            chosen=None if decision.joint == label else box[self._names.labels.index(decision.joint)].name,
            remark=briefing.remark,
        )
        self.steps.append(step)
        self._turns = (*self._turns, Turn(percept=report, decision=decision, remark=briefing.remark))
        self._moments, self._state = (*past, moment), state
        if self._plan.fork is not None:
            self._compare(step, self._plan.fork)
        return step

    def played(self) -> dict[str, Any]:
        """What was played, by the names of the record.

        A report that an intervention changed counts at the step whose decision it precedes: no agent reads the last.
        """
        done = (changers for step, changers in self._changers.items() if step <= len(self.steps))
        counts = Counter(chain.from_iterable(done))
        return {
            "opening": self._moments[0].told.text if self._moments else "",
            "opening_pictures": self._opening_pictures,
            "opening_sensed": self._opening_sensed,
            "changed": {spec: counts[number] for number, spec in enumerate(self._places.specs) if spec},
            "changed_steps": counts[_TOGETHER],
        }

    async def _decision(self, situation: Situation) -> Decision:
        """Ask the agent. On a fork the past is on record: nothing is asked there whose answer costs money.

        An agent with a random stream decides again. One that draws its own luck is not asked for as long as everything
        is as on record, also after the fork.
        """
        fork, now = self._plan.fork, len(self.steps)
        played = fork is not None and self._on_record and now < len(fork.recorded)
        if fork is not None and played and getattr(self._agent, "unseeded", False):
            return fork.recorded[now].decision
        decision = self._agent.decide(situation, self._luck.at("agent", now + 1))
        if self._ours:
            return await decision
        return await PATIENCE.limited(decision, self._plan.agent, getattr(self._agent, "step_seconds", 60.0))

    def _happened(
        self, joint: int | None = None, chosen: str | None = None, attempted: str | None = None
    ) -> tuple[Snapshot, str, Moment]:
        """What an attempt, or the first look, really did, the configuration then, and what is told of it."""
        snapshot = self._plant.observe() if joint is None else self._plant.attempt(joint)
        if self._source is not None:
            snapshot = with_reading(snapshot)
        if len(state := bits(snapshot.configuration)) != len(self._names.labels):
            raise PlantFault(f"{len(state)} positions of {len(self._names.labels)} joints")
        was = percept = self._names.percept(snapshot)
        fork, step = self._plan.fork, len(self._moments)
        arm = fork if fork is not None and fork.replaces(step) else None
        if self._source is not None:  # where an arm of a fork acts, the truth is said
            self._said = snapshot if arm else said(self._source, snapshot, self._said)
            was = percept = replace(self._names.percept(self._said), look=percept.look)
        if percept.look is not None:
            was, percept = replace(percept, look=None), replace(percept, look=partial(_look, percept.look))
        with INTERVENTIONS:
            told, facts = self._told(percept, step, arm)
        return snapshot, state, Moment(was=was, told=told, chosen=chosen, attempted=attempted, facts=facts)

    def _told(self, percept: Percept, step: int, arm: Fork | None) -> tuple[Percept, Percept | None]:
        """What the agent gets of the report of a step, and the facts from which words or pictures were made.

        Without a way to look, which is for channels. The facts are None where the report holds them itself. An arm of
        a fork acts in place of what acts on the facts of its report.
        """
        facts, showing, channels, after = None, self._places.showing, self._places.at["told"], self._places.after
        if arm is not None:
            own = {id(one) for one in arm.acting}
            channels, after = (
                [one for one in several if one.traits.after_words or id(one.one) in own]
                for several in (channels, after)
            )
        percept = self._passed(channels, percept, step, step + 1, showing.traits.shown if showing else None)
        if showing is not None:
            facts = percept if percept.look is None else replace(percept, look=None)
            percept = showing.act(percept, self._moments, self._task, self._luck.at(showing.stream, step))
        if after:
            worded, percept = percept, self._passed(after, percept, step, step + 1)
            if (worded.outcome, worded.positions) != (percept.outcome, percept.positions):
                facts = None  # something after the words changed what is told: that holds the facts now
        percept.text.encode()  # breaks if it cannot be written
        joints, positions = self._task.joints, percept.positions
        if percept.joint is not None and percept.joint not in joints:
            raise ChannelFault(f"{percept.joint!r} is not a joint")
        if positions is not None and not (len(positions) == len(joints) and {*positions} <= {False, True}):
            raise ChannelFault(f"positions {positions!r} are not one truth value for each of {len(joints)} joints")
        return percept if percept.look is None else replace(percept, look=None), facts

    def _passed(
        self,
        acting: Sequence[Placed],
        given: _V,
        drawn: int,
        noted: int,
        shown: Callable[[Any], object] | None = None,
    ) -> _V:
        """A value after interventions; those of them that changed what the agent gets are noted.

        An intervention changes a step if it changed what it was given, and the agent would have got something else
        without it: what no report shows, or a later intervention hides, is no change. ``drawn`` is the step of their
        luck, ``noted`` that at which their changes count. ``shown`` is the part of the value that the agent gets; all
        of it without one.
        """
        value, changers, past, task, luck = given, list[tuple[Placed, _V]](), self._moments, self._task, self._luck
        for placed in acting:
            before, value = value, placed.act(value, past, task, luck.at(placed.stream, drawn))
            if value is not before and value != before:
                changers.append((placed, before))
        if not changers:
            return value
        gets = shown or (lambda whole: whole)
        end = gets(value)
        if gets(given) != end:
            self._changers[noted].add(_TOGETHER)
        for at, (placed, before) in enumerate(changers, 1):
            without = before
            try:  # what the agent would have got without it: later ones act again, on the value before it
                for later, _ in changers[at:]:
                    without = later.act(without, past, task, luck.at(later.stream, drawn))
                changed = gets(without) != end
            except Exception:  # noqa: BLE001  one that breaks needs what was changed before it
                changed = True
            if changed:
                self._changers[noted].add(placed.number)
        return value

    def _kept(self, percept: Percept) -> dict[PictureKind, str]:
        if self._keep is not None:
            for picture in percept.pictures:
                self._keep(picture)
        return {picture.kind: picture.name for picture in percept.pictures}

    def _compared(self, moment: Moment, state: str, *, moved: bool) -> tuple[bool | None, str | None]:
        """The outcome and the configuration that a report tells, also as positions imply them; None where none."""
        told, shown = moment.told, moment.shown
        if told.outcome is not None:
            told_moved = told.outcome == "moved"
        elif told.pictures and shown is None:  # a picture that was not made from a report shows the truth
            told_moved = moved
        elif told.joint is None or shown is None or self._shown is None:
            told_moved = None
        else:  # positions are compared with the last ones told or pictured
            place = self._names.listing.index(told.joint)
            told_moved = shown[place] != self._shown[place]
        if shown is None:
            return told_moved, None
        self._shown = shown
        if self._source is None and shown == moment.was.positions:
            return told_moved, state if told.positions else None  # a true picture says nothing that the truth does not
        return told_moved, bits(self._names.configuration(shown))

    def _compare(self, step: Step, fork: Fork) -> None:
        """Compare a step of a fork with the record, and change the luck after the fork for all but the first time."""
        before = fork.recorded[step.step - 1] if self._on_record and step.step <= len(fork.recorded) else None
        self._on_record = step == before
        if step.step < fork.name.at and not self._on_record:
            raise ModelFault(f"step {step.step} cannot be replayed from the record without asking the agent again")
        if step.step == fork.name.at and fork.name.time > 1:
            self._luck = replace(self._plan.luck, time=fork.name.time)


def _look(look: Callable[..., Frame], positions: tuple[bool, ...] | None = None) -> Frame:
    """Take a picture. A failure is the plant's fault."""
    with PLANT:
        return look(positions)
