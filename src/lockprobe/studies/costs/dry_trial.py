"""The requests of a trial before it is played: a made-up trial goes through the loop of all trials, and is counted.

It is played twice: as an agent replies that says as much as most do, and as the longest that can be sent.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from math import ceil
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.llm.token_bounds import at_most, tokens
from lockprobe.agents.prompt import Message, conversation, reply_schema
from lockprobe.agents.reply import LONGEST_HYPOTHESIS
from lockprobe.boxes.box import Lockbox, bits
from lockprobe.foundation.errors import ChannelFault
from lockprobe.interventions.camera import CameraChannel
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Intervention, InterventionTraits, Prompt
from lockprobe.trial.record import Decision, Fact, Moment, Outcome, Percept, Situation, Snapshot, Task
from lockprobe.trial.source import CAMERA, VERDICT

if TYPE_CHECKING:
    from numpy.random import Generator

Array = NDArray[np.float64]

HYPOTHESIS = "The target seems to be locked by the joint beside it, which has to be moved first."
"""A hypothesis of typical length."""

_MARKS = 4
"""Tokens around a message."""

_PICTURE = 1000
"""Assumed tokens of a picture for an unknown model."""

_COUNTED = 50
"""Requests that are counted. Of a longer trial they are spread evenly, and the others lie between them."""


@dataclass(frozen=True, slots=True, eq=False)
class DryTrial:
    """The requests of a made-up trial. Every column has the shape (budget,), a value for each step.

    Attributes:
        input: Tokens of each request.
        repeated: Those of them that repeat the start of the request before.
        output: Tokens of a reply in the requested form.
        most_input: Upper bound of the tokens of each request, whatever the replies.
        most_output: Upper bound of the tokens of each reply.
    """

    input: Array
    repeated: Array
    output: float
    most_input: Array
    most_output: Array

    @classmethod
    def of(cls, plan: Plan, model: Model) -> DryTrial:
        """Count the requests of a plan."""
        course, last = made_up_steps(plan), _longest(plan)
        size = _Size(_picture_tokens(plan, model.facts))
        form = 0.0 if model.form == "none" else tokens(json.dumps(reply_schema(course[-1])))
        steps = np.unique(np.linspace(1, plan.budget, _COUNTED).round()).astype(int)
        sent, repeated, most = list[float](), list[float](), list[tuple[int, int]]()
        for step in steps:
            now = conversation(course[step - 1], images=model.settings.images)
            sent.append(form + size.of(now))
            before = conversation(course[step - 2], images=model.settings.images) if step > 1 else None
            repeated.append(0.0 if before is None else form + size.of_start(before, now))
            bound = at_most(conversation(_up_to(last, step), images=model.settings.images), model)
            most.append((bound.input_tokens, bound.output_tokens))
        every = np.arange(1, plan.budget + 1)
        above = np.array(most, dtype=np.float64)[np.searchsorted(steps, every)]  # requests grow from step to step
        return cls(
            input=np.interp(every, steps, sent),
            repeated=np.interp(every, steps, repeated),
            output=tokens(_reply_in(course[-1], HYPOTHESIS)),
            most_input=above[:, 0],
            most_output=above[:, 1],
        )


class _Size:
    """Approximate tokens of messages, with so many for a picture."""

    def __init__(self, picture: float) -> None:
        self._picture = picture

    def of(self, talk: Sequence[Message]) -> float:
        return sum(tokens(one.text) + _MARKS + self._picture * len(one.pictures) for one in talk)

    def of_start(self, one: Sequence[Message], other: Sequence[Message]) -> float:
        """Tokens of what two requests have in common from their beginning."""
        alike = sum(1 for _ in takewhile(lambda both: both[0] == both[1], zip(one, other, strict=False)))
        ends = (talk[alike].text if alike < len(talk) else "" for talk in (one, other))
        begun = sum(1 for _ in takewhile(lambda both: both[0] == both[1], zip(*ends, strict=False)))
        return self.of(other[:alike]) + tokens("x" * begun)


def _picture_tokens(plan: Plan, facts: ModelFacts) -> float:
    """Tokens of a picture of this plant; models' known counts are for four tiles of 512 x 512 pixels."""
    width, height = resolve_plant(plan.plant).picture_size or (1024, 1024)
    return (facts.picture_tokens or _PICTURE) * min(4, ceil(width / 512) * ceil(height / 512)) / 4


def _head(plan: Plan) -> bytes:
    """The header of a plant's picture file, which holds the size."""
    sides = resolve_plant(plan.plant).picture_size or (1, 1)
    return b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + b"".join(side.to_bytes(4, "big") for side in sides)


_SAID: Mapping[str, object] = {"last_action": "did not move", "joint": "A"}
"""The values of a made-up reply by key, except its hypothesis."""


def reply(hypothesis: str, asked: Iterable[str] = ("last_action", "hypothesis", "joint")) -> str:
    """A typical reply with the requested keys, in their order."""
    return json.dumps({key: hypothesis if key == "hypothesis" else _SAID[key] for key in asked})


def _reply_in(situation: Situation, hypothesis: str) -> str:
    """A typical reply in the requested form."""
    form = reply_schema(situation)["properties"]
    assert isinstance(form, dict)
    return reply(hypothesis, form)


def made_up_steps(plan: Plan, said: str = "") -> list[Situation]:
    """The situations of a made-up trial in which joints are attempted in turn, and every second attempt moves.

    The loop of all trials plays it, with the interventions of its condition. ``said`` is the agent's reply in every
    step; if empty, it is a typical reply in the requested form.
    """
    return _played(plan, interventions_for(plan.condition), said)


def _played(plan: Plan, interventions: Sequence[Intervention], said: str) -> list[Situation]:
    agent = _MadeUpAgent(said)
    shown = [_Placeholder(one, _head(plan)) if isinstance(one, CameraChannel) else one for one in interventions]
    loop = play(replace(plan, fork=None), plant=_MadeUpPlant(plan.box), interventions=shown, agent=agent)
    try:
        loop.send(None)  # nothing in it waits
    except StopIteration as end:
        if end.value.error is not None:
            raise ChannelFault(end.value.error.message) from None
    return agent.course


class _MadeUpAgent:
    """It attempts the other joints than the target in turn, and keeps the situations in which it is asked."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, said: str) -> None:
        self.course: list[Situation] = []
        self._said = said

    async def decide(self, situation: Situation, rng: Generator) -> Decision:
        self.course.append(situation)
        joints = [joint for joint in situation.task.joints if joint != situation.task.target]
        reply = self._said or _reply_in(situation, HYPOTHESIS)
        return Decision(joint=joints[len(self.course) % len(joints)], replies=(reply,))


class _MadeUpPlant:
    """A box on which every second attempt moves its joint, but never the target, so that the trial goes on.

    A robot's verdict and a camera's reading are right.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, box: Lockbox) -> None:
        self._now, self._target, self._attempts = box.initial, box.target_index, 0

    def observe(self) -> Snapshot:
        return Snapshot(configuration=self._now, sensed={CAMERA: bits(self._now)})

    def attempt(self, joint: int) -> Snapshot:
        self._attempts += 1
        moves = self._attempts % 2 == 1 and joint != self._target
        self._now = tuple(at ^ (i == joint and moves) for i, at in enumerate(self._now))
        outcome: Outcome = "moved" if moves else "blocked"
        sensed = {CAMERA: bits(self._now), VERDICT: outcome}
        return Snapshot(configuration=self._now, joint=joint, outcome=outcome, sensed=sensed)

    def close(self) -> None:
        """Nothing is open."""


@dataclass(frozen=True)
class _Placeholder:
    """A camera whose pictures have the right size and show nothing; there is none where no positions are told."""

    camera: CameraChannel
    head: bytes
    shows: ClassVar[bool] = True

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: Generator) -> Percept:
        if percept.positions is None:
            return replace(percept, outcome=None, text="")
        kinds: tuple[PictureKind, ...] = ("rgb",) if self.camera.depth == "none" else ("rgb", "depth")
        pictures = tuple(Picture(kind=kind, png=self.head) for kind in kinds)
        return Percept(joint=percept.joint, text=self.camera.caption(percept.joint), pictures=pictures)


def _longest(plan: Plan) -> Situation:
    """The last situation of the longest possible trial: every remark is made, no report or turn is left out."""
    said = reply("x" * LONGEST_HYPOTHESIS)
    interventions = [
        replace(one, p=1.0) if InterventionTraits.of(one).doses[:1] == ("p",) else one  # type: ignore[type-var]
        for one in interventions_for(plan.condition)
        if isinstance(one, Prompt) or (traits := InterventionTraits.of(one)).shows or traits.after_words
    ]
    course = _played(plan, interventions, said)
    last = course[-1]
    remark = max((situation.briefing.remark for situation in course), key=len)
    past = tuple(replace(turn, remark=remark if i else turn.remark) for i, turn in enumerate(last.past))
    return replace(last, past=past, briefing=replace(last.briefing, remark=remark))


def _up_to(last: Situation, step: int) -> Situation:
    """The situation of an earlier step of a trial in which nothing is forgotten."""
    if step > len(last.past):
        return last
    return replace(last, past=last.past[: step - 1], percept=last.past[step - 1].percept)
