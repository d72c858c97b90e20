"""Prints tables and lines for people: tables truncate no number, and lines fit the terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import IO

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from lockprobe.boxes.sketch import ascii_only
from lockprobe.foundation.terminal_text import printable

_UNBOUNDED = 10_000
"""Columns of output that does not go to a terminal: lines are not wrapped."""

_GAP = 2
"""Spaces between two columns."""


def plain_console(file: IO[str] | None = None) -> Console:
    """A console as wide as the terminal, on standard output by default; files and pipes get unwrapped lines."""
    file = sys.stdout if file is None else file
    return Console(file=file, highlight=False, emoji=False, width=None if file.isatty() else _UNBOUNDED)


def new_table(*columns: str, numbers: bool = True) -> Table:
    """An empty table with these column heads; the first column holds names, the others numbers, or words."""
    table = Table(box=None, show_edge=False, pad_edge=False, padding=(0, _GAP, 0, 0))
    for place, name in enumerate(columns):
        table.add_column(name, justify="right" if place and numbers else "left")
    return table


def print_rows(rows: Sequence[Sequence[str]]) -> None:
    """Print rows of plain text as a table; the first holds the column heads."""
    table = new_table(*rows[0])
    for row in rows[1:]:
        table.add_row(*(escape(printable(cell)) for cell in row))
    print_table(table)


def print_table(table: Table, file: IO[str] | None = None) -> None:
    """Print a table: as wide as the terminal but never narrower than its words; in full to a file or a pipe.

    Cells and heads are markup. ``file`` is standard output by default.
    """
    file = sys.stdout if file is None else file
    fit_columns(table, plain_console(file).width)
    console = Console(highlight=False, emoji=False, width=_UNBOUNDED, height=1, force_terminal=file.isatty())
    with console.capture() as printed:
        console.print(table)
    file.writelines(f"{line.rstrip()}\n" for line in printed.get().splitlines())


def fit_columns(table: Table, width: int) -> None:
    """Set the widths of the columns: the widest shrink first, until the table fits or a word would be cut."""
    texts = [
        [Text.from_markup(str(cell), emoji=False).plain for cell in (one.header, *one.cells)] for one in table.columns
    ]
    least = [max((len(word) for text in cells for word in text.split()), default=1) for cells in texts]
    widths = [max((len(line) for text in cells for line in text.splitlines()), default=1) for cells in texts]
    while sum(widths) + _GAP * (len(widths) - 1) > width:
        loose = [place for place, wide in enumerate(widths) if wide > least[place]]
        if not loose:
            break
        widths[max(loose, key=widths.__getitem__)] -= 1
    for column, wide in zip(table.columns, widths, strict=True):
        column.width = wide


class Screen:
    """Standard output, with colours only on a terminal and without ``NO_COLOR``."""

    def __init__(self) -> None:
        self._console = Console(highlight=False, emoji=False, soft_wrap=True)

    def say(self, line: str = "", style: str = "", *, end: str = "\n") -> None:
        """Print one line."""
        line = printable(line)
        try:
            line.encode(sys.stdout.encoding or "ascii")
        except UnicodeEncodeError:
            line = ascii_only(line)
        self._console.print(Text(line, style), end=end)
        sys.stdout.flush()


def time_left(noun: str) -> Callable[[int, int], None]:
    """Print the time left on standard error, at most one line every two seconds, and none for short work."""
    last = time.monotonic()
    began: tuple[float, int] | None = None

    def tell(done: int, of: int) -> None:
        nonlocal began, last
        now = time.monotonic()
        if began is None:
            began = now, done  # the work may begin long after this was made
        elif now - last > 2 and began[1] < done < of:
            last = now
            left = (now - began[0]) * (of - done) / (done - began[1])
            print(f"{done} of {of} {noun}, {left:.0f} s left", file=sys.stderr)

    return tell
