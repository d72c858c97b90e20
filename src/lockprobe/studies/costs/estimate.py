"""The price of the trials that a study still owes, before any request is made.

A trial of each condition goes through the loop of all trials, with an agent that replies as much as most models do and
counts what a model would be sent. How many steps trials take is not known in advance: at the least as many as those of
a random agent, computed exactly; at the most all.
"""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from math import ceil
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.llm.model_facts import Price
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.prompt import conversation, reply_schema
from lockprobe.agents.reply import asked_for
from lockprobe.boxes.box import bits
from lockprobe.boxes.solve import random_curve
from lockprobe.foundation.errors import ChannelFault
from lockprobe.interventions.modality import interventions_for, is_pictured
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.costs.spending import agent_price, hosted
from lockprobe.studies.decisions import owed_by_look
from lockprobe.studies.records.store import OnRecord
from lockprobe.studies.study import Study
from lockprobe.trial.loop import play
from lockprobe.trial.model_call import Usage
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Decision, Fact, Situation, Snapshot
from lockprobe.trial.source import CAMERA, VERDICT

if TYPE_CHECKING:
    from numpy.random import Generator

Array = NDArray[np.float64]

REPLY = {
    "last_action": "did not move",
    "hypothesis": "The target seems to be locked by the joint beside it, which has to be moved first.",
    "joint": "A",
}
"""A reply of typical length, by what a model is asked for."""

CHARACTERS_A_TOKEN = 3.1
"""Characters per token of our conversations: 9833 in 3179 tokens of SmolLM2-135M's tokenizer (instruction, schema, and
observations and replies of six trials of ``human-inspired`` at p = 0.2). It is 2.0 in observations, 3.2 in replies and
3.8 in the instruction; vocabularies larger than its 49 152 need fewer tokens."""

_MARKS = 4
"""Tokens around a message."""

_PICTURE = 1000
"""Assumed tokens of a picture for an unknown model; known counts are for four tiles of 512 x 512 pixels."""

_REASONING = 1000
"""Assumed tokens of reasoning before a reply; models differ by more than tenfold."""


def tokens(text: str) -> float:
    """The approximate number of tokens of a text; see :data:`CHARACTERS_A_TOKEN`."""
    return len(text) / CHARACTERS_A_TOKEN


@dataclass(frozen=True, slots=True)
class Estimate:
    """The estimated cost of the trials that one agent owes.

    Attributes:
        agent: Agent spec.
        called: What the study calls the agent.
        trials: Trials owed.
        low: Usage if trials take as many steps as those of a random agent.
        high: Usage if no trial is solved within its budget of steps.
        price: The provider's price; None if it is not known.
        until: Whether the study can stop before all of them are played.
    """

    agent: str
    called: str
    trials: int
    low: Usage
    high: Usage
    price: Price | None
    until: bool = False

    def dollars(self) -> tuple[float, float] | None:
        """The cost from low to high in US dollars, if the provider keeps no prefix; None if the price is not known."""
        return None if self.price is None else (self.price.of(self.low), self.price.of(self.high))

    def facts(self) -> dict[str, object]:
        """All of it, for JSON."""
        return asdict(self) | {"dollars": self.dollars()}


def estimates(study: Study, done: Mapping[str, OnRecord]) -> list[Estimate]:
    """The estimated cost of the owed trials of every hosted agent; agents that owe nothing are left out.

    A trial that was begun counts as a whole one; ``done`` are the recorded trials, by key.
    """
    found = []
    solved = np.mean([random_curve(box, study.max_steps) for box in study.boxes], axis=0)
    for agent in hosted(study):
        if study.until is None:
            plans = [plan for plan in study.plans(agent) if plan.key not in done or done[plan.key].owed_again]
        else:
            plans = [plan for owed in owed_by_look(study, agent, done.values()) for plan in owed]
        if not plans:
            continue
        model, low, high = Model.parse(agent), np.zeros(3), np.zeros(3)
        for condition, trials in Counter(plan.condition for plan in plans).items():
            sizes = request_sizes(study.plan(agent, condition, 1, 1), model)
            low += trials * sizes @ (1 - solved[:-1])
            high += trials * sizes.sum(axis=1)
        least, most = (
            Usage(calls=calls, input_tokens=read, output_tokens=wrote)
            for calls, read, wrote in np.round([low, high]).astype(int).tolist()
        )
        found.append(
            Estimate(agent, study.label_of(agent), len(plans), least, most, agent_price(agent), study.until is not None)
        )
    return found


def request_sizes(plan: Plan, model: Model) -> Array:
    """Calls, tokens of the request and tokens of the reply in each step of a trial; shape (3, budget)."""
    width, height = resolve_plant(plan.plant).picture_size or (1024, 1024)
    tiles = min(4, ceil(width / 512) * ceil(height / 512))
    agent = _CountingAgent(model, (model.facts.picture_tokens or _PICTURE) * tiles / 4)
    acting = interventions_for(plan.condition)
    trial = asyncio.run(play(plan, plant=partial(_LockedPlant, plan), interventions=acting, agent=agent))
    if trial.error is not None:
        raise ChannelFault(trial.error.message)
    reasons = model.facts.reasons or model.settings.effort not in (None, "none")
    written = agent.written + (_REASONING if reasons else 0)
    written = min(written, model.settings.max_tokens or written)
    return np.array([np.ones(plan.budget), agent.sent, np.full(plan.budget, written)])


class _CountingAgent:
    """It attempts the other joints than the target in turn, and counts the tokens that a model would be sent."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, model: Model, picture: float) -> None:
        self.sent, self.written = list[float](), 0.0
        self._model, self._picture = model, picture

    async def decide(self, situation: Situation, rng: Generator) -> Decision:
        form = reply_schema(asked_for(situation))
        asked = form["properties"]
        assert isinstance(asked, dict)
        reply = json.dumps({key: REPLY[key] for key in asked})
        self.written = tokens(reply)
        talk = conversation(situation, images=self._model.settings.images)
        text = sum(tokens(one.text) + _MARKS + self._picture * len(one.pictures) for one in talk)
        self.sent.append(text + (0.0 if self._model.settings.schema == "none" else tokens(json.dumps(form))))
        joints = [joint for joint in situation.task.joints if joint != situation.task.target]
        return Decision(joint=joints[len(self.sent) % len(joints)], replies=(reply,))


class _LockedPlant(SymbolicPlant):
    """The rules of a box whose target never moves, so that the trial goes on, with pictures that show nothing.

    A robot's verdict and a camera's reading are right.
    """

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan.box)
        self._pictured, camera = is_pictured(plan.modality), Camera(width=1, height=1, focal=1, panel=np.eye(4))
        self._blank = Frame(
            rgb=np.zeros((1, 1, 3), np.uint8),
            depth=np.ones((1, 1), np.float32),
            camera=camera,
            handles=np.ones((len(plan.box.joints), 2, 3)),
            renderer="",
        )

    def observe(self) -> Snapshot:
        return self._sensed(super().observe())

    def attempt(self, joint: int) -> Snapshot:
        if joint == self._box.target_index:
            return self._sensed(replace(super().observe(), joint=joint, outcome="blocked"))
        return self._sensed(super().attempt(joint))

    def _sensed(self, truth: Snapshot) -> Snapshot:
        sensed = {CAMERA: bits(truth.configuration), VERDICT: truth.outcome}
        look = (lambda: self._blank) if self._pictured else None
        return replace(truth, sensed=sensed, look=look, render=lambda _: self._blank)
