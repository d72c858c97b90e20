"""A file that is written at once: it is in its place whole, or what was there before is there still."""

from __future__ import annotations

import os
from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.studies.lines import sync_directory

__all__ = ["place"]


def place(path: Path, content: bytes) -> None:
    """Put a file in its place, whole or not at all, on the disk itself.

    Args:
        path: Where it belongs; its directory is made, for nobody else to read, if it is not there.
        content: What stands in it.

    Raises:
        BadFile: If it cannot be written.
    """
    draft = path.with_name(f".{path.name}.draft")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with draft.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
        sync_directory(path.parent)
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from error
