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

from lockprobe.foundation.errors import BadFile, NotHere

LARGEST_INPUT = 1 << 28
"""Bytes of a file that is read at once, and of a line of a longer one: 256 MiB."""

LARGEST_TOML = 64 * 1024
"""Bytes of a TOML file; a larger one is refused unread."""

PRESETS = Path(__file__).parents[1] / "presets"
"""The studies that ship, a TOML file each."""


def is_there(path: Path) -> bool:
    """Whether a regular file is there; links are followed.

    Pipes, devices, sockets and directories are refused, because reading them may never end.
    """
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
    except FileNotFoundError:
        return False
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if not regular:
        raise BadFile(path, "not a regular file")
    return True


def read_input(path: Path, most: int = LARGEST_INPUT) -> bytes:
    """The content of a regular file of at most ``most`` bytes; nobody is waited for at the other end of a pipe."""
    try:
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise BadFile(path, "not a regular file")
            content = file.read(most + 1)
    except FileNotFoundError:
        raise NotHere(path) from None
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from None
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
