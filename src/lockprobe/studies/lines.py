"""Files of lines that are appended and never rewritten: a line that a crash tore is no line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import IO

__all__ = ["cut_torn_tail", "whole_lines"]


def whole_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Whole lines that are not blank, with their numbers, from 1."""
    with path.open("rb") as lines:
        yield from ((n, line) for n, line in enumerate(lines, 1) if line.endswith(b"\n") and line.strip())


def cut_torn_tail(handle: IO[bytes], path: Path) -> None:
    """Cut an unfinished last line off, so that the next line starts clean.

    Args:
        handle: The file, open for appending.
        path: Where it lies.
    """
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole != len(content):
        handle.truncate(whole)
