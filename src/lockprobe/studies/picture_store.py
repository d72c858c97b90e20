"""The pictures of a study on disk. Each is stored once, under a name made from its content."""

from __future__ import annotations

from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.pictures.picture import Picture
from lockprobe.storage.atomic_file import write_file

__all__ = ["ALBUM", "Album"]

ALBUM = "pictures"
"""Where in the directory of a study its pictures lie."""


class Album:
    """A directory of pictures. Several processes may write to one at the same time.

    A picture gets its name when it is whole, before the record that names it is written down, so that a record never
    names a picture that is not there.
    """

    def __init__(self, directory: Path | str) -> None:
        self._directory = Path(directory)

    def keep(self, picture: Picture) -> None:
        """Put a picture on disk, unless it is there.

        Raises:
            BadFile: If it cannot be written; the trial is then owed, and the run stops.
        """
        path = self._directory / picture.name
        try:
            if path.is_file() and path.stat().st_size == len(picture.png):
                return
            self._directory.mkdir(exist_ok=True)  # a study that was deleted does not come back
        except OSError as error:
            raise BadFile(path, f"cannot be written ({error.strerror or error})") from error
        write_file(path, picture.png)
