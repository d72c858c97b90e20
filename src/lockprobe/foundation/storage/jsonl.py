"""Append-only files of JSON lines that survive a crash, with a checksum in each line.

Each line is handed to the operating system at once, so a killed process loses at most its last line. When the machine
itself goes down, lines that were not forced to the disk (fsync) are lost. A line that a crash tore is ignored, and a
change by any other process ends the writing.

Characters that end a line for some readers, and not in JSON, are escaped (:func:`one_line`).

The checksum is the last field of the object, ``crc``: eight hexadecimal digits, the CRC-32 (:func:`zlib.crc32`) of all
bytes of the line before ``,"crc"``. A line that was changed by a single bit, or has no checksum, is refused.
"""

from __future__ import annotations

import os
import re
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TypeVar

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import check_regular, read_lines
from lockprobe.foundation.storage.links import refuse_links

_Value = TypeVar("_Value")

_BLOCK = 1 << 16
"""Bytes read at once on the way back to the end of the last whole line."""

_TAIL = 64
"""Bytes at the end of a file that are compared before a line is appended."""


@dataclass(frozen=True, slots=True)
class State:
    """A file as its writer left it.

    Attributes:
        device: Number of the file system.
        inode: Number of the file there.
        size: Bytes.
        tail: Its last bytes, at most 64.
    """

    device: int
    inode: int
    size: int
    tail: bytes


def whole_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Whole lines that are not blank, with their numbers, from 1."""
    lines = enumerate(read_lines(path), 1)
    yield from ((number, line) for number, line in lines if line.endswith(b"\n") and line.strip())


def state_of(path: Path) -> State | None:
    """A file as it is now; None where there is none."""
    check_regular(path)
    with suppress(OSError), path.open("rb", buffering=0) as file:
        return _state(file.fileno())
    return None


class LineFile:
    """A file to which only this process appends. Before each line it checks whether anybody else changed the file.

    The first change by anybody else ends the writing for good.

    Args:
        path: Where it lies; made if it is not there.
        left: How this process left it when it closed it; None takes it as it is.
        rescue: Whether lines that cannot be appended are written to a second file, ``NAME.rescued``.

    Attributes:
        path: Where it lies. Set it anew when the file is renamed.
        used: Whether a line was to be appended since it was opened.

    Raises:
        BadFile: If it cannot be opened, a link inside the directory of a study leads to it, or it has a second name (a
            hard link), since what is appended would change that file too.
    """

    def __init__(self, path: Path, *, left: State | None = None, rescue: bool = True) -> None:
        self.path, self.used = path, False
        refuse_links(path)
        check_regular(path)
        try:
            self._file: IO[bytes] = path.open("a+b", buffering=0)  # what did not reach the disk is not tried again
        except OSError as error:
            raise BadFile(path, f"cannot be written ({error.strerror})") from error
        if os.fstat(self.fileno()).st_nlink > 1:
            self._file.close()
            raise BadFile(
                path, "has a second name elsewhere (a hard link), which would be written too: put a copy here"
            )
        self._left = left or _state(self.fileno())
        self._rescue = _Rescue(self) if rescue else None

    @property
    def left(self) -> State:
        """The file as this process left it."""
        return self._left

    def fileno(self) -> int:
        """The number of the open file, for the system."""
        return self._file.fileno()

    def append(self, line: bytes, *, sync: bool = False) -> None:
        """Write one line, given without its end, whole or not at all; ``sync`` waits until the disk itself has it.

        Raises:
            BadFile: If it cannot be written, as on a full disk, or if another process has changed the file.
        """
        self.used = True
        if changed := self._changed():
            raise BadFile(self.path, self._stopped(changed, line))
        end, rest = self._left.size, line + b"\n"
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
            if sync:
                os.fsync(self.fileno())
        except OSError as error:
            with suppress(OSError):
                os.ftruncate(self.fileno(), end)
            raise BadFile(self.path, f"cannot be written ({error.strerror})") from error
        tail = (self._left.tail + line + b"\n")[-_TAIL:]
        self._left = State(self._left.device, self._left.inode, end + len(line) + 1, tail)

    def check(self) -> None:
        """Raise :class:`BadFile` if another process has changed the file."""
        if changed := self._changed():
            raise BadFile(self.path, self._stopped(changed))

    def cut_torn_tail(self) -> None:
        """Cut off an unfinished last line, so that the next line starts clean."""
        whole = _end_of_whole_lines(self.fileno(), self._left.size)
        if whole != self._left.size:
            self._file.truncate(whole)
            self._left = _state(self.fileno())

    def sync(self) -> None:
        """Force what was written to the disk (fsync). Raises OSError if it cannot."""
        os.fsync(self.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _changed(self) -> str:
        """What anybody else did to the file, in one word; empty where nobody did anything."""
        try:
            there = self.path.stat()
        except OSError:
            return "deleted"
        if _state(self.fileno()) != self._left:
            return "changed"
        return "" if (there.st_dev, there.st_ino) == (self._left.device, self._left.inode) else "replaced"

    def _stopped(self, changed: str, line: bytes | None = None) -> str:
        """Why nothing more is written, and where that is which could not be."""
        if not self.path.parent.is_dir():
            return "its directory was deleted or moved while it was being written, so this ends here"
        said = f"{changed} by somebody else while it was being written (an editor, a cloud client?), so this ends here"
        kept = self._rescue.keep(line, whole=changed != "changed") if self._rescue is not None else ""
        return f"{said}{kept}"


class _Rescue:
    """The second file, for lines that could not be appended."""

    def __init__(self, of: LineFile) -> None:
        self._of = of
        self._path: Path | None = None
        self._kept: set[bytes] = set()

    def keep(self, line: bytes | None, *, whole: bool) -> str:
        """Write a line there, once, and return what to do with it, as the end of a sentence.

        ``whole`` begins with all lines of the file, because it has lost its name.
        """
        if line is None and not whole:
            return ""
        try:
            if self._path is None:
                number, name = 1, self._of.path.with_name(f"{self._of.path.name}.rescued")
                while name.exists():
                    number += 1
                    name = self._of.path.with_name(f"{self._of.path.name}.rescued-{number}")
                self._path = name
                with self._path.open("xb") as file:
                    for block in _blocks(self._of.fileno()) if whole else ():
                        file.write(block)
            if line is not None and line not in self._kept:
                with self._path.open("ab") as file:
                    file.write(line + b"\n")
                self._kept.add(line)
        except OSError as error:
            return f"; {self._path} cannot be written either ({error.strerror})"
        what = "all that was written" if whole else "what was still to be written"
        how = "put it in its place, or append it to it" if whole else "append it"
        return f"; {what} is in {self._path.name}: {how}, and start again"


def rescued_files(path: Path) -> list[Path]:
    """The files next to a file of lines that took what could not be appended to it."""
    return sorted(path.parent.glob(f"{path.name}.rescued*"))


def _state(handle: int) -> State:
    """An open file as it is now."""
    found = os.fstat(handle)
    tail = os.pread(handle, _TAIL, max(0, found.st_size - _TAIL))
    return State(found.st_dev, found.st_ino, found.st_size, tail)


def _blocks(handle: int) -> Iterator[bytes]:
    """All that stands in an open file, from its first byte to the end of its last whole line."""
    begin, end = 0, _end_of_whole_lines(handle, os.fstat(handle).st_size)
    while begin < end and (block := os.pread(handle, min(_BLOCK, end - begin), begin)):
        yield block
        begin += len(block)


def _end_of_whole_lines(handle: int, size: int) -> int:
    """Where the last whole line of an open file ends."""
    whole = size
    while whole:
        begin = max(0, whole - _BLOCK)
        if (last := os.pread(handle, whole - begin, begin).rfind(b"\n")) >= 0:
            return begin + last + 1
        whole = begin
    return 0


_CHECKSUM = re.compile(rb',"crc":"([0-9a-f]{8})"\}\s*\Z')
_CHECKSUM_LENGTH = len(b',"crc":"00000000"}\r\n')


def one_line(line: bytes) -> bytes:
    r"""A line of JSON with its U+0085, U+2028 and U+2029 escaped: :meth:`str.splitlines` would cut it there.

    >>> one_line('{"a":"one\u2028two"}'.encode())
    b'{"a":"one\\u2028two"}'
    """
    for end in "\x85\u2028\u2029":
        line = line.replace(end.encode(), b"\\u%04x" % ord(end))
    return line


def with_checksum(line: bytes) -> bytes:
    """A line (:func:`one_line`) with its checksum. It is a JSON object that is not empty, without a newline.

    >>> with_checksum(b'{"a":1}')
    b'{"a":1,"crc":"a702fc6e"}'
    """
    said = one_line(line)[:-1]
    return said + b',"crc":"%08x"}' % zlib.crc32(said)


def without_checksum(line: bytes) -> bytes:
    """A line without its checksum, which is checked.

    Raises:
        BadValue: If there is none, or it is not that of the line.
    """
    return line[: checked_length(line)] + b"}"


def checked_length(line: bytes) -> int:
    """The number of bytes before the checksum of a line, which is checked.

    Raises:
        BadValue: If there is none, or it is not that of the line.
    """
    found = _CHECKSUM.search(line, max(0, len(line) - _CHECKSUM_LENGTH))
    if found is None:
        raise BadValue("checksum", "none", "one at the end of the line")
    if (own := zlib.crc32(memoryview(line)[: found.start()])) != int(found[1], 16):
        raise BadValue("checksum", found[1].decode(), f"{own:08x}: the line was changed")
    return found.start()


def read_values(path: Path, adapter: TypeAdapter[_Value]) -> Iterator[_Value]:
    """The values on the whole lines of a file, each with its checksum.

    Raises:
        BadFile: If a line is damaged, or holds no such value.
    """
    for number, line in whole_lines(path):
        try:
            yield adapter.validate_json(without_checksum(line), strict=True, extra="forbid")
        except ValidationError as error:
            raise BadFile(path, f"line {number}: {error.errors()[0]['msg']}") from None
        except BadValue as error:
            raise BadFile(path, f"line {number}: {error}") from None
