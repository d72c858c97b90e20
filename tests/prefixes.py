"""How much of requests was sent before: the reference that every other account of it is held to."""

from collections.abc import Sequence
from itertools import pairwise, takewhile

from lockprobe.agents.llm.settings import MOST_PER_PICTURE, tokens
from lockprobe.agents.prompt import Message


def repeated_prefix(conversations: Sequence[Sequence[Message]], *, picture_tokens: int = MOST_PER_PICTURE) -> float:
    """The share of what the requests of a trial hold that repeats the start of the request before, 0 to 1.

    It is what a provider's prefix cache can save at best, found by comparing the requests themselves. Texts count by :func:`tokens`.

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
