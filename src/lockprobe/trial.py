"""The closed loop: the only place where plant, channels and agent meet (paper, Sec. 2.2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, is_dataclass, replace
from functools import partial
from typing import Protocol, TypeVar

from lockprobe.call import Usage
from lockprobe.errors import (
    ChannelFault,
    LockprobeError,
    ModelFault,
    PlantFault,
    ReplyFault,
    TrialFault,
    without_keys,
)
from lockprobe.lockbox.box import Configuration, bits
from lockprobe.pictures.frame import Frame
from lockprobe.pictures.picture import Picture, PictureKind
from lockprobe.plan import Names, Plan
from lockprobe.record import Decision, Ending, Fact, Percept, Situation, Snapshot, Step, Trial, TrialError, Turn
from lockprobe.seams import Agent, Channel, Plant

__all__ = ["Place", "broken", "here", "play"]

_T = TypeVar("_T")


class Place(Protocol):
    """Where a plant acts and is looked at; calls of its may block."""

    async def __call__(self, work: Callable[[], _T], /) -> _T:
        """Have it done there, and return what it returns."""
        ...


async def here(work: Callable[[], _T], /) -> _T:
    """In the thread of whoever asks."""
    return work()


@contextmanager
def _boundary(fault: type[TrialFault]) -> Iterator[None]:
    """Attributes whatever breaks inside to one boundary. A user's mistake passes."""
    try:
        yield
    except LockprobeError:
        raise
    except Exception as error:
        raise fault(f"{type(error).__name__}: {error}") from error


async def play(
    plan: Plan,
    *,
    plant: Plant,
    channels: Sequence[Channel],
    agent: Agent,
    on_step: Callable[[Step], None] | None = None,
    keep: Callable[[Picture], None] | None = None,
    place: Place = here,
) -> Trial:
    """Play one trial to its end.

    The end is decided by the truth: the trial is solved when the target really moves, whatever is told of it.
    What breaks ends it as ``error`` with the steps played so far; it is never scored as a failure.

    Args:
        plan: What is to be played.
        plant: A fresh plant that holds ``plan.box``.
        channels: In the order in which they act.
        agent: Who decides.
        on_step: Called after every step.
        keep: Called with every picture that the record will name; without it they are lost.
        place: Where plant and channels do their work.

    Raises:
        UserMistake: If the agent cannot be had at all, for example for want of a key.
        BudgetReached: If its next call could cost more than is left.
    """
    names = Names(plan)
    loop = _Loop(plan, names, plant, channels, agent, keep, place)
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
    except TrialFault as fault:
        ending, error = "error", _error(fault, len(loop.steps) + 1)
    return replace(
        _blank(plan, names, ending),
        facts=_facts(agent.facts),
        channels=tuple(_facts_of(channel) for channel in channels),
        opening=loop.opening,
        steps=tuple(loop.steps),
        error=error,
        plant=_facts({"plant": plan.plant, **plant.facts}) if plant.facts else {},
        opening_pictures=loop.opening_pictures,
    )


def broken(plan: Plan, fault: TrialFault) -> Trial:
    """The record of a trial that broke before anything could be written down, for example with its process."""
    return replace(_blank(plan, Names(plan), "error"), error=_error(fault, 1))


def _error(fault: TrialFault, step: int) -> TrialError:
    replies, spent = (fault.replies, fault.usage) if isinstance(fault, ReplyFault) else ((), {})
    usage = Usage(**spent) if spent else None
    kept = tuple(map(without_keys, replies))
    return TrialError(boundary=fault.boundary, message=str(fault), step=step, replies=kept, usage=usage)


def _blank(plan: Plan, names: Names, ending: Ending) -> Trial:
    return Trial(
        key=plan.key,
        study=plan.study,
        agent=plan.agent,
        facts={},
        box=plan.box.name,
        modality=plan.modality,
        p=plan.p,
        flip=plan.flip,
        channels=(),
        repetition=plan.repetition,
        trial=plan.trial,
        seed=plan.seed,
        budget=plan.budget,
        joints=plan.box.names,
        labels=names.labels,
        listing=names.listing,
        target=plan.box.target,
        opening="",
        steps=(),
        ending=ending,
        assessment=plan.assessment,
    )


def _facts(facts: Mapping[str, object]) -> dict[str, Fact]:
    return {str(name): _fact(value) for name, value in facts.items()}


def _fact(value: object) -> Fact:
    plain = value is None or isinstance(value, str | int | bool) or (isinstance(value, float) and math.isfinite(value))
    return value if plain else str(value)  # type: ignore[return-value]


def _look(look: Callable[[], Frame]) -> Frame:
    """A picture that cannot be taken is the plant's fault, whoever asked for it."""
    with _boundary(PlantFault):
        return look()


def _why_unusable(decision: Decision, labels: Sequence[str]) -> str | None:
    """What keeps a decision from being acted on and written down; agents come from anyone."""
    if not isinstance(decision, Decision):
        return f"{type(decision).__name__} is no Decision"
    if decision.joint not in labels:
        return f"{decision.joint!r} is no joint"
    if decision.claimed not in ("moved", "blocked", None):
        return f"claimed {decision.claimed!r} is none of moved, blocked, None"
    numbers = (*(decision.probabilities or ()), decision.claim_probability or 0.0)
    if not all(isinstance(number, float | int) and 0 <= number <= 1 for number in numbers):
        return "a probability lies outside 0 to 1"
    try:
        "".join((decision.hypothesis, decision.served, *decision.replies)).encode("utf-8")
    except (UnicodeEncodeError, TypeError) as error:
        return f"its text cannot be written ({error})"
    return None


def _without_keys(decision: Decision) -> Decision:
    """What an agent says is kept as it is, but for the keys of whoever runs it."""
    if not decision.hypothesis and not decision.replies:
        return decision
    hypothesis, replies = without_keys(decision.hypothesis), tuple(map(without_keys, decision.replies))
    return replace(decision, hypothesis=hypothesis, replies=replies, served=without_keys(decision.served))


def _facts_of(channel: Channel) -> dict[str, Fact]:
    """A channel is its own specification: its class and its fields."""
    settings: dict[str, Fact] = asdict(channel) if is_dataclass(channel) and not isinstance(channel, type) else {}
    return {"channel": type(channel).__name__} | settings


class _Loop:
    """The state of one trial while it runs."""

    def __init__(
        self,
        plan: Plan,
        names: Names,
        plant: Plant,
        channels: Sequence[Channel],
        agent: Agent,
        keep: Callable[[Picture], None] | None,
        place: Place,
    ) -> None:
        self.steps: list[Step] = []
        self.opening = ""
        self.opening_pictures: Mapping[PictureKind, str] = {}
        self._keep, self._at = keep, place
        self._names = names
        self._plant = plant
        self._agent = agent
        self._channels = [(channel, plan.stream(f"channel-{i}")) for i, channel in enumerate(channels)]
        self._rng = plan.stream("agent")
        self._joints = plan.box.names
        self._task = names.task(plan)
        self._past: tuple[Turn, ...] = ()
        self._percept: Percept | None = None
        self._configuration: Configuration = ()

    async def open(self) -> None:
        """Look at the box for the first time."""
        with _boundary(PlantFault):
            snapshot = await self._at(self._plant.observe)
        self._configuration = snapshot.configuration
        self._percept = await self._at(partial(self._tell, snapshot))
        self.opening, self.opening_pictures = self._percept.text, self._kept(self._percept)

    def _tell(self, snapshot: Snapshot) -> Percept:
        percept = self._names.percept(snapshot)
        if percept.look is not None:
            percept = replace(percept, look=partial(_look, percept.look))
        with _boundary(ChannelFault):
            for channel, rng in self._channels:
                percept = channel.perceive(percept, self._percept, self._task, rng)
        return replace(percept, look=None)

    def _kept(self, percept: Percept) -> dict[PictureKind, str]:
        if self._keep is not None:
            for picture in percept.pictures:
                self._keep(picture)
        return {picture.kind: picture.name for picture in percept.pictures}

    async def step(self) -> Step:
        """Ask the agent, attempt its joint, tell it what happened."""
        assert self._percept is not None
        with _boundary(ModelFault):
            decision = await self._agent.decide(
                Situation(task=self._task, past=self._past, percept=self._percept), self._rng
            )
        if (why := _why_unusable(decision, self._names.labels)) is not None:
            raise ReplyFault(why, tuple(map(str, getattr(decision, "replies", ()))))
        decision = _without_keys(decision)
        if not self._task.assessment:
            decision = replace(decision, claimed=None, claim_probability=None)  # nobody asked
        joint = self._names.index(decision.joint)
        with _boundary(PlantFault):
            snapshot = await self._at(partial(self._plant.attempt, joint))
        told = await self._at(partial(self._tell, snapshot))
        step = Step(
            step=len(self.steps) + 1,
            state=bits(self._configuration),
            joint=self._joints[joint],
            moved=snapshot.outcome == "moved",
            told_moved=(snapshot if told.pictures else told).outcome == "moved",
            told_state=self._names.told_state(told),
            told=told.text,
            decision=decision,
            sensed=_facts(snapshot.sensed),
            pictures=self._kept(told),
        )
        self.steps.append(step)
        self._past = (*self._past, Turn(percept=self._percept, decision=decision))
        self._percept, self._configuration = told, snapshot.configuration
        return step
