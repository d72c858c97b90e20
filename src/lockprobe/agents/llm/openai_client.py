"""Tells whether a client is OpenAI's, without importing its package, which takes half a second of processor time."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from openai import AsyncOpenAI
    from typing_extensions import TypeIs


def is_openai(client: object) -> TypeIs[AsyncOpenAI]:
    """Whether a client is OpenAI's. Whoever made one has imported the package."""
    package = sys.modules.get("openai")
    return package is not None and isinstance(client, package.AsyncOpenAI)
