"""Links inside the directory of a study: none is followed for writing.

A directory may come from anywhere, and archives and Git carry symbolic links. So every writer of this package refuses a
path that leads through one below the outermost directory with a study in it. That directory itself, and what
is above it, may be a link: the person who names it chooses it. Elsewhere a link is followed.
"""

from __future__ import annotations

import os
from pathlib import Path

from lockprobe.foundation.errors import BadFile

MARK = "study.json"
"""The file by which a directory is that of a study."""


def refuse_links(path: Path, *, within: Path | None = None) -> None:
    """Refuse to write to a path, which need not exist, that leads through a link inside the directory of a study.

    ``within`` is the directory of a study that has no settings yet.
    """
    whole = _absolute(path)
    above = list(reversed(whole.parents))
    root = _absolute(within) if within is not None else next(filter(_is_marked, above), None)
    if root is None or whole.parts[: len(root.parts)] != root.parts:
        return
    for one in [*above, whole][len(root.parts) :]:
        if one.is_symlink():
            raise BadFile(one, f"is a link inside the directory of a study ({root}), which is not followed: remove it")


def make_directory(path: Path, *, mode: int = 0o777) -> None:
    """Make a directory, unless it is there; its parent exists."""
    refuse_links(path)
    path.mkdir(mode=mode, exist_ok=True)


def _absolute(path: Path) -> Path:
    """The path from the root on, with its links; what comes before dots is resolved, as the system does."""
    full = Path.cwd() / path
    if ".." not in full.parts:
        return full
    last = len(full.parts) - full.parts[::-1].index("..")
    return Path(os.path.realpath(Path(*full.parts[:last])), *full.parts[last:])


def _is_marked(directory: Path) -> bool:
    return os.path.lexists(os.path.join(directory, MARK))  # noqa: PTH118 - four times as fast
