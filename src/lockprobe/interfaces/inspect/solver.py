"""Plays a trial inside an Inspect eval: the usual closed loop, with the eval's model as the agent.

The model gets the same requests as from :mod:`lockprobe.agents.llm.model`, and a trial has the same seeds, labels,
flips and key as in ``lockprobe run``. The conversation goes into the messages of the sample, and the truth of every
step into its transcript, which the model never sees. A fault of provider or plant is an error of the sample, which
Inspect retries or reports. A refusal, or a reply that stays unusable, is the model's and ends the trial as ``error``.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from lockprobe.agents.llm.answer import reasoned_in, refuse_overflow, said_in, usage_of
from lockprobe.agents.llm.client import ModelReply, sent
from lockprobe.agents.llm.inspect_internals import active_generate_config
from lockprobe.agents.llm.model import decided, model_facts
from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.openai_answers import check_answers
from lockprobe.agents.llm.retry import Declined, Judgement, Tries, with_retries
from lockprobe.agents.llm.settings import ModelSettings, read_settings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import Message, spoken
from lockprobe.foundation.errors import FINAL, ChannelFault, ModelFault, PlantFault, TrialFault, needing
from lockprobe.foundation.redaction import without_keys
from lockprobe.foundation.spec import Spec
from lockprobe.interfaces.inspect.conversation import last_report
from lockprobe.interfaces.inspect.sample_pictures import beside
from lockprobe.interfaces.inspect.scoring import TRIAL, step_as_markdown, step_metadata
from lockprobe.trial.record import Decision, Fact, Situation, Step, Trial
from lockprobe.trial.trial_json import trial_to_json

with needing("Inspect tasks", "providers"):
    from inspect_ai.log import transcript
    from inspect_ai.model import ChatMessage, GenerateConfig, Model, ModelOutput, ResponseSchema, get_model
    from inspect_ai.solver import Generate, Solver, TaskState, solver
    from inspect_ai.util import JSONSchema

__all__ = ["agent_spec", "play_trial"]

_OURS = {"temperature": "temperature", "top_p": "top_p", "effort": "reasoning_effort", "max_tokens": "max_tokens"}
"""Settings with an option in Inspect, and their names in its configuration."""

_TRANSPORT = frozenset(
    {"max_retries", "timeout", "attempt_timeout", "stream_idle_timeout", "max_connections", "adaptive_connections"}
    | {"batch", "cache", "cache_prompt", "reasoning_summary", "response_schema", "modalities"}
)
"""Options that change the transport or the stored answer, but not the request."""

_ASKING: ContextVar[bool] = ContextVar("asking", default=False)
"""Whether a request under way is ours; the eval's model may serve other tasks too."""

_FAULTS: dict[str, type[TrialFault]] = {fault.boundary: fault for fault in (ModelFault, PlantFault, ChannelFault)}
"""The exception for the error of a sample, by boundary."""


def agent_spec(model: str, settings: Mapping[str, object], config: GenerateConfig) -> str:
    """The spec of an eval's model, as for ``lockprobe run --agent``.

    ``settings`` holds the options that Inspect lacks, by name, None for the default; ``config`` holds the others.

    Raises:
        BadValue: If an option has an invalid value, or one that this model is known to refuse.
    """
    given = dict(settings) | {ours: getattr(config, theirs) for ours, theirs in _OURS.items()}
    named = {
        field.name: f"{value:g}" if isinstance(value, float) else str(value)
        for field in fields(ModelSettings)
        if (value := given.get(field.name)) not in (None, field.default)
    }
    spec = str(Spec("llm", model, named))
    read_settings(spec)
    return spec


@solver
def play_trial(settings: dict[str, Any], options: dict[str, Any] | None = None) -> Solver:
    """Play the trial that a sample's metadata names.

    Args:
        settings: Settings of the study from JSON; the eval's model is its only agent.
        options: Options of :func:`agent_spec`.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        from lockprobe.studies.options.settings import study_from
        from lockprobe.studies.records.picture_store import Album
        from lockprobe.studies.running.trial_setup import play_timed

        model = get_model()
        config = active_generate_config().merge(model.config)
        spec = agent_spec(str(model), options or {}, config)
        study = study_from({**settings, "agents": [spec]}, Path(str(state.sample_id)))
        place = state.metadata
        repetition = place["repetition"] + (state.epoch - 1) * study.repetitions
        plan = study.plan(spec, study.labelled(place["label"]), repetition, place["trial"])
        player = _ModelOfTheEval(model, spec, config, state)
        with TemporaryDirectory(prefix="lockprobe-") as pictures:
            trial, _ = await play_timed(plan, player, player.note, Album(pictures).keep)
            _finish(state, trial, Path(pictures))
        if trial.error is not None and trial.error.boundary not in FINAL:
            raise player.broke or _FAULTS.get(trial.error.boundary, TrialFault)(trial.error.message)
        state.store.set(TRIAL, trial_to_json(trial).decode())
        state.completed = True
        return state

    return solve


class _ModelOfTheEval:
    """An eval's model in one trial, whose conversation becomes the messages of ``state``."""

    def __init__(self, model: Model, spec: str, config: GenerateConfig, state: TaskState) -> None:
        self.broke: BaseException | None = None
        self._model, self._state = model, state
        self._name, self._settings = read_settings(spec)
        self._known = facts_of(self._name)
        self._others = {
            name: value
            for name, value in config.model_dump(mode="json", exclude_none=True).items()
            if name not in _TRANSPORT and name not in _OURS.values()
        }
        self._access = Access(timeout=86_400)
        if config.max_retries is not None:
            self._access = replace(self._access, retries=min(config.max_retries, 100))
        self._made: dict[tuple[object, ...], ChatMessage] = {}
        state.messages = []

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of the model; other settings of the eval are under ``config``."""
        others = {"config": json.dumps(self._others, sort_keys=True)} if self._others else {}
        return model_facts(self._name, self._settings) | others

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Ask for the next joint. Exceptions of Inspect pass, so that its limits and retries apply."""
        step = len(situation.past) + 1

        async def ask(turn: int, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
            try:
                return await self._ask(step, turn, messages, schema)
            finally:
                self.broke = sys.exception()

        return await decided(situation, self._settings, ask, self._settings.most_tokens(self._known))

    async def _ask(self, step: int, turn: int, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
        asked = [self._message(i, message, step, turn) for i, message in enumerate(messages)]
        self._state.messages.append(asked[-1])
        began = time.perf_counter()
        output, text, stop, tries = await self._said(asked, self._config(schema))
        text = without_keys(text)
        reply = self._message(len(messages), Message(role="assistant", text=spoken(text)), step, turn)
        reply.id = output.message.id
        self._state.messages.append(output.message.model_copy(update={"metadata": dict(reply.metadata or {})}))
        self._state.output = output
        return ModelReply(
            text=text,
            stop=stop,
            served=without_keys(output.model),
            usage=usage_of(output) + tries.lost,
            seconds=output.time or time.perf_counter() - began,
            retries=tries.retries,
            reasoned=reasoned_in(output),
        )

    async def _said(self, asked: list[ChatMessage], config: GenerateConfig) -> tuple[ModelOutput, str, str, Tries]:
        """The model's output, its text and why it stopped. Inspect retries what it knows as a fault; we do the rest."""
        check_answers(getattr(self._model.api, "client", None), _ASKING.get)

        async def attempt() -> tuple[ModelOutput, str, str]:
            asking = _ASKING.set(True)
            try:
                output = await self._model.generate(asked, config=config)
                return output, *said_in(output)
            finally:
                _ASKING.reset(asking)

        try:
            asyncio.get_running_loop()
        except RuntimeError:  # Inspect runs on trio: what it does not retry is the sample's error
            came, tries = await attempt(), Tries()
        else:
            came, tries = await with_retries(attempt, _own_judgement, self._access)
        refuse_overflow(came[0], tries)
        return *came, tries

    def _config(self, schema: dict[str, object]) -> GenerateConfig:
        """The parameters sent with the conversation, equal to those of Lockprobe's client."""
        form = self._settings.form(self._known)
        config = GenerateConfig().model_copy(update=self._settings.parameters(self._known))
        if form != "none":
            json_schema = JSONSchema.model_validate(schema)
            config.response_schema = ResponseSchema(name="reply", json_schema=json_schema, strict=form == "strict")
        return config

    def _message(self, place: int, message: Message, step: int, turn: int) -> ChatMessage:
        """One object per message in all calls, with distinct metadata so that Inspect does not merge equal ones."""
        name = (place, message.role, message.text, tuple(picture.name for picture in message.pictures))
        if name not in self._made:
            made = sent(message, self._settings)
            made.metadata = {"step": step} if turn == 1 else {"step": step, "turn": turn}
            self._made[name] = made
        return self._made[name]

    def note(self, key: str, step: Step) -> None:
        """Write the truth of a step where the model does not see it."""
        transcript().info(step_as_markdown(step), source="lockprobe")
        self._state.messages[-1].metadata = step_metadata(step)


def _own_judgement(error: Exception) -> Judgement:
    """The judgement of a fault that Inspect does not know; its own exceptions pass."""
    if not isinstance(error, Declined):
        raise error
    return error


def _finish(state: TaskState, trial: Trial, directory: Path) -> None:
    """Add to a sample what its model did not see: the last observation, and recorded pictures."""
    if trial.error is None:
        last = sent(last_report(trial, directory), ModelSettings())
        last.metadata = {"step": len(trial.steps) + 1}
        state.messages.append(last)
    for name, value in beside(trial, state.messages, directory).items():
        state.store.set(name, value)
