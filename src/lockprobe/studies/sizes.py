"""How large the requests of a trial are, step by step, before it is played: from a made-up trial of as many steps."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from itertools import accumulate
from math import ceil

from lockprobe.agents.llm.knowledge import ModelFacts
from lockprobe.agents.llm.settings import Settings
from lockprobe.agents.llm.size import at_most, tokens
from lockprobe.agents.prompt import conversation, reply_schema
from lockprobe.call import Usage
from lockprobe.interventions.camera import CameraChannel
from lockprobe.pictures.picture import Picture, PictureKind
from lockprobe.plan import Names, Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Decision, Moment, Percept, Situation, Turn
from lockprobe.studies.modality import shown

__all__ = ["HYPOTHESIS", "SMALLEST_CACHED", "Prompt", "Request", "made_up", "reply"]

SMALLEST_CACHED = 1024
"""Tokens below which providers keep no prefix (OpenAI's and Anthropic's guides to prompt caching; some models 2048)."""

HYPOTHESIS = "The target seems to be locked by the joint beside it, which has to be moved first."
"""As long as what models write there."""

_LONGEST_HYPOTHESIS = 4000
"""Characters; a longer one is malformed."""

_MARKS = 4
"""Tokens around a message."""

_PICTURE = 1000
"""Tokens of a picture where nothing is known of the model."""

_COUNTED = 200
"""Steps up to which each request is looked at for what it can cost at most. With more of them, and where pictures
leave the conversation, each counts as the last, which is the largest."""


@dataclass(frozen=True, slots=True)
class Request:
    """Tokens of one request: all, those that a provider can have kept, and those that it then keeps for the next."""

    input: float
    cached: float
    stored: float


class Prompt:
    """How large the requests of a trial are, step by step.

    Args:
        plan: The trial.
        settings: How the model is asked.
        facts: What is known of it.
    """

    def __init__(self, plan: Plan, settings: Settings, facts: ModelFacts) -> None:
        self._plan, self._settings, self._facts = plan, settings, facts
        self._images = settings.images
        situation = made_up(plan, reply(HYPOTHESIS))
        messages = conversation(situation)
        self._per_step = len(messages[0].pictures) * (facts.picture_tokens or _PICTURE) * _tiles(plan) / 4
        sizes = [tokens(message.text) + _MARKS for message in messages]
        form = 0.0 if settings.form(facts) == "none" else tokens(json.dumps(reply_schema(situation)))
        self._text = [form + total for total in accumulate(sizes)][::2]

    def _size(self, step: int) -> float:
        shown = min(step, self._images) if self._images else step
        return self._text[step - 1] + shown * self._per_step

    def repeated(self, step: int, longer: float = 1.0) -> float:
        """Tokens at the start of the request of a step that the one before began with.

        Args:
            step: From 1.
            longer: Factor by which a provider counts more tokens than is guessed here.
        """
        if step == 1:
            return 0.0
        if self._per_step and self._images and step > self._images:  # there an observation has lost its pictures
            return longer * self._text[step - self._images - 1]
        return longer * self._size(step - 1)

    def request(self, step: int, longer: float = 1.0) -> Request:
        """The request of a step; arguments as of :meth:`repeated`."""
        size, repeated = longer * self._size(step), self.repeated(step, longer)
        cached = repeated if repeated >= SMALLEST_CACHED else 0.0
        return Request(input=size, cached=cached, stored=size - cached if size >= SMALLEST_CACHED else 0.0)

    def first(self) -> Usage:
        """What the first call of a trial can take, whatever is replied."""
        whole = made_up(self._plan, reply(""))
        begun = replace(whole, past=(), percept=(*(turn.percept for turn in whole.past), whole.percept)[0])
        return at_most(conversation(begun), self._settings, self._facts)

    def most(self, first: int, trials: int) -> Usage:
        """What so many trials can take from a step on, whatever is replied.

        Args:
            first: The step, from 1.
            trials: How many.
        """
        longest = conversation(made_up(self._plan, reply("x" * _LONGEST_HYPOTHESIS)), images=self._images)
        steps = range(first, self._plan.budget + 1)
        if len(steps) <= _COUNTED and not self._images:
            one = sum((at_most(longest[: 2 * step - 1], self._settings, self._facts) for step in steps), Usage())
        else:
            one, trials = at_most(longest, self._settings, self._facts), trials * len(steps)
        return Usage(
            calls=one.calls * trials, input_tokens=one.input_tokens * trials, output_tokens=one.output_tokens * trials
        )


def _tiles(plan: Plan) -> int:
    """Squares of 512 pixels that cover a picture; what is known of models is of four, and larger ones are scaled."""
    size = resolve_plant(plan.plant).settings
    return 4 if size is None else min(4, ceil(size.width / 512) * ceil(size.height / 512))


def _head(plan: Plan) -> bytes:
    """The start of the file of a picture of a plant, where its size stands."""
    size = resolve_plant(plan.plant).settings
    sides = (1, 1) if size is None else (size.width, size.height)
    return b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + b"".join(side.to_bytes(4, "big") for side in sides)


def reply(hypothesis: str) -> str:
    """A reply as models give it.

    Args:
        hypothesis: What it says about the box.
    """
    return json.dumps({"last_action": "did not move", "hypothesis": hypothesis, "joint": "A"})


def made_up(plan: Plan, said: str) -> Situation:
    """The last step of a made-up trial in which joints are attempted in turn, and every other moves.

    Args:
        plan: The trial.
        said: The agent's reply in every step.
    """
    task = Names(plan).task(plan)
    percepts = [_percept(plan, task.joints, step) for step in range(plan.budget)]
    turns = (Turn(percept=percept, decision=Decision(joint="A", replies=(said,))) for percept in percepts[:-1])
    return Situation(task=task, past=tuple(turns), percept=percepts[-1])


def _percept(plan: Plan, joints: tuple[str, ...], step: int) -> Percept:
    joint = joints[step % len(joints)] if step else None
    channel = shown(plan.modality)
    if isinstance(channel, CameraChannel):
        kinds: tuple[PictureKind, ...] = ("rgb",) if channel.depth == "none" else ("rgb", "depth")
        pictures = tuple(Picture(kind=kind, png=_head(plan)) for kind in kinds)
        return Percept(joint=joint, text=f"You attempted {joint}. The picture shows the box now.", pictures=pictures)
    positions = (
        tuple((place + step) % 2 == 0 for place in range(len(joints))) if plan.condition.tells_positions else None
    )
    told = Percept(joint=joint, outcome="moved" if step % 2 else "blocked" if step else None, positions=positions)
    past = (Moment(was=told, told=told),) if step else ()
    return channel.perceive(told, past, Names(plan).task(plan), plan.stream("estimate"))
