"""A language model as an agent: one call for each decision, and one more for each malformed reply.

The pictures of a percept are sent as PNG after its text. Earlier pictures stay in the conversation, as in the paper, or
only the newest do: ``llm:openai/gpt-4o?images=4``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING

from lockprobe.agents.llm.answer import MENDING
from lockprobe.agents.llm.asking_again import decided, verdict_on
from lockprobe.agents.llm.client import ModelClient
from lockprobe.agents.llm.settings import PER_MESSAGE, Access, Model
from lockprobe.agents.prompt import Message, prompt_fingerprint
from lockprobe.foundation.errors import ModelFault, RefusalFault, ReplyFault
from lockprobe.trial.model_call import BROKEN_OFF, Call
from lockprobe.trial.protocols import CallBook
from lockprobe.trial.record import Decision, Fact, Situation

if TYPE_CHECKING:
    import numpy as np

_ALIKE, _ALIKE_TRIALS = 12, 3
"""Unusable replies with the same words since the last usable one, and trials that got them, after which they are its
server's."""


class HostedModel:
    """A model behind a provider's interface.

    All its trials share one client, and an account of unusable replies since the last usable one: the trials that got
    them, by their words. It is kept from the first usable one on, for which None stands in it.

    Attributes:
        facts: Model name, form of requests, prompt and settings; the host, where it is not the provider's own.
        line: The client.
    """

    unseeded = True

    def __init__(self, model: Model, access: Access) -> None:
        self.line, self._key = ModelClient(model, access), ""
        self._alike: dict[str | None, list[str]] = {}
        self._book: CallBook | None = None
        self._read: tuple[Sequence[Message], int] = (), 0  # the conversation of the step before, and its tokens
        server = self.line.server
        self.facts: Mapping[str, Fact] = {
            "model": model.name,
            "runtime": "Anthropic messages" if server.messages else "chat completions",
            "prompt": prompt_fingerprint(),
            **model.sent(),
            **({} if server.host is None else {"host": server.host}),
        }

    def with_calls(self, key: str, book: CallBook) -> HostedModel:
        """The model for one trial: no call is made twice, and every call is recorded."""
        one = copy(self)
        one._key, one._book, one._read = key, book, ((), 0)  # noqa: SLF001 - its own
        return one

    async def aclose(self) -> None:
        """Close the provider's connections."""
        await self.line.aclose()

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Ask for the next joint. The stream is not used: a provider draws its own luck."""
        model, book = self.line.model, self._book

        async def ask(new: Call, messages: Sequence[Message], schema: dict[str, object]) -> Call:
            done = None if book is None else book.recall(new.step, new.turn, new.request)
            done = done or await once(new, messages, schema)
            if new.turn == 1 and (tokens := _counted(done)):  # what is asked for again does not stay
                self._read = messages, tokens
            return done

        async def once(new: Call, messages: Sequence[Message], schema: dict[str, object]) -> Call:
            await self.line.pause(new.turn - 1)
            worst = model.at_most(messages)
            done = asked = replace(new, key=self._key, most=worst)
            async with self.line.slots:
                if book is not None:
                    await book.reserve(asked)
                try:
                    done = await self.line.ask(asked, messages, schema, None if book is None else book.reserve)
                    if done.usage.beyond(worst):  # an impossible count: the largest possible one stands beside it
                        most = replace(worst, calls=min(1, done.usage.calls))
                        done = replace(done, usage=most, claimed=done.usage)
                    if done.reply is not None and (why := self._wrong(done, verdict_on(done, situation), messages)):
                        spent, lost = replace(done.usage, calls=0), done.unanswered + done.uncounted
                        done = replace(done, reply=None, error=why, usage=spent, unanswered=lost)
                        done = replace(done, stop="", served="", reasoned=False)
                finally:
                    if book is not None:
                        await book.write(replace(done, error=BROKEN_OFF) if done is asked else done)
            if done.reply is None:
                raise ModelFault(done.error)
            return done

        return await decided(situation, model, ask)

    def _wrong(self, answer: Call, verdict: Decision | ReplyFault, messages: Sequence[Message]) -> str:
        """Why a reply is its server's: to half of a conversation, or in words that all trials get that had replies.

        Counts that never were of the text are no evidence of a cut, nor is the count of what was added alone, which is
        what some servers count that had the rest in a cache. Empty for a reply of the model.
        """
        text, why = answer.reply or "", ""
        if isinstance(verdict, Decision):
            self._alike.clear()
            self._alike[None] = []
        elif self._alike and not isinstance(verdict, RefusalFault):
            got = self._alike.setdefault(text, [])
            got.append(self._key)
            last = answer.turn > self.line.model.settings.repairs
            if last and len(got) >= _ALIKE and len(set(got)) >= _ALIKE_TRIALS:
                why = f"all trials get the same words in the place of replies: {text[:200]!r}"
        (before, read), tokens = self._read, _counted(answer)
        was, now = ("".join([one.text for one in talk]) for talk in (before, messages))
        old, new = (len(text.encode(errors="surrogatepass")) for text in (was, now))
        if tokens <= read and read * 8 >= old and now.startswith(was) and old < new < old + tokens - PER_MESSAGE:
            why = (
                f"the server read {tokens} tokens of a conversation of which it had read {read} before, so it leaves "
                f"out what does not fit{MENDING}give it a larger context (Ollama: OLLAMA_CONTEXT_LENGTH=16384; "
                "llama.cpp: -c 16384; vLLM: --max-model-len 16384)"
            )
        return why and str(ModelFault(why))


def _counted(answer: Call) -> int:
    """The tokens read; 0 where failed attempts may be counted too, or what is kept is the largest possible count."""
    return 0 if answer.retries or answer.claimed else answer.usage.input_tokens
