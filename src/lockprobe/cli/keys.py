"""Choices by keys: one press each on a terminal, elsewhere one line each."""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Self

__all__ = ["Keys"]

_END = "\x04"
"""Ctrl-D, as a terminal sends it."""

_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O?.?)", re.DOTALL)
"""What arrows and the like send; they choose nothing."""

_PATIENCE = 0.02
"""Seconds in which the rest of an arrow key or the like comes."""

_HEED = 0.2
"""Seconds after which Ctrl-C is heeded where it came just before the wait for a key: such a wait is not interrupted."""


class Keys:
    """Standard input as keys, while it is open. What a terminal was set to is set again at the end."""

    def __init__(self) -> None:
        self._terminal = sys.stdin.fileno() if sys.stdin is not None and sys.stdin.isatty() else None
        self._before: list[object] = []
        self._pressed: list[str] = []

    def __enter__(self) -> Self:
        if self._terminal is not None:
            self._before = termios.tcgetattr(self._terminal)
            tty.setcbreak(self._terminal)  # Ctrl-C stays what it is
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._terminal is not None:
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)  # type: ignore[arg-type] # what was got

    def next(self) -> str | None:
        """The next key in capitals; of a line its first character. None at the end of input and for Ctrl-D."""
        if self._terminal is not None:
            return self._press(self._terminal)
        for line in sys.stdin or ():
            if line.strip():
                return line.strip()[0].upper()
        return None

    def _press(self, terminal: int) -> str | None:
        while not self._pressed:
            while not select.select([terminal], [], [], _HEED)[0]:
                pass
            read = os.read(terminal, 1024)
            if not read:
                return None
            while _SEQUENCE.search(read.decode("utf-8", "replace")) and select.select([terminal], [], [], _PATIENCE)[0]:
                read += os.read(terminal, 1024)
            plain = _SEQUENCE.sub("", read.decode("utf-8", "replace"))
            self._pressed = [key.upper() for key in plain if not key.isspace()]
        key = self._pressed.pop(0)
        return None if key == _END else key
