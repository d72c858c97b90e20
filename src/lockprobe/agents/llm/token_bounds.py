"""Upper bounds of the tokens of a request, before a provider counts them."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

from lockprobe.agents.llm.settings import Model
from lockprobe.agents.prompt import Message
from lockprobe.trial.model_call import Usage

CHARACTERS = 3.1
"""Characters per token of our conversations: 9833 in 3179 tokens of SmolLM2-135M's tokenizer (instruction, schema, and
observations and replies of six trials of ``human-inspired`` at p = 0.2). It is 2.0 in observations, 3.2 in replies and
3.8 in the instruction; vocabularies larger than its 49 152 need fewer tokens."""

PER_MESSAGE = 20
"""The most tokens around a message: its role, and marks of beginning and end."""

FORM = 500
"""The most tokens that a provider can add for the form of the reply; ours has 84 tokens."""

MOST_PER_PICTURE = 3000
"""Tokens that providers take for a picture of up to 1024 by 1024 pixels, at most, where nothing is known of the
model."""

_BLOCK = 1024
"""Pixels along the sides of what is counted of a picture. Providers count by area or by smaller squares, and some
scale large pictures down first: never more than so much for every block."""

MOST_OUTPUT = 32_768
"""The assumed limit of a reply in tokens where no limit is known or sent."""


def tokens(text: str) -> float:
    """The approximate number of tokens of a text; see :data:`CHARACTERS`."""
    return len(text) / CHARACTERS


def at_most(messages: Sequence[Message], model: Model) -> Usage:
    """The maximum tokens of one call, whatever the model replies.

    A tokenizer makes no more tokens of a text than the text has bytes.
    """
    text = sum(len(message.text.encode(errors="surrogatepass")) for message in messages)
    blocks = sum(_blocks(picture.png) for message in messages for picture in message.pictures)
    return Usage(
        calls=1,
        input_tokens=text
        + PER_MESSAGE * len(messages)
        + FORM
        + (model.facts.picture_tokens or MOST_PER_PICTURE) * blocks,
        output_tokens=model.most_tokens or model.facts.most_output or MOST_OUTPUT,
    )


def _blocks(png: bytes) -> int:
    """Blocks that cover a picture, by the width and height at the start of its file."""
    sides = [int.from_bytes(png[at : at + 4], "big") for at in (16, 20)] if png[12:16] == b"IHDR" else [1, 1]
    return max(1, ceil(sides[0] / _BLOCK)) * max(1, ceil(sides[1] / _BLOCK))
