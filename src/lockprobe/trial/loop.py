"""The closed loop: the only place where plant, interventions and agent meet (paper, Sec. 2.2).

One step: memories decide what is *remembered* and prompts what is *asked*; the agent decides; actuators turn its choice
into what is *done*; the plant acts; channels decide what is *told*.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Protocol, TypeVar

from lockprobe.boxes.box import Configuration, bits
from lockprobe.foundation.errors import ChannelFault, ModelFault, ReplyFault, TrialFault
from lockprobe.foundation.redaction import without_keys
from lockprobe.trial.boundary import AGENT, INTERVENTIONS, PLANT
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.changes import Acting, Changes, pass_through
from lockprobe.trial.decision_check import why_unusable
from lockprobe.trial.luck import Luck
from lockprobe.trial.model_call import Usage
from lockprobe.trial.patience import PATIENCE
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.places import Places, facts_of
from lockprobe.trial.plan import Fork, Names, Plan
from lockprobe.trial.protocols import (
    Actuator,
    Agent,
    AgentTraits,
    Channel,
    Intervention,
    InterventionTraits,
    Memory,
    Plant,
    Prompt,
)
from lockprobe.trial.record import (
    Decision,
    Ending,
    Fact,
    Look,
    Moment,
    Percept,
    Situation,
    Snapshot,
    Step,
    Trial,
    TrialError,
    Turn,
)
from lockprobe.trial.source import ReportSource
from lockprobe.trial.told_outcome import told_moved, told_positions

_T = TypeVar("_T")


class Executor(Protocol):
    """Runs the blocking work of plants and channels: here, or in another thread or process."""

    async def __call__(self, work: Callable[[], _T], /) -> _T:
        """Run the work there and return its result."""
        ...


async def here(work: Callable[[], _T], /) -> _T:
    """Run the work in the calling thread."""
    return work()


async def play(
    plan: Plan,
    *,
    plant: Plant,
    interventions: Sequence[Intervention] | Places,
    agent: Agent,
    on_step: Callable[[Step], None] | None = None,
    keep: Callable[[Picture], None] | None = None,
    place: Executor = here,
    names: Names | None = None,
) -> Trial:
    """Play one trial to its end.

    The truth decides when it ends: the trial is solved when the target really moves, whatever is told of it. An error
    ends it as ``error`` with the steps played so far; an error is never scored as a failure.

    Args:
        plan: The trial to play.
        plant: A fresh plant that holds ``plan.box``.
        interventions: In the order in which they act, or their places, which all trials of a condition have alike.
        agent: The agent that decides.
        on_step: Called after every step.
        keep: Called with every picture that the record names; without it the pictures are lost.
        place: Runs the work of plant and channels.
        names: The names of its joints, if they are known already.

    Raises:
        UserMistake: If the agent cannot start at all, for example because a key is missing.
        BudgetReached: If its next call could cost more than is left.
    """
    places = interventions if isinstance(interventions, Places) else Places.of(interventions)
    names = names or Names(plan)
    loop = _Loop(plan, names, plant, places, agent, keep, place)
    error: TrialError | None = None
    ending: Ending = "budget"
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
        ending, error = "error", _error(broke, len(loop.steps) + 1)
    facts, made, fault = _facts_said(agent, plant, plan)
    if fault is not None:
        ending, error = "error", error or _error(fault, len(loop.steps) + 1)
    return _record(
        plan,
        names,
        ending,
        facts=facts,
        channels=places.channel_facts,
        interventions=places.other_facts,
        opening=loop.opening,
        steps=tuple(loop.steps),
        error=error,
        plant=made,
        opening_pictures=loop.opening_pictures,
        opening_sensed=loop.opening_sensed,
        changed=loop.changes.by_intervention,
        changed_steps=loop.changes.steps,
    )


def _facts_said(agent: Agent, plant: Plant, plan: Plan) -> tuple[dict[str, Fact], dict[str, Fact], TrialFault | None]:
    """What agent and plant say of themselves, and the fault if one breaks when it is asked."""
    facts: dict[str, Fact] = {}
    try:
        with AGENT:
            facts = facts_of(agent.facts)
        with PLANT:
            return facts, facts_of({"plant": plan.plant, **plant.facts}) if plant.facts else {}, None
    except TrialFault as fault:
        return facts, {}, fault


def broken(plan: Plan, fault: TrialFault) -> Trial:
    """The record of a trial that broke before its first step, for example because its process died."""
    return _record(plan, Names(plan), "error", error=_error(fault, 1))


def _error(fault: TrialFault, step: int) -> TrialError:
    replies, spent = (fault.replies, fault.usage) if isinstance(fault, ReplyFault) else ((), {})
    usage = Usage(**spent) if spent else None
    kept = tuple(map(without_keys, replies))
    return TrialError(boundary=fault.boundary, message=str(fault), step=step, replies=kept, usage=usage)


def _record(plan: Plan, names: Names, ending: Ending, **played: Any) -> Trial:
    """The record of a trial: what its plan says of it, and what was played."""
    nothing = {"facts": {}, "channels": (), "opening": "", "steps": ()}
    return Trial(
        key=plan.key,
        study=plan.study,
        agent=plan.agent,
        called=plan.called,
        box=plan.box.name,
        condition=plan.label,
        specs=plan.condition.specs,
        doses=plan.condition.doses,
        modality=plan.modality,
        repetition=plan.repetition,
        trial=plan.trial,
        seed=plan.seed,
        budget=plan.budget,
        joints=plan.box.names,
        labels=names.labels,
        listing=names.listing,
        target=plan.box.target,
        ending=ending,
        assessment=plan.assessment,
        hypothesis=plan.hypothesis,
        fork=plan.fork.name if plan.fork is not None else None,
        **(nothing | played),
    )


def _look(look: Look, positions: tuple[bool, ...] | None = None) -> Frame:
    """Take a picture. A failure is the plant's fault."""
    with PLANT:
        return look(positions)


class _Loop:
    """The state of one trial while it runs."""

    def __init__(
        self,
        plan: Plan,
        names: Names,
        plant: Plant,
        places: Places,
        agent: Agent,
        keep: Callable[[Picture], None] | None,
        place: Executor,
    ) -> None:
        self.steps: list[Step] = []
        self.opening = ""
        self.opening_pictures: Mapping[PictureKind, str] = {}
        self.opening_sensed: Mapping[str, Fact] = {}
        self._keep, self._at = keep, place
        self._names = names
        self._plant = plant
        self._agent = agent
        self._plan, self._places = plan, places
        self.changes = Changes(places.specs)
        self._on_record = plan.fork is not None
        self._deal_luck(plan.luck)
        self._joints = plan.box.names
        self._task, self._unsaid = names.task(plan), Briefing(hypothesis=plan.hypothesis)
        self._turns: tuple[Turn, ...] = ()
        self._moments: tuple[Moment, ...] = ()
        self._configuration: Configuration = ()
        self._source = ReportSource(plan.modality)

    def _deal_luck(self, luck: Luck) -> None:
        """Give the agent and every intervention its random stream."""
        places = self._places
        self._luck = luck.stream("agent")
        dealt = zip(places.all, places.streams, strict=True)
        acting: list[Acting[Any]] = [
            Acting(number, one, luck.stream(*stream)) for number, (one, stream) in enumerate(dealt)
        ]
        self._channels = [acting[number] for number in places.channels]
        self._showing = [acting[number] for number in places.showing]
        self._after = [acting[number] for number in places.after]
        self._prompts = [acting[number] for number in places.prompts]
        self._memories = [acting[number] for number in places.memories]
        self._actuators = [acting[number] for number in places.actuators]

    async def open(self) -> None:
        """Look at the box for the first time."""
        with PLANT:
            snapshot = await self._at(partial(self._source.sensed, self._plant.observe))
        self._configuration, self.opening_sensed = snapshot.configuration, facts_of(snapshot.sensed)
        first = await self._at(partial(self._tell, snapshot))
        self._moments = (first,)
        self.opening, self.opening_pictures = first.told.text, self._kept(first.told)

    def _attempt(self, joint: int, chosen: str, attempted: str) -> tuple[Snapshot, Moment]:
        """Attempt a joint: what really happened, and what is told of it."""
        snapshot = self._source.sensed(partial(self._plant.attempt, joint))
        return snapshot, self._tell(snapshot, chosen, attempted)

    def _tell(self, snapshot: Snapshot, chosen: str | None = None, attempted: str | None = None) -> Moment:
        was = percept = self._reported(snapshot)
        facts = None
        if percept.look is not None:
            was, percept = _unlooked(percept), replace(percept, look=partial(_look, percept.look))
        with INTERVENTIONS:
            if self._channels:
                percept = self.changes.note_report(
                    pass_through(self._channels, percept, self._perceived, self._places.shown)
                )
            for acting in self._showing:
                facts, percept = _unlooked(percept), self._perceived(acting, percept)
            if self._after:
                passed = pass_through(self._after, percept, self._perceived)
                if (passed.value.outcome, passed.value.positions) != (percept.outcome, percept.positions):
                    facts = None  # something after the words changed what is told: that holds the facts now
                percept = self.changes.note_report(passed)
        return Moment(was=was, told=_unlooked(percept), chosen=chosen, attempted=attempted, facts=facts)

    def _reported(self, snapshot: Snapshot) -> Percept:
        """What the source of the reports says, in the agent's terms; where an arm of a fork acts, the truth."""
        truth, fork = self._names.percept(snapshot), self._plan.fork
        if not self._source.named:
            return truth
        truthful = fork is not None and fork.replaces(len(self._moments))
        with PLANT:
            said = self._source.said(snapshot, truthful=truthful)
        return truth if said is snapshot else replace(self._names.percept(said), look=truth.look)

    def _perceived(self, acting: Acting[Channel], percept: Percept) -> Percept:
        made = acting.one.perceive(percept, self._moments, self._task, acting.luck.at(len(self._moments)))
        fork = self._plan.fork
        if fork is None or not fork.replaces(len(self._moments)) or any(acting.one is one for one in fork.acting):
            return made
        # the arm of the fork acts in place of this channel; what makes words and pictures goes on acting
        traits = InterventionTraits.of(acting.one)
        return made if traits.shows or traits.after_words else percept

    def _kept(self, percept: Percept) -> dict[PictureKind, str]:
        if self._keep is not None:
            for picture in percept.pictures:
                self._keep(picture)
        return {picture.kind: picture.name for picture in percept.pictures} if percept.pictures else {}

    def _situation(self) -> Situation:
        """What the agent may use now: the remembered turns, the last percept, and what it is asked."""
        turns, briefing = self._turns, self._unsaid
        if self._memories:
            with INTERVENTIONS:
                turns = self.changes.note(pass_through(self._memories, turns, self._recalled))
        if self._prompts:
            with INTERVENTIONS:
                briefing = self.changes.note(pass_through(self._prompts, briefing, self._briefed))
        return Situation(task=self._task, past=turns, percept=self._moments[-1].told, briefing=briefing)

    def _recalled(self, acting: Acting[Memory], turns: tuple[Turn, ...]) -> tuple[Turn, ...]:
        return acting.one.recall(turns, self._task, acting.luck.at(len(self.steps)))

    def _briefed(self, acting: Acting[Prompt], briefing: Briefing) -> Briefing:
        return acting.one.brief(briefing, self._moments, self._task, acting.luck.at(len(self.steps)))

    def _acted(self, acting: Acting[Actuator], joint: str) -> str:
        return acting.one.act(joint, self._moments, self._task, acting.luck.at(len(self._moments)))

    def _attempted(self, chosen: str) -> str:
        """The label of the joint that is really attempted."""
        if not self._actuators:
            return chosen
        with INTERVENTIONS:
            joint = self.changes.note(pass_through(self._actuators, chosen, self._acted))
            if joint not in self._names.labels:
                raise ChannelFault(f"{joint!r} is not a joint")
        return joint

    async def step(self) -> Step:
        """Ask the agent, attempt a joint, tell it what happened."""
        self.changes.begin()
        situation = self._situation()
        with AGENT:
            decision = await self._decision(situation)
        decision = self._usable(decision)
        label = self._attempted(decision.joint)
        joint = self._names.index(label)
        with PLANT:
            snapshot, moment = await self._at(partial(self._attempt, joint, decision.joint, label))
        step = self._written(decision, joint, snapshot, moment, situation.briefing.remark)
        self.steps.append(step)
        self.changes.end()
        told = Turn(percept=self._moments[-1].told, decision=decision, remark=situation.briefing.remark)
        self._turns, self._moments = (*self._turns, told), (*self._moments, moment)
        self._configuration = snapshot.configuration
        if self._plan.fork is not None:
            self._compare(step, self._plan.fork)
        return step

    def _decision(self, situation: Situation) -> Awaitable[Decision]:
        """Ask the agent. On a fork the past is on record: nothing is asked there whose answer costs money.

        An agent with a random stream decides again. One that draws its own luck is not asked for as long as everything
        is as on record, also after the fork.
        """
        fork, now = self._plan.fork, len(self.steps)
        played = fork is not None and self._on_record and now < len(fork.recorded)
        if fork is not None and played and AgentTraits.of(self._agent).unseeded:
            return _known(fork.recorded[now].decision)
        decision = self._agent.decide(situation, self._luck.at(now + 1))
        if type(self._agent).__module__.startswith("lockprobe"):
            return decision
        return PATIENCE.limited(decision, self._plan.agent, AgentTraits.of(self._agent).step_seconds)

    def _usable(self, decision: Decision) -> Decision:
        """The decision without API keys in its texts and without claims where nobody asked.

        Raises:
            ReplyFault: If it cannot be executed or recorded.
        """
        if (why := why_unusable(decision, self._task.joints)) is not None:
            raise ReplyFault(why, tuple(map(str, getattr(decision, "replies", ()))))
        if decision.hypothesis or decision.replies:
            hypothesis, replies = without_keys(decision.hypothesis), tuple(map(without_keys, decision.replies))
            decision = replace(decision, hypothesis=hypothesis, replies=replies, served=without_keys(decision.served))
        if not self._task.assessment:
            decision = replace(decision, claimed=None, claim_probability=None)
        return decision

    def _compare(self, step: Step, fork: Fork) -> None:
        """Compare a step of a fork with the record, and change the luck after the fork for all but the first time."""
        before = fork.recorded[step.step - 1] if self._on_record and step.step <= len(fork.recorded) else None
        self._on_record = step == before
        if step.step < fork.name.at and not self._on_record:
            raise ModelFault(f"step {step.step} cannot be replayed from the record without asking the agent again")
        if step.step == fork.name.at and fork.name.time > 1:
            self._deal_luck(replace(self._plan.luck, time=fork.name.time))

    def _written(self, decision: Decision, joint: int, snapshot: Snapshot, moment: Moment, remark: str) -> Step:
        """The record of one step."""
        told = moment.told
        return Step(
            step=len(self.steps) + 1,
            state=bits(self._configuration),
            joint=self._joints[joint],
            moved=snapshot.outcome == "moved",
            told_moved=told_moved(moment, self._moments, self._task, really=snapshot.outcome == "moved"),
            told_state=self._names.told_state(told_positions(moment)),
            told=told.text,
            decision=decision,
            sensed=facts_of(snapshot.sensed),
            pictures=self._kept(told),
            chosen=None if moment.chosen == moment.attempted else self._joints[self._names.index(decision.joint)],
            remark=remark,
        )


async def _known(decision: Decision) -> Decision:
    return decision


def _unlooked(percept: Percept) -> Percept:
    """The percept without a way to look."""
    return percept if percept.look is None else replace(percept, look=None)
