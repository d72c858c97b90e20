"""The pictures of a study: files, each stored once under the hash of its content."""

from __future__ import annotations

from pathlib import Path

from lockprobe.foundation.storage.atomic_file import atomic_files, make_directory, writing
from lockprobe.trial.pictures.picture import Picture

ALBUM = "pictures"
"""Name of the directory of pictures in the directory of a study."""


def keep_picture(album: Path, picture: Picture) -> None:
    """Store a picture in a directory, unless it is there already. Several processes may do so at the same time.

    It is written atomically, before the record that names it, so no record names a missing picture.

    Raises:
        BadFile: If it cannot be written; the trial is then owed, and the run stops.
    """
    path = album / picture.name
    with writing(path):
        if path.is_file() and path.stat().st_size == len(picture.png):
            return
        make_directory(album)  # a study that was deleted does not come back
    with atomic_files(path, tidy=False) as (draft,):
        draft.write_bytes(picture.png)
