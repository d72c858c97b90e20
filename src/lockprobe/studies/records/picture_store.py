"""The picture store of a study: content-addressed files, each stored once under the hash of its content."""

from __future__ import annotations

from pathlib import Path

from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import Replacement, writing
from lockprobe.foundation.storage.links import make_directory
from lockprobe.trial.pictures.picture import Picture

ALBUM = "pictures"
"""Name of the directory of pictures in the directory of a study."""


class Album:
    """A directory of pictures. Several processes may write to it at the same time.

    A picture is written atomically, before the record that names it, so no record names a missing picture.
    """

    def __init__(self, directory: Path | str) -> None:
        self._directory = Path(directory)

    def keep(self, picture: Picture) -> None:
        """Store a picture, unless it is there already.

        Raises:
            BadFile: If it cannot be written; the trial is then owed, and the run stops.
        """
        path = self._directory / picture.name
        with writing(path):
            if path.is_file() and path.stat().st_size == len(picture.png):
                return
            make_directory(self._directory)  # a study that was deleted does not come back
        new = Replacement(path)  # not write_file, which looks through the directory for drafts
        try:
            new.create()
            with writing(path):
                new.draft.write_bytes(picture.png)
            new.sync()
            new.rename()
        finally:
            new.drop()


def read_picture(directory: Path | str, name: str) -> bytes:
    """The content of a picture in the directory of a study."""
    path = Path(directory) / ALBUM / name
    return read_input(path)
