"""Size estimates of each request of a trial before it is played, from a made-up trial."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise, takewhile
from math import ceil
from typing import TYPE_CHECKING, ClassVar

from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.llm.token_bounds import at_most, tokens
from lockprobe.agents.prompt import Message, conversation, reply_schema
from lockprobe.agents.reply_values import LONGEST_HYPOTHESIS
from lockprobe.boxes.box import Lockbox, bits
from lockprobe.foundation.errors import ChannelFault
from lockprobe.interventions.camera import CameraChannel
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for
from lockprobe.trial.loop import play
from lockprobe.trial.model_call import Usage
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Intervention, InterventionTraits, Prompt
from lockprobe.trial.record import Decision, Fact, Moment, Outcome, Percept, Situation, Snapshot, Task
from lockprobe.trial.source import CAMERA, VERDICT

if TYPE_CHECKING:
    import numpy as np

SMALLEST_CACHED = 1024
"""Tokens below which providers keep no prefix (OpenAI's and Anthropic's guides to prompt caching; some models 2048)."""

HYPOTHESIS = "The target seems to be locked by the joint beside it, which has to be moved first."
"""A hypothesis of typical length."""

_MARKS = 4
"""Tokens around a message."""

_PICTURE = 1000
"""Assumed tokens of a picture for an unknown model."""

_COUNTED = 200
"""Steps up to which each request is looked at for what it can cost at most. With more of them, and where pictures
leave the conversation, each counts as the last, which is the largest."""


@dataclass(frozen=True, slots=True)
class Request:
    """Tokens of one request: total input, tokens from the provider's cache, and tokens that it then stores."""

    input: float
    cached: float
    stored: float


class PromptSizes:
    """The sizes of the requests of a trial, step by step.

    Attributes:
        output: Tokens of a reply in the requested form.
    """

    def __init__(self, plan: Plan, settings: ModelSettings, facts: ModelFacts) -> None:
        self._plan, self._settings, self._facts = plan, settings, facts
        self._images = settings.images
        course = made_up_steps(plan)
        talks = [conversation(situation) for situation in (course if _forgets(course) else course[-1:])]
        self._per_step = len(talks[0][0].pictures) * (facts.picture_tokens or _PICTURE) * _tiles(plan) / 4
        form = 0.0 if settings.form(facts) == "none" else tokens(json.dumps(reply_schema(course[-1])))
        self._observed = [len(situation.past) + 1 for situation in course]
        self._shared: list[float] = []
        if _forgets(course):
            self._text = [form + sum(map(_size, talk)) for talk in talks]
            self._shared = [form + self._start(*both) for both in pairwise(talks)]
        else:
            self._text = [form + total for total in accumulate(map(_size, talks[0]))][::2]
        self.output = tokens(_reply_in(course[-1], HYPOTHESIS))

    def _start(self, one: Sequence[Message], other: Sequence[Message]) -> float:
        """Tokens of the common prefix of two requests."""
        alike = sum(1 for _ in takewhile(lambda both: both[0] == both[1], zip(one, other, strict=False)))
        pictured = sum(bool(message.pictures) for message in other[:alike])
        ends = (talk[alike].text if alike < len(talk) else "" for talk in (one, other))
        begun = "".join(first for first, _ in takewhile(lambda both: both[0] == both[1], zip(*ends, strict=False)))
        return sum(map(_size, other[:alike])) + pictured * self._per_step + tokens(begun)

    def _size(self, step: int) -> float:
        observed = self._observed[step - 1]
        shown = min(observed, self._images) if self._images else observed
        return self._text[step - 1] + shown * self._per_step

    def repeated(self, step: int, longer: float = 1.0) -> float:
        """Tokens of the common prefix of a step's request and the request before, times ``longer``."""
        if step == 1:
            return 0.0
        if self._shared:
            return longer * self._shared[step - 2]
        if self._per_step and self._images and step > self._images:  # there an observation has lost its pictures
            return longer * self._text[step - self._images - 1]
        return longer * self._size(step - 1)

    def request(self, step: int, longer: float = 1.0) -> Request:
        """The request of a step; arguments as for :meth:`repeated`."""
        size, repeated = longer * self._size(step), self.repeated(step, longer)
        cached = repeated if repeated >= SMALLEST_CACHED else 0.0
        return Request(input=size, cached=cached, stored=size - cached if size >= SMALLEST_CACHED else 0.0)

    def most(self, first: int, trials: int) -> Usage:
        """Upper bound of the usage of this many trials from step ``first`` (from 1) on, whatever the replies."""
        longest = conversation(_longest(self._plan), images=self._images)
        steps = range(first, self._plan.budget + 1)
        if len(steps) <= _COUNTED and not self._images:
            one = sum((at_most(longest[: 2 * step - 1], self._settings, self._facts) for step in steps), Usage())
        else:
            one, trials = at_most(longest, self._settings, self._facts), trials * len(steps)
        return Usage(
            calls=one.calls * trials, input_tokens=one.input_tokens * trials, output_tokens=one.output_tokens * trials
        )


def _tiles(plan: Plan) -> int:
    """Tiles of 512 x 512 pixels that cover a picture. Models' known token counts are for four tiles, hence scaling."""
    width, height = resolve_plant(plan.plant).picture_size or (1024, 1024)
    return min(4, ceil(width / 512) * ceil(height / 512))


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

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
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

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
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


def _forgets(course: Sequence[Situation]) -> bool:
    """Whether later requests lack parts of earlier ones."""
    return any(len(situation.past) < step for step, situation in enumerate(course))


def _size(message: Message) -> float:
    return tokens(message.text) + _MARKS
