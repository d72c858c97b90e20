"""Bounded reading of files from elsewhere: no pipes, no devices, no file or line above a size limit."""

from __future__ import annotations

import json
import stat
import tomllib
from collections.abc import Iterator
from pathlib import Path

from lockprobe.errors import BadFile

__all__ = [
    "LARGEST_INPUT",
    "LARGEST_TOML",
    "check_regular",
    "irregular",
    "parse_json",
    "read_input",
    "read_lines",
    "read_toml",
]

LARGEST_INPUT = 1 << 28
"""Bytes of a file that is read at once, and of a line of a longer one: 256 MiB."""

LARGEST_TOML = 64 * 1024
"""Bytes of a TOML file; a larger one is refused unread."""

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a directory",
}


def irregular(path: Path) -> str:
    """What a path leads to that is no regular file, for example ``a pipe``; empty for a regular one, and for nothing.

    Raises:
        OSError: If it cannot be looked at.
        ValueError: If it is no path: a name with a null character.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return ""
    return "" if stat.S_ISREG(mode) else _KINDS.get(stat.S_IFMT(mode), "something else")


def check_regular(path: Path) -> None:
    """Refuse what is there and is no regular file: to read a pipe or a device may never end.

    Args:
        path: Of the file; a link is followed. One that is not there is left to whoever opens it.

    Raises:
        BadFile: If it is a pipe, a device, a socket or a directory, or cannot be looked at.
    """
    try:
        kind = irregular(path)
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if kind:
        raise BadFile(path, f"{kind}, not a regular file")


def read_input(path: Path, most: int = LARGEST_INPUT) -> bytes:
    """The content of a file.

    Args:
        path: Of the file.
        most: Bytes above which it is refused.

    Raises:
        BadFile: If it is no regular file, is larger, or cannot be read.
    """
    check_regular(path)
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None
    if len(content) > most:
        raise BadFile(path, f"larger than {most} bytes")
    return content


def read_lines(path: Path, most: int = LARGEST_INPUT) -> Iterator[bytes]:
    """The lines of a file with their ends, one after another; the last may have none.

    Args:
        path: Of the file.
        most: Bytes of a line above which the file is refused.

    Raises:
        BadFile: If it is no regular file, has a longer line, or cannot be read.
    """
    check_regular(path)
    try:
        with path.open("rb") as file:
            number = 0
            while line := file.readline(most + 1):
                number += 1
                if len(line) > most:
                    raise BadFile(path, f"line {number}: longer than {most} bytes")
                yield line
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None


def parse_json(content: bytes | str, path: Path) -> object:
    """What a file of JSON says.

    Args:
        content: The content, in UTF-8.
        path: Of the file, for messages.

    Raises:
        BadFile: If it is no JSON, or nested more deeply than can be read.
    """
    try:
        return json.loads(content)
    except RecursionError:
        raise BadFile(path, "not JSON that can be read (nested too deeply)") from None
    except ValueError as error:
        raise BadFile(path, f"not JSON ({error})") from None


def read_toml(path: Path) -> dict[str, object]:
    """The tables of a TOML file of at most :data:`LARGEST_TOML`.

    Args:
        path: Of the file.

    Raises:
        BadFile: If it cannot be read, is too large or is not TOML.
    """
    content = read_input(path, LARGEST_TOML)
    try:
        return tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise BadFile(path, f"not TOML ({error})") from None
