"""Prints tables and lines for people: tables truncate no number, and lines fit the terminal."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable, Sequence
from itertools import zip_longest
from textwrap import wrap

from lockprobe.foundation.terminal_text import printable

_GAP = 2
"""Spaces between two columns."""


def print_rows(rows: Sequence[Sequence[str]]) -> None:
    """Print rows of plain text as a table; the first row holds the column heads, the first column names.

    It is as wide as the terminal but never narrower than its words: no number is cut. A file or a pipe gets it in full.
    """
    columns = [[printable(cell) for cell in column] for column in zip(*rows, strict=True)]
    least = [max(len(word) for cell in column for word in cell.split() or [""]) for column in columns]
    widths = [max(map(len, column)) for column in columns]
    room = shutil.get_terminal_size().columns if sys.stdout.isatty() else sum(widths) + _GAP * len(widths)
    while sum(widths) + _GAP * (len(widths) - 1) > room:
        loose = [place for place, width in enumerate(widths) if width > least[place]]
        if not loose:
            break
        widths[max(loose, key=widths.__getitem__)] -= 1
    for row in zip(*columns, strict=True):
        parts = [wrap(cell, width) if width else [] for cell, width in zip(row, widths, strict=True)]
        for line in zip_longest(*parts, fillvalue=""):
            cells = [f"{part:{'>' if place else '<'}{widths[place]}}" for place, part in enumerate(line)]
            print((" " * _GAP).join(cells).rstrip())


def say(text: str = "", *, end: str = "\n") -> None:
    """Print text of several lines at once."""
    print("\n".join(map(printable, text.split("\n"))), end=end, flush=True)


def time_left(noun: str) -> Callable[[int, int], None]:
    """A function that prints the time left on standard error: a line every two seconds at most, none for short work."""
    last = 0.0
    began: tuple[float, int] | None = None

    def tell(done: int, of: int) -> None:
        nonlocal began, last
        now = time.monotonic()
        if began is None:
            began, last = (now, done), now  # the work may begin long after this was made
        elif now - last > 2 and began[1] < done < of:
            last = now
            left = (now - began[0]) * (of - done) / (done - began[1])
            print(f"{done} of {of} {noun}, {left:.0f} s left", file=sys.stderr)

    return tell
