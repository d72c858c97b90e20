"""Files of lines that are appended: a line that a crash tore is no line.

What is written is handed to the system at once, line by line, so that a process that is killed loses nothing that it
had written but its last line; when the machine itself goes down, as much is lost as whoever writes did not wait for the
disk to have. Only where a person has records deleted is a file written anew (:mod:`lockprobe.studies.striking`).
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO

from lockprobe.atomic_file import sync_directory
from lockprobe.errors import BadFile
from lockprobe.inputs import read_lines

__all__ = ["append_line", "cut_torn_tail", "sync_directory", "whole_lines"]

_BLOCK = 1 << 16
"""Bytes read at once on the way back to the end of the last whole line."""


def whole_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Whole lines that are not blank, with their numbers, from 1."""
    lines = enumerate(read_lines(path), 1)
    yield from ((number, line) for number, line in lines if line.endswith(b"\n") and line.strip())


def append_line(handle: IO[bytes], path: Path, line: bytes) -> None:
    """Write one line, whole or not at all.

    Args:
        handle: The file, open for appending, without a buffer: what did not reach the disk is not tried again later.
        path: Where it lies.
        line: The line without its end.

    Raises:
        BadFile: If it cannot be written, as on a full disk.
    """
    end = os.fstat(handle.fileno()).st_size
    rest = line + b"\n"
    try:
        while rest:
            rest = rest[handle.write(rest) :]
    except OSError as error:
        with suppress(OSError):
            os.ftruncate(handle.fileno(), end)
        raise BadFile(path, f"cannot be written ({error.strerror})") from error


def cut_torn_tail(handle: IO[bytes], path: Path) -> None:
    """Cut an unfinished last line off, so that the next line starts clean.

    Args:
        handle: The file, open for appending.
        path: Where it lies.
    """
    with path.open("rb") as lines:
        end = whole = lines.seek(0, 2)
        while whole:
            begin = max(0, whole - _BLOCK)
            lines.seek(begin)
            if (last := lines.read(whole - begin).rfind(b"\n")) >= 0:
                whole = begin + last + 1
                break
            whole = begin
    if whole != end:
        handle.truncate(whole)
