"""Bounded reading of files from elsewhere: no pipes, no devices, no file or line above a size limit.

What cannot be read is a ``BadFile`` that names the path.
"""

from __future__ import annotations

import json
import os
import stat
import tomllib
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile

LARGEST_INPUT = 1 << 28
"""Bytes of a file that is read at once, and of a line of a longer one: 256 MiB."""

LARGEST_TOML = 64 * 1024
"""Bytes of a TOML file; a larger one is refused unread."""

PRESETS = Path(__file__).parents[1] / "presets"
"""The studies that ship, a TOML file each."""

_BUFFER = 1 << 18
"""Bytes that are read at once."""

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a directory",
}


def irregular(path: Path) -> str:
    """The kind of an irregular file, for example ``a pipe``; empty for a regular file and for a missing one."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return ""
    return "" if stat.S_ISREG(mode) else _KINDS.get(stat.S_IFMT(mode), "something else")


def check_regular(path: Path) -> None:
    """Refuse pipes, devices, sockets and directories, because reading them may never end; a missing file passes.

    Links are followed.
    """
    try:
        kind = irregular(path)
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if kind:
        raise BadFile(path, f"{kind}, not a regular file")


def is_there(path: Path) -> bool:
    """Whether a regular file is there; what is there and is none is refused."""
    check_regular(path)
    return path.exists()


def read_input(path: Path, most: int = LARGEST_INPUT) -> bytes:
    """The content of a regular file of at most ``most`` bytes; where a pipe took its place nobody is waited for."""
    check_regular(path)
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb", _BUFFER) as file:  # noqa: PTH123 - of a number
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise BadFile(path, "not a regular file")
            content = file.read(most + 1)
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None
    if len(content) > most:
        raise BadFile(path, f"larger than {most} bytes")
    return content


def parse_json(content: bytes | str, path: Path) -> object:
    """Parse the UTF-8 content of a JSON file; messages name its path."""
    try:
        return json.loads(content)
    except RecursionError:
        raise BadFile(path, "not JSON that can be read (nested too deeply)") from None
    except ValueError as error:
        raise BadFile(path, f"not JSON ({error})") from None


def read_preset(name: str) -> dict[str, Any]:
    """The tables of a TOML file that ships with the package."""
    return tomllib.loads((PRESETS / f"{name}.toml").read_text("utf-8"))


def read_toml(path: Path) -> dict[str, object]:
    """The tables of a TOML file of at most :data:`LARGEST_TOML`."""
    content = read_input(path, LARGEST_TOML)
    try:
        return tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise BadFile(path, f"not TOML ({error})") from None
