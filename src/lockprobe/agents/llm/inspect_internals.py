"""The names that Lockprobe takes from private modules of Inspect AI; nothing else imports these modules.

Inspect AI exports none of them in its public packages. They may move with any release, so the version of Inspect AI is
pinned. ``tests/agents/llm/test_inspect_internals.py`` says what each is for and what to do when it moves.
"""

from __future__ import annotations

from lockprobe.foundation.errors import needing

with needing("hosted models", "providers"):
    from inspect_ai._util.error import PrerequisiteError

try:
    from inspect_ai._util.http_defaults_httpx2 import LoopScopedTransport
except ImportError:  # no provider that is installed uses httpx2
    LoopScopedTransport = None  # type: ignore[assignment,misc]

__all__ = ["LoopScopedTransport", "PrerequisiteError"]
