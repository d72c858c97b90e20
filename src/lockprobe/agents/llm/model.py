"""A language model as an agent: one call for each decision, and one more for each malformed reply.

A refusal ends the trial. So does a reply that the limit cut off for the second time, or before it had begun: the same
limit would cut off the next one too.

The pictures of a percept are sent as PNG after its text. Earlier pictures stay in the conversation, as in the paper, or
only the newest do: ``llm:openai/gpt-4o?images=4``.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, get_args

from lockprobe.agents.llm.client import Attempts, ModelClient, ModelReply
from lockprobe.agents.llm.model_facts import Effort, ModelFacts, Schema, facts_of
from lockprobe.agents.llm.servers import host_of, server_of
from lockprobe.agents.llm.settings import ModelSettings, read_settings
from lockprobe.agents.llm.token_bounds import at_most
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import (
    Message,
    chat_fingerprint,
    conversation,
    parse_reply,
    picture_fingerprint,
    repair,
    reply_schema,
    spoken,
)
from lockprobe.agents.reply_text import without_marks
from lockprobe.foundation.errors import ModelFault, RefusalFault, ReplyFault
from lockprobe.foundation.formatting import count
from lockprobe.trial.model_call import BROKEN_OFF, Call, Usage
from lockprobe.trial.protocols import CallBook
from lockprobe.trial.record import Decision, Fact, Situation

if TYPE_CHECKING:
    import numpy as np

_KEPT = ("stop", "served", "usage", "seconds", "retries", "unanswered", "reasoned")
"""The fields of an answer, besides its text, that a call keeps under the same names."""

_CUT_OFF = "max_tokens"
"""Why a reply stopped that reached its limit."""

_MOST_CUT_OFF = 2
"""Cut-off replies to one request that end a trial. One that had begun can be shorter when it is asked for again."""

Ask = Callable[[int, Sequence[Message], dict[str, object]], Awaitable[ModelReply]]
"""From the turn, from 1, the conversation and the form of the reply to the reply."""


def check(spec: str, access: Access | None = None) -> None:
    """Check whether a model can be reached at all.

    Raises:
        UserMistake: As :class:`ModelClient` and :func:`lockprobe.agents.llm.settings.read_settings`.
    """
    name, settings = read_settings(spec)
    ModelClient(name, settings, access or Access())


def model_facts(name: str, settings: ModelSettings) -> dict[str, Fact]:
    """Model name, form of requests, prompt and settings, for the record; the host if it is not the provider's own."""
    host = host_of(name)
    return {
        "model": name,
        "runtime": server_of(name).runtime,
        "prompt": f"chat {chat_fingerprint()}",
        "picture_prompt": f"chat {picture_fingerprint()}",
        **settings.sent(facts_of(name)),
        **({} if host is None else {"host": host}),
    }


class HostedModel:
    """A model behind a provider's interface. A malformed reply is requested again.

    The spec holds the model's provider and name, and options: ``openai/gpt-4o?images=4``.

    Attributes:
        unseeded: Its luck is the provider's; see :class:`lockprobe.trial.protocols.Agent`.
        facts: As :func:`model_facts` has them.
    """

    unseeded = True

    def __init__(self, spec: str, access: Access | None = None) -> None:
        name, self._settings = read_settings(spec)
        self._line = ModelClient(name, self._settings, access or Access())
        self._known = facts_of(name)
        own = model_facts(name, self._settings)
        self.facts: Mapping[str, Fact] = own | self._line.filled_in
        if "max_tokens" in self._line.filled_in:  # a request is known by what was sent, and so it is on record
            self._settings = replace(self._settings, max_tokens=self._line.filled_in["max_tokens"])

    def with_calls(self, key: str, book: CallBook) -> _InOneTrial:
        """The model for one trial: no call is made twice, and every call is recorded."""
        return _InOneTrial(self.facts, key, book, self._settings, self._line, self._known)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Ask for the next joint. The stream is not used: a provider draws its own luck."""

        async def ask(turn: int, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
            async with self._line.slots:
                return await self._line.ask(messages, schema)

        return await decided(situation, self._settings, ask, self._settings.most_tokens(self._known))

    async def aclose(self) -> None:
        """Close the provider's connections."""
        await self._line.aclose()


class _InOneTrial:
    """A model in one trial, with the earlier calls of that trial."""

    unseeded = True

    def __init__(
        self,
        facts: Mapping[str, Fact],
        key: str,
        book: CallBook,
        settings: ModelSettings,
        line: ModelClient,
        known: ModelFacts,
    ) -> None:
        self.facts, self._key, self._book = facts, key, book
        self._settings, self._line, self._known = settings, line, known

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        step = len(situation.past) + 1

        async def ask(turn: int, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
            request = _fingerprint(messages, schema, self._settings, self._known)
            if (known := self._book.recall(step, turn, request)) and known.reply is not None:
                return _recalled(known, known.reply)
            worst = at_most(messages, self._settings, self._known)
            async with self._line.slots:
                asked = Call(key=self._key, step=step, turn=turn, request=request, reply=None, most=worst)
                await self._book.reserve(asked)
                return await made(asked, worst, messages, schema)

        async def made(asked: Call, worst: Usage, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
            result: dict[str, Any] = {"error": BROKEN_OFF}
            began = time.perf_counter()

            async def again(failed: Attempts) -> None:
                await self._book.reserve(replace(asked, **failed._asdict()))

            try:
                answer = await self._line.ask(messages, schema, again)
                result = {name: getattr(answer, name) for name in _KEPT} | _credible(answer.usage, worst)
                result["reply"] = answer.text
                answer = replace(answer, usage=result["usage"])
            except ModelFault as fault:
                result = {
                    **_credible(Usage(**fault.usage), worst),
                    "error": str(fault),
                    "seconds": time.perf_counter() - began,
                    "retries": fault.retries,
                    "unanswered": fault.unanswered,
                }
                raise
            finally:
                self._book.write(replace(asked, most=None, **result))
            return answer

        return await decided(situation, self._settings, ask, self._settings.most_tokens(self._known))


def _credible(usage: Usage, worst: Usage) -> dict[str, Usage]:
    """The usage of a call; in the place of an impossible count the largest possible one, beside what was claimed."""
    if usage.beyond(worst):
        return {"usage": replace(worst, calls=min(1, usage.calls)), "claimed": usage}
    return {"usage": usage}


class ReplayedModel:
    """A model in a trial that has ended: it decides again by the replies on record, and no provider is asked.

    Its settings are those of the record, so that each request has to be the one that was sent.

    Args:
        facts: The facts of the model, from the record.
        spec: Its spec.
        recall: From step, turn and request to the reply; None without one.
    """

    unseeded = True

    def __init__(self, facts: Mapping[str, Fact], spec: str, recall: Callable[[int, int, str], Call | None]) -> None:
        self.facts, self._recall = facts, recall
        self._settings = _recorded_settings(read_settings(spec)[1], facts)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Decide as on record.

        Raises:
            ModelFault: If a reply is missing.
        """
        step = len(situation.past) + 1

        async def ask(turn: int, messages: Sequence[Message], schema: dict[str, object]) -> ModelReply:
            request = _fingerprint(messages, schema, self._settings, _UNKNOWN)
            if (known := self._recall(step, turn, request)) is None or known.reply is None:
                raise ModelFault("there is no such reply")
            return _recalled(known, known.reply)

        return await decided(situation, self._settings, ask, self._settings.most_tokens(_UNKNOWN))


_UNKNOWN = ModelFacts()
"""Of a model about which only its record says something."""


def _recorded_settings(given: ModelSettings, facts: Mapping[str, Fact]) -> ModelSettings:
    """The settings that a record names, with those of the spec that no record holds."""
    numbers: dict[str, Any] = {name: _number(facts.get(name)) for name in ("temperature", "top_p", "max_tokens")}
    effort, schema, repairs = (facts.get(name) for name in ("effort", "schema", "repairs"))
    words: dict[str, Any] = {
        "effort": effort if effort in get_args(Effort) else None,
        "schema": schema if schema in get_args(Schema) else None,
    }
    return replace(given, **numbers, **words, repairs=repairs if isinstance(repairs, int) else given.repairs)


def _number(fact: Fact) -> float | int | None:
    return fact if isinstance(fact, int | float) and not isinstance(fact, bool) else None


def _recalled(call: Call, text: str) -> ModelReply:
    """The reply of a call on record."""
    came = {name: getattr(call, name) for name in _KEPT}
    return ModelReply(text=text, **came)


def _fingerprint(
    messages: Sequence[Message], schema: dict[str, object], settings: ModelSettings, facts: ModelFacts
) -> str:
    """A fingerprint of a request: sixteen hexadecimal digits."""
    said = [[message.role, message.text, *(picture.name for picture in message.pictures)] for message in messages]
    asked = [settings.parameters(facts), settings.form(facts), settings.detail]
    text = json.dumps([said, schema, asked], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


async def decided(situation: Situation, settings: ModelSettings, ask: Ask, most: int | None = None) -> Decision:
    """Ask until a reply is well formed. ``most`` is the limit of a reply in tokens, if it is known.

    Raises:
        RefusalFault: If the model or its provider refused.
        ReplyFault: If too many replies were malformed, or the limit left no room for one.
    """
    messages = conversation(situation, images=settings.images)
    schema = reply_schema(situation)
    replies: list[str] = []
    usage, cut_off = Usage(), 0
    while True:
        answer = await ask(len(replies) + 1, messages, schema)
        replies.append(answer.text)
        usage += answer.usage
        try:
            decision = parse_reply(answer.text, situation, answer.stop)
            return replace(decision, replies=tuple(replies), usage=usage, served=answer.served)
        except RefusalFault as fault:
            raise RefusalFault(str(fault), tuple(replies), asdict(usage)) from None
        except ReplyFault as fault:
            said = without_marks(answer.text)[0].strip()
            if answer.stop == _CUT_OFF:
                cut_off += 1 if said else _MOST_CUT_OFF
            if len(replies) > settings.repairs or cut_off >= _MOST_CUT_OFF:
                why = f"no usable reply in {count(len(replies), 'turn')}: {fault}{_cause(answer, most, empty=not said)}"
                raise ReplyFault(why, tuple(replies), asdict(usage)) from None
            messages = [
                *messages,
                Message(role="assistant", text=spoken(answer.text)),
                Message(role="user", text=repair(fault, situation)),
            ]


def _cause(answer: ModelReply, most: int | None, *, empty: bool) -> str:
    """The cause of an unusable reply, if it is empty or cut off: tokens, those of reasoning among them, the limit."""
    written, reasoned = answer.usage.output_tokens, answer.usage.reasoning_tokens
    hidden = f", {reasoned or 'some'} of them of reasoning" if reasoned or answer.reasoned else ""
    after = f" after {written} tokens{hidden}" if written else " after reasoning" if answer.reasoned else ""
    if answer.stop == _CUT_OFF:
        limit = "" if most is None else f" than {most}"
        return f" (the reply was cut off{after}: a larger max_tokens{limit} leaves it more room)"
    if answer.stop == "tool_calls":
        return " (it called a tool, and there is none)"
    return f" ({after.strip()})" if empty and after else ""
