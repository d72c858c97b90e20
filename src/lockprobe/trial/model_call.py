"""One call to a model: its result and its cost."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Annotated

from annotated_types import Ge, Gt, Le, Lt

BROKEN_OFF = "broken off"
"""The error text of a call that was in progress when its run ended."""

Count = Annotated[int, Ge(0), Le(2**53)]
"""A whole number read from disk."""

WHOLE = 2**63
Whole = Annotated[int, Ge(-WHOLE), Le(WHOLE)]
"""A whole number of a record: other tools read 64 bits."""

Finite = Annotated[float, Gt(-inf), Lt(inf)]
"""Any other number of a record."""

Share = Annotated[float, Ge(0), Le(1)]
"""A probability."""

Seconds = Annotated[float, Ge(0), Le(1e8)]
"""A duration read from disk: three years at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """The usage of calls to a model, by its provider's counts. For a decision: the sum over its calls with repairs.

    ``calls`` are replies received. Of the tokens read some come from the provider's cache, and it may have ``stored``
    some there; of those written some are hidden ``reasoning``.
    """

    calls: Count = 0
    input_tokens: Count = 0
    output_tokens: Count = 0
    cached_tokens: Count = 0
    stored_tokens: Count = 0
    reasoning_tokens: Count = 0

    def beyond(self, most: Usage) -> bool:
        """Whether far more is counted than there can have been, ten times as much; some count what they add."""
        return self.input_tokens > 10 * most.input_tokens or self.output_tokens > 10 * most.output_tokens

    def __add__(self, other: Usage) -> Usage:
        """Both together."""
        return Usage(**{name: getattr(self, name) + getattr(other, name) for name in Usage.__slots__})


@dataclass(frozen=True, slots=True, kw_only=True)
class Call:
    """One call to a model. It is written to disk as soon as its reply arrives, so that no paid reply is lost.

    ``key`` and ``agent`` are those of the record.

    Attributes:
        step: The step to decide, from 1.
        turn: The number of the call for that step, from 1; later ones follow a malformed reply.
        request: Fingerprint of the request; an equal request at the same step and turn gets this reply.
        reply: The raw reply; of a refusal its words; None without a reply.
        stop: Why the model stopped, ``stop``, ``max_tokens``, ``tool_calls`` or ``unknown``; ``content_filter`` if the
            model or its provider refused.
        served: The model that answered, as the provider names it.
        usage: Its usage, with what the provider counted for failed attempts; before there is an outcome, that alone.
        seconds: Wall time, including retries.
        unanswered: Attempts without a usable reply that the provider may have charged for: timed out, dropped, or
            unreadable.
        reasoned: Whether reasoning came with the reply, apart from its text.
        error: The provider's error, without secrets; empty if a reply came.
        most: The maximum usage of one attempt, if there are attempts of unknown usage.
        claimed: The provider's count, if it is far more than possible; ``usage`` is then the possible maximum. None if
            the count is plausible.
    """

    key: str
    step: Count
    turn: Count
    request: str
    reply: str | None
    stop: str = ""
    served: str = ""
    usage: Usage = field(default_factory=Usage)
    seconds: Seconds = 0.0
    retries: Count = 0
    unanswered: Count = 0
    reasoned: bool = False
    error: str = ""
    most: Usage | None = None
    claimed: Usage | None = None
    agent: str = ""

    @property
    def broken_off(self) -> bool:
        """Whether it was on its way when its run ended; its provider may have charged for it."""
        return self.reply is None and self.error == BROKEN_OFF

    @property
    def uncounted(self) -> bool:
        """Whether it has a reply and no count of tokens."""
        return self.reply is not None and not (self.usage.input_tokens or self.usage.output_tokens)

    @property
    def unpriced(self) -> int:
        """Attempts whose cost nobody said: each can have cost :attr:`most`."""
        return self.unanswered + (self.broken_off or self.uncounted)
