"""The closed loop: the only place where plant, interventions and agent meet (paper, Sec. 2.2).

One step: memories decide what is *remembered* and prompts what is *asked*; the agent decides; actuators turn its choice
into what is *done*; the plant acts; channels decide what is *told*.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import chain
from traceback import walk_tb
from typing import Any, TypeVar

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
from lockprobe.foundation.plugins import guarded
from lockprobe.foundation.redaction import without_keys
from lockprobe.trial.model_call import Usage
from lockprobe.trial.patience import PATIENCE, own_line
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.places import Placed, Places
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent, Intervention, Plant
from lockprobe.trial.record import (
    Briefing,
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
from lockprobe.trial.source import CAMERA, said, source_of, with_reading
from lockprobe.trial.trial_json import usable

_T = TypeVar("_T")
_V = TypeVar("_V")

_TOGETHER = -1
"""Stands for all interventions together among the numbers of those that changed a step."""

Executor = Callable[[Callable[[], Any]], Awaitable[Any]]
"""Runs the blocking work of plants and channels and returns its result: here, or in another thread or process."""


async def here(work: Callable[[], _T], /) -> _T:
    """Run the work in the calling thread."""
    return work()


_PASSING = (LockprobeError, KeyboardInterrupt, GeneratorExit)
"""What passes every boundary. An agent's sys.exit() does not: it ends its trial, not the study."""


@contextmanager
def boundary(fault: type[TrialFault]) -> Iterator[None]:
    """Turn any error inside into one kind of fault; of an agent it names the line. Lockprobe's own pass unchanged."""
    try:
        yield
    except _PASSING:
        raise
    except BaseException as error:
        if isinstance(error, asyncio.CancelledError):  # one that only says so, as after a timeout inside, is an error
            with suppress(RuntimeError):  # nothing here can be cancelled
                if (task := asyncio.current_task()) is not None and task.cancelling() > 0:
                    raise
        line = own_line(walk_tb(error.__traceback__)) if fault is ModelFault else ""
        where = f"in the agent ({line}): " if line else ""
        raise fault(f"{where}{kind_and_words(error)}") from error


async def play(
    plan: Plan,
    *,
    plant: Callable[[], Plant],
    interventions: Sequence[Intervention] | Places,
    agent: Agent,
    on_step: Callable[[Step], object] = lambda step: None,
    keep: Callable[[Picture], None] | None = None,
    place: Executor = here,
    recorded: Trial | None = None,
) -> Trial:
    """Play one trial to its end.

    The truth decides when it ends: the trial is solved when the target really moves, whatever is told of it. An error
    ends it as ``error`` with the steps played so far; an error is never scored as a failure. A user's mistake, such as
    a missing key, and a budget that is reached pass.

    Args:
        plan: The trial to play.
        plant: Makes a fresh plant that holds ``plan.box``, which is closed at the end.
        interventions: In the order in which they act, or their places, which all trials of a condition have alike.
        agent: The agent that decides.
        on_step: Called after every step.
        keep: Called with every picture that the record names; without it the pictures are lost.
        place: Runs the work of plant and channels.
        recorded: A record of the trial, from which the camera's readings are taken, since another renderer might give
            others.
    """
    places = interventions if isinstance(interventions, Places) else Places(interventions)
    loop = _Loop(plan, plant, places, agent, keep, place, recorded)
    ending: Ending = "error"
    fault: TrialFault | None = None
    facts, of_plant = dict[str, Fact](), dict[str, Fact]()
    try:
        try:
            ending = await loop.run(on_step)
        except TrialFault as broke:
            fault = broke
        try:
            with boundary(ModelFault):
                facts = facts_of(agent.facts)
            with boundary(PlantFault):
                if loop.plant is not None and (said := loop.plant.facts):
                    of_plant = facts_of({"plant": plan.plant, **said})
                    if recorded is not None and CAMERA in recorded.opening_sensed and "renderer" in of_plant:
                        of_plant["renderer"] = recorded.plant.get("renderer")
        except TrialFault as broke:
            ending, fault = "error", fault or broke
    finally:
        if loop.plant is not None:
            with guarded("plant", plan.plant):
                await place(loop.plant.close)  # after all that it still does there, if the run is being ended
    changed = Counter(chain.from_iterable(loop.changed[: len(loop.steps)]))
    return record_of(
        plan,
        ending,
        fault,
        tuple(loop.steps),
        facts=facts,
        plant=of_plant,
        channels=places.channel_facts,
        interventions=places.other_facts,
        **loop.opening,
        changed={spec: changed[number] for number, spec in enumerate(places.specs) if spec},
        changed_steps=changed[_TOGETHER],
    )


def broken(plan: Plan, fault: TrialFault) -> Trial:
    """The record of a trial that broke before its first step, for example because its process died."""
    return record_of(plan, "error", fault, (), facts={}, channels=(), opening="")


_OF_PLAN = (
    *("key", "study", "agent", "called", "modality", "repetition", "trial"),
    *("seed", "budget", "assessment", "hypothesis"),
)
"""What a record has as its plan has it."""


def record_of(plan: Plan, ending: Ending, fault: TrialFault | None, steps: tuple[Step, ...], **played: Any) -> Trial:
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

    Attributes:
        plant: The plant; None before the first look.
        opening: What the record has of the first look.
        turns: What the agent was told and decided so far, but for the report that it has not answered.
        sensed: What was sensed on a record of the trial, if its readings are taken.
        state: The true configuration.
        shown: The last positions told or pictured.
        said: What the source of reports said last.
        on_record: Whether all is as on the record that is forked, up to now.
        changed: For each step the numbers of the interventions that changed it, and those of the one that is being
            made. A report counts for the step whose decision it precedes: no agent reads the last.
    """

    def __init__(
        self,
        plan: Plan,
        make: Callable[[], Plant],
        places: Places,
        agent: Agent,
        keep: Callable[[Picture], None] | None,
        at: Executor,
        recorded: Trial | None,
    ) -> None:
        self.plan, self.make, self.places, self.agent, self.keep, self.at = plan, make, places, agent, keep, at
        self.names, self.luck, self.fork, self.source = plan.names, plan.luck, plan.fork, source_of(plan.modality)
        self.patient = not type(agent).__module__.startswith("lockprobe.")  # which have limits of their own
        self.unsaid = Briefing(hypothesis=plan.hypothesis)
        self.plant: Plant | None = None
        self.sensed = [recorded.opening_sensed, *(one.sensed for one in recorded.steps)] if recorded else []
        self.opening: Mapping[str, Any] = {"opening": ""}
        self.steps, self.turns, self.moments = list[Step](), tuple[Turn, ...](), tuple[Moment, ...]()
        self.state, self.on_record = "", True
        self.shown: tuple[bool, ...] | None = None
        self.said: Snapshot | None = None
        self.changed = [set[int]()]

    async def run(self, on_step: Callable[[Step], object]) -> Ending:
        """Look at the box for the first time, and play step by step; how the trial ends."""
        with boundary(PlantFault):
            snapshot, self.state, moment = await self.at(self._happened)
            sensed = facts_of(snapshot.sensed)
        self.moments, self.shown, told = (moment,), moment.shown, moment.told
        self.opening = {"opening": told.text, "opening_pictures": self._kept(told), "opening_sensed": sensed}
        for _ in range(self.plan.budget):
            step = await self.step()
            on_step(step)
            if step.moved and step.joint == self.plan.box.target:
                return "solved"
        return "budget"

    async def step(self) -> Step:
        """Ask the agent, attempt a joint, tell it what happened."""
        past, number, acting, task = self.moments, len(self.moments), self.places.at, self.names.task
        labels, joints, fork = self.names.labels, self.plan.box.joints, self.fork
        report, turns, briefing = past[-1].told, self.turns, self.unsaid
        if acting["remembered"] or acting["asked"]:  # their luck is that of the report
            with boundary(ChannelFault):
                turns = self._passed(acting["remembered"], turns, number - 1)
                if not isinstance(turns, tuple):
                    raise ChannelFault(f"recall returned {type(turns).__name__}, and no tuple of turns")
                briefing = self._passed(acting["asked"], briefing, number - 1)
                briefing.remark.encode()  # breaks if it cannot be written
        recorded = fork.recorded[number - 1] if fork and self.on_record and number <= len(fork.recorded) else None
        with boundary(ModelFault):  # of a fork nothing on record is asked, but an agent that draws from its stream
            if recorded is not None and getattr(self.agent, "unseeded", False):
                decision = recorded.decision
            else:
                situation = Situation(task=task, past=turns, percept=report, briefing=briefing)
                answer = self.agent.decide(situation, self.luck.at("agent", number))
                if self.patient:
                    answer = PATIENCE.limited(answer, self.plan.agent, getattr(self.agent, "step_seconds", 60.0))
                decision = await answer
        decision = usable(decision, task)
        label = decision.joint
        if acting["done"]:
            with boundary(ChannelFault):
                label = self._passed(acting["done"], label, number)
                if label not in task.joints:
                    raise ChannelFault(f"{label!r} is not a joint")
        joint = labels.index(label)
        self.changed.append(set())
        with boundary(PlantFault):
            snapshot, state, moment = await self.at(partial(self._happened, joint, decision.joint, label))
            sensed = facts_of(snapshot.sensed)
        moved, told = snapshot.outcome == "moved", moment.told
        told_moved, told_state = self._compared(moment, state, moved=moved)
        step = Step.of(
            step=number,
            state=self.state,
            joint=joints[joint].name,
            moved=moved,
            told_moved=told_moved,
            told_state=told_state,
            told=told.text,
            decision=decision,
            sensed=sensed,
            pictures=self._kept(told),
            chosen=None if decision.joint == label else joints[labels.index(decision.joint)].name,
            remark=briefing.remark,
        )
        self.steps.append(step)
        self.turns = (*self.turns, Turn(percept=report, decision=decision, remark=briefing.remark))
        self.moments, self.state = (*past, moment), state
        if fork is not None:
            self.on_record = step == recorded
            if number < fork.name.at and not self.on_record:
                raise ModelFault(f"step {number} cannot be replayed from the record without asking the agent again")
            if number == fork.name.at and fork.name.time > 1:  # each continuation but the first has luck of its own
                self.luck = self.plan.luck.but(time=fork.name.time)
        return step

    def _happened(
        self, joint: int | None = None, chosen: str | None = None, attempted: str | None = None
    ) -> tuple[Snapshot, str, Moment]:
        """What an attempt, or the first look, really did, the configuration then, and what is told of it.

        A way to look is for channels alone. What puts a report into words or pictures keeps its facts beside it. An arm
        of a fork acts in place of what acts on the facts of its report.
        """
        names, source, past, fork, step = self.names, self.source, self.moments, self.fork, len(self.moments)
        if self.plant is None:
            self.plant = self.make()
        snapshot = self.plant.observe() if joint is None else self.plant.attempt(joint)
        if source is not None:
            snapshot = with_reading(snapshot, self.sensed[step] if step < len(self.sensed) else {})
        if len(state := bits(snapshot.configuration)) != len(names.labels):
            raise PlantFault(f"{len(state)} positions of {len(names.labels)} joints")
        arm = fork if fork is not None and fork.replaces(step) else None
        if source is None:
            was = names.percept(snapshot)
        else:  # where an arm of a fork acts, the truth is said
            self.said = snapshot if arm else said(source, snapshot, self.said)
            was = names.percept(self.said)
        told = was if snapshot.look is None else was.but(look=partial(self._look, snapshot))
        facts, showing, channels, joints = None, self.places.showing, self.places.at["told"], names.task.joints
        if arm is not None:
            own = {id(one) for one in arm.acting}
            channels = [one for one in channels if id(one.one) in own]
        with boundary(ChannelFault):
            told = self._passed(channels, told, step, showing.traits.shown if showing else None)
            if showing is not None:
                facts = told.but(look=None)
                told = showing.act(told, past, names.task, self.luck.at(showing.stream, step))
            told = self._passed(self.places.after, told, step)
            told.text.encode()  # breaks if it cannot be written
            if told.joint is not None and told.joint not in joints:
                raise ChannelFault(f"{told.joint!r} is not a joint")
            if (where := told.positions) is not None and not (len(where) == len(joints) and {*where} <= {False, True}):
                raise ChannelFault(f"positions {where!r} are not one truth value for each of {len(joints)} joints")
        return (
            snapshot,
            state,
            Moment(was=was, told=told.but(look=None), chosen=chosen, attempted=attempted, facts=facts),
        )

    def _passed(
        self, acting: Sequence[Placed], given: _V, drawn: int, shown: Callable[[Any], object] | None = None
    ) -> _V:
        """A value after interventions; those of them that changed what the agent gets are noted.

        An intervention changes a step if it changed what it was given, and the agent would have got something else
        without it: what no report shows, or a later intervention hides, is no change. ``drawn`` is the step of their
        luck. ``shown`` is the part of the value that the agent gets; all of it without one.
        """
        value, changers, past, task, luck = given, list[tuple[Placed, _V]](), self.moments, self.names.task, self.luck
        for placed in acting:
            before, value = value, placed.act(value, past, task, luck.at(placed.stream, drawn))
            if value is not before and value != before:
                changers.append((placed, before))
        if not changers:
            return value
        gets = shown or (lambda whole: whole)
        end = gets(value)
        if gets(given) != end:
            self.changed[-1].add(_TOGETHER)
        for at, (placed, before) in enumerate(changers, 1):
            without = before
            try:  # what the agent would have got without it: later ones act again, on the value before it
                for later, _ in changers[at:]:
                    without = later.act(without, past, task, luck.at(later.stream, drawn))
                changed = gets(without) != end
            except Exception:  # noqa: BLE001  one that breaks needs what was changed before it
                changed = True
            if changed:
                self.changed[-1].add(placed.number)
        return value

    def _look(self, snapshot: Snapshot, positions: tuple[bool, ...] | None = None) -> Frame:
        """Take a picture for a channel. A failure is the plant's fault."""
        with boundary(PlantFault):
            return self.names.picture(snapshot, positions)

    def _kept(self, percept: Percept) -> dict[PictureKind, str]:
        if self.keep is not None:
            for picture in percept.pictures:
                self.keep(picture)
        return {picture.kind: picture.name for picture in percept.pictures}

    def _compared(self, moment: Moment, state: str, *, moved: bool) -> tuple[bool | None, str | None]:
        """The outcome and the configuration that a report tells, also as positions imply them; None where none."""
        told, shown = moment.told, moment.shown
        if told.outcome is not None:
            told_moved = told.outcome == "moved"
        elif told.pictures and shown is None:  # a picture that was not made from a report shows the truth
            told_moved = moved
        elif told.joint is None or shown is None or self.shown is None:
            told_moved = None
        else:  # positions are compared with the last ones told or pictured
            place = self.names.listing.index(told.joint)
            told_moved = shown[place] != self.shown[place]
        if shown is None:
            return told_moved, None
        self.shown = shown
        if self.source is None and shown == moment.was.positions:
            return told_moved, state if told.positions else None  # a true picture says nothing that the truth does not
        return told_moved, bits(self.names.configuration(shown))
