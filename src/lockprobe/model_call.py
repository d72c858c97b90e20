"""One call to a model: what came of it, and what it cost."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import inf
from typing import Annotated

from annotated_types import Ge, Le, Lt

__all__ = ["BROKEN_OFF", "OWED_ANEW", "Call", "Usage"]

BROKEN_OFF = "broken off"
"""What stands for the error of a call that was on its way when its run ended."""

OWED_ANEW = "owed anew"
"""What stands for the error of a line that is no call: from here on none of its trial's earlier calls is looked up."""

_Count = Annotated[int, Ge(0), Le(2**53)]
"""How a number is checked that stands on disk."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """What calls to a model cost, as its provider counts. Of a decision: over all its calls, repairs included.

    Attributes:
        calls: Replies that came.
        input_tokens: Tokens read, those from a cache included.
        output_tokens: Tokens written, those of reasoning included.
        cached_tokens: Of the tokens read, those that the provider had in its cache.
        stored_tokens: Of the tokens read, those that it put into its cache, where it says so.
        reasoning_tokens: Of the tokens written, those that nobody gets to see.
    """

    calls: _Count = 0
    input_tokens: _Count = 0
    output_tokens: _Count = 0
    cached_tokens: _Count = 0
    stored_tokens: _Count = 0
    reasoning_tokens: _Count = 0

    def beyond(self, most: Usage) -> bool:
        """Whether far more is counted than there can have been, ten times as much; some count what they add."""
        return self.input_tokens > 10 * most.input_tokens or self.output_tokens > 10 * most.output_tokens

    def __add__(self, other: Usage) -> Usage:
        """Both together."""
        return Usage(**{part.name: getattr(self, part.name) + getattr(other, part.name) for part in fields(self)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Call:
    """One call to a model, as it is put on disk the moment its reply comes: a reply that was paid for is never lost.

    Attributes:
        key: The trial.
        step: The step that was to be decided, from 1.
        turn: Which call for that step, from 1; those after the first follow a malformed reply.
        request: Fingerprint of all that was sent; the same request in the same place has this reply already.
        reply: The raw reply; None where none came.
        stop: Why the model stopped, as Inspect AI names it: ``stop``, ``max_tokens``, ``content_filter`` and others.
        served: The model that answered, as the provider names it.
        usage: What it cost.
        seconds: Wall time, retries included.
        retries: How often the provider had to be asked again.
        unanswered: Attempts of this call that the provider may have charged for, though nothing of use came back: cut
            off at the timeout, dropped, or not to be read.
        error: What the provider said instead of replying, without secrets; empty where a reply came.
        batch: Whether it went through the provider's batch interface.
        most: What one attempt can have cost at most, where there are some whose cost nobody said.
        claimed: What its provider counted, where that is far more than the call can have cost; ``usage`` is then the
            most that it can have. None where the count can be believed.
    """

    key: str
    step: _Count
    turn: _Count
    request: str
    reply: str | None
    stop: str = ""
    served: str = ""
    usage: Usage = field(default_factory=Usage)
    seconds: Annotated[float, Ge(0), Lt(inf)] = 0.0
    retries: _Count = 0
    unanswered: _Count = 0
    error: str = ""
    batch: bool = False
    most: Usage | None = None
    claimed: Usage | None = None

    @property
    def broken_off(self) -> bool:
        """Whether it was on its way when its run ended; its provider may have charged for it."""
        return self.reply is None and self.error == BROKEN_OFF

    @property
    def owed_anew(self) -> bool:
        """Whether it is no call but says that its trial is played anew, with new calls."""
        return self.reply is None and self.error == OWED_ANEW

    @property
    def uncounted(self) -> bool:
        """Whether it has a reply and no count of tokens."""
        return self.reply is not None and not (self.usage.input_tokens or self.usage.output_tokens)

    @property
    def unpriced(self) -> int:
        """Attempts whose cost nobody said: each can have cost :attr:`most`."""
        return self.unanswered + (self.broken_off or self.uncounted)
