"""Atomic file replacement: readers see either the complete new file or the old one.

A file is written as a draft beside its place, forced to the disk (fsync), and renamed to its name (``os.replace``). An
error leaves what was there before and no draft; a process that is killed may leave a hidden file that ends like
``.draft.csv``.

A directory is written the same way where there was none, or an empty one.

Only regular files are replaced. A link is followed: the file that it leads to is replaced, and the link stays. Devices,
pipes, sockets and directories are refused, because a rename would put a file where they were.
"""

from __future__ import annotations

import os
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from lockprobe.errors import BadFile

__all__ = [
    "NewDirectory",
    "Replacement",
    "atomic_directory",
    "atomic_file",
    "atomic_files",
    "sync_directory",
    "write_file",
    "write_files",
]

_KINDS = (
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)


class Replacement:
    """A file that is about to be replaced: a draft is written, and then put in its place, or dropped.

    Args:
        path: Where the file belongs; its directory exists.

    Attributes:
        draft: Where it is written until it is complete. It has the ending of the file's name, and does not exist yet.

    Raises:
        BadFile: If the path is no regular file, or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._target = _target(path)
        self.draft = self._target.with_name(f".{secrets.token_hex(6)}.draft{self._target.suffix}")

    def sync(self) -> None:
        """Force the draft to the disk, with the permissions of the file that is there.

        Raises:
            BadFile: If that is not possible; what was there before is there still.
        """
        try:
            if _target(self._path).exists():
                self.draft.chmod(stat.S_IMODE(self._target.stat().st_mode))
            _sync(self.draft)
        except OSError as error:
            raise _unwritable(self._path, error) from error

    def rename(self) -> None:
        """Rename the draft, which :meth:`sync` has forced to the disk, to the file's name.

        Raises:
            BadFile: If that is not possible; what was there before is there still.
        """
        try:
            self.draft.replace(self._target)
            sync_directory(self._target.parent)
        except OSError as error:
            raise _unwritable(self._path, error) from error

    def drop(self) -> None:
        """Delete the draft. After :meth:`rename` it does nothing."""
        self.draft.unlink(missing_ok=True)


@contextmanager
def atomic_files(*paths: Path) -> Iterator[list[Path]]:
    """The drafts of some files; they become the files when the block ends without an error, and are deleted otherwise.

    None is put in its place before all are on the disk.

    Args:
        paths: Where the files belong; their directories exist. The last is put in its place last.

    Raises:
        BadFile: If a path is no regular file, or a file cannot be written.
    """
    replacements = [Replacement(path) for path in paths]
    try:
        yield [replacement.draft for replacement in replacements]
        for replacement in replacements:
            replacement.sync()
        for replacement in replacements:
            replacement.rename()
    except OSError as error:
        raise _unwritable(paths[-1], error) from error
    finally:
        for replacement in replacements:
            replacement.drop()


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """The draft of one file, as :func:`atomic_files` has it."""
    with atomic_files(path) as (draft,):
        yield draft


def write_file(path: Path, content: str | bytes) -> None:
    """Write a file, as :func:`write_files` does."""
    write_files({path: content})


def write_files(files: Mapping[Path, str | bytes]) -> None:
    """Write some files: nothing is replaced before all of them are on the disk.

    Args:
        files: What stands in each; text is written as UTF-8, with the ends of lines that it has.

    Raises:
        BadFile: If a path is no regular file, or a file cannot be written.
    """
    with atomic_files(*files) as drafts:
        for draft, (path, content) in zip(drafts, files.items(), strict=True):
            try:
                draft.write_bytes(content.encode() if isinstance(content, str) else content)
            except OSError as error:
                raise _unwritable(path, error) from error


class NewDirectory:
    """A directory that is about to exist: a draft is filled, and then put in its place, or dropped.

    Args:
        path: Of the directory; it does not exist, or is empty.

    Attributes:
        draft: The directory that is filled.

    Raises:
        BadFile: If it cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._target = Path(os.path.realpath(path))
        self.draft = self._target.parent / f".{secrets.token_hex(6)}.draft"
        try:
            self.draft.mkdir(parents=True)
        except OSError as error:
            raise _unwritable(path, error) from error

    def commit(self) -> None:
        """Force every file of the draft to the disk, and rename it to the directory's name.

        Raises:
            BadFile: If that is not possible.
        """
        try:
            for directory, _, names in os.walk(self.draft):
                for name in names:
                    _sync(Path(directory, name))
                sync_directory(Path(directory))
            self.draft.replace(self._target)
            sync_directory(self._target.parent)
        except OSError as error:
            raise _unwritable(self._path, error) from error
        finally:
            self.drop()

    def drop(self) -> None:
        """Delete the draft. After :meth:`commit` it does nothing."""
        shutil.rmtree(self.draft, ignore_errors=True)


@contextmanager
def atomic_directory(path: Path) -> Iterator[Path]:
    """The draft of a directory; it becomes the directory when the block ends without an error.

    Args:
        path: Of the directory; it does not exist, or is empty.

    Raises:
        BadFile: If it cannot be written.
    """
    new = NewDirectory(path)
    try:
        yield new.draft
        new.commit()
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        new.drop()


def sync_directory(directory: Path) -> None:
    """Wait until the disk knows which files a directory holds.

    Raises:
        OSError: If it cannot be read.
    """
    handle = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _sync(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _target(path: Path) -> Path:
    """The regular file that a path names, or where a new one belongs."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        found = Path(os.path.realpath(path))
        if not found.parent.is_dir():
            raise BadFile(path, "cannot be written (No such file or directory)") from None
        return found
    except OSError as error:
        raise _unwritable(path, error) from error
    if not stat.S_ISREG(mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(mode)), "something else")
        raise BadFile(path, f"is {kind}, not a regular file: choose another name")
    found = Path(os.path.realpath(path))
    if not os.access(found, os.W_OK):
        raise BadFile(path, "cannot be written (Permission denied)")
    return found


def _unwritable(path: Path, error: OSError) -> BadFile:
    return BadFile(path, f"cannot be written ({error.strerror or error})")
