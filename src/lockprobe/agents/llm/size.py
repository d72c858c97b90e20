"""How large a request is, before it is made and its provider counts."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.agents.llm.knowledge import ModelFacts
from lockprobe.agents.llm.settings import Settings
from lockprobe.agents.prompt import Message
from lockprobe.call import Usage

__all__ = ["at_most"]

FEWEST_CHARACTERS = 2
"""Characters of English and JSON that one token has at least, whoever counts."""

MOST_PER_PICTURE = 3000
"""Tokens that providers take for one of our pictures, at most."""

MOST_OUTPUT = 32_768
"""Tokens of a reply where nothing bounds it."""


def at_most(messages: Sequence[Message], settings: Settings, facts: ModelFacts) -> Usage:
    """What one call can cost, whatever the model replies.

    Args:
        messages: The conversation.
        settings: How the model is asked.
        facts: What is known of it.
    """
    characters = sum(len(message.text) for message in messages)
    pictures = sum(len(message.pictures) for message in messages)
    return Usage(
        calls=1,
        input_tokens=characters // FEWEST_CHARACTERS + 20 * len(messages) + MOST_PER_PICTURE * pictures,
        output_tokens=facts.most_output or MOST_OUTPUT,
    )
