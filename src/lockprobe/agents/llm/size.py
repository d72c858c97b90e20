"""How large requests are, before they are made and their provider counts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, takewhile

from lockprobe.agents.llm.knowledge import ModelFacts
from lockprobe.agents.llm.settings import Settings
from lockprobe.agents.prompt import Message
from lockprobe.call import Usage

__all__ = ["at_most", "repeated_prefix", "tokens"]

CHARACTERS = 3.1
"""Characters per token of our conversations: 9833 in 3179 tokens of SmolLM2-135M's tokenizer (instruction, schema, and
observations and replies of six trials of ``human-inspired`` at p = 0.2). It is 2.0 in observations, 3.2 in replies and
3.8 in the instruction; vocabularies larger than its 49 152 need fewer tokens."""

PER_MESSAGE = 20
"""Tokens around a message, at most: its role, and marks of begin and end."""

FORM = 500
"""Tokens that a provider can add for the form of the reply, at most: ours are of 84 tokens."""

MOST_PER_PICTURE = 3000
"""Tokens that providers take for one of our pictures, at most, where nothing is known of the model."""

MOST_OUTPUT = 32_768
"""Tokens of a reply where nothing bounds it: what is left to the provider of a model of which nothing is known."""


def tokens(text: str) -> float:
    """About as many tokens as a text has; see :data:`CHARACTERS`."""
    return len(text) / CHARACTERS


def at_most(messages: Sequence[Message], settings: Settings, facts: ModelFacts) -> Usage:
    """What one call can cost, whatever the model replies.

    A tokenizer makes no more tokens of a text than the text has bytes.

    Args:
        messages: The conversation.
        settings: How the model is asked.
        facts: What is known of it.
    """
    text = sum(len(message.text.encode(errors="surrogatepass")) for message in messages)
    pictures = sum(len(message.pictures) for message in messages)
    return Usage(
        calls=1,
        input_tokens=text + PER_MESSAGE * len(messages) + FORM + (facts.picture_tokens or MOST_PER_PICTURE) * pictures,
        output_tokens=settings.most_tokens(facts) or MOST_OUTPUT,
    )


def repeated_prefix(conversations: Sequence[Sequence[Message]], *, picture_tokens: int = MOST_PER_PICTURE) -> float:
    """The share of what the requests of a trial hold that repeats the start of the request before, 0 to 1.

    It is what a provider's prefix cache can save at best. Texts count by :func:`tokens`.

    Args:
        conversations: The requests in the order in which they are made.
        picture_tokens: Tokens of a picture.
    """

    def size(messages: Sequence[Message]) -> float:
        return sum(tokens(message.text) + picture_tokens * len(message.pictures) for message in messages)

    def repeated(before: Sequence[Message], after: Sequence[Message]) -> float:
        same = _equal(before, after)
        whole = size(after[:same])
        if same in (len(before), len(after)) or before[same].role != after[same].role:
            return whole
        text = after[same].text
        return whole + tokens(text[: _equal(before[same].text, text)])

    total = sum(map(size, conversations))
    return sum(repeated(before, after) for before, after in pairwise(conversations)) / total if total else 0.0


def _equal(one: Sequence[object], other: Sequence[object]) -> int:
    """How many of their first elements are the same."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))
