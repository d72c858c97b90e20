"""Plain lines for people: with colours where they are wanted, in characters that the terminal has."""

from __future__ import annotations

import sys

from rich.console import Console
from rich.text import Text

from lockprobe.lockbox.sketch import ascii_only
from lockprobe.terminal_text import printable

__all__ = ["Screen"]


class Screen:
    """Standard output. Colours only on a terminal, and none where ``NO_COLOR`` is set."""

    def __init__(self) -> None:
        self._console = Console(highlight=False, soft_wrap=True)

    def say(self, line: str = "", style: str = "", *, end: str = "\n") -> None:
        """Print one line."""
        line = printable(line)
        try:
            line.encode(sys.stdout.encoding or "ascii")
        except UnicodeEncodeError:
            line = ascii_only(line)
        self._console.print(Text(line, style), end=end)
        sys.stdout.flush()
