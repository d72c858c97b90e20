"""Atomic file replacement: readers see either the complete new file or the old one.

A file is written as a draft in the same directory, forced to the disk (fsync), and renamed (``os.replace``). An error
leaves what was there before and no draft. The draft of a file that exists has its permissions from the first byte on.

A process that is killed may leave a draft, a hidden file. Where several processes may write one file its name is random
and ends like ``.draft.csv``. It is locked while its process lives, and the next writer in the directory deletes those
that are not. Where one process writes alone, as under the lock of a study, it is ``.NAME.draft``, and the next writer
of the file deletes it.

A directory is written the same way where there was none, or an empty one.

Only regular files are replaced. A link is followed, except inside the directory of a study (:mod:`~.links`): the file
that it leads to is replaced, and the link stays. Devices, pipes, sockets and directories are refused, because a rename
would put a file where they were.
"""

from __future__ import annotations

import fcntl
import os
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import irregular
from lockprobe.foundation.storage.links import refuse_links


class Replacement:
    """A draft of a file, which replaces the file or is dropped.

    ``alone`` says that no other process writes the file meanwhile.

    Attributes:
        draft: Its path. The draft does not exist yet. Unless ``alone``, it has the ending of the file's name.

    Raises:
        BadFile: If the path is no regular file, or cannot be written, also in a method; the file is then as it was.
    """

    def __init__(self, path: Path, *, alone: bool = False) -> None:
        self._path, self._alone = path, alone
        self._held = ExitStack()
        self._target = _target(path)
        name = f".{secrets.token_hex(6)}.draft{self._target.suffix}"
        self.draft = _own_draft(self._target) if alone else self._target.with_name(name)

    def create(self, mode: int = 0o666) -> None:
        """Make an empty draft, also where a killed process left one; ``mode`` is for a new file, less the umask."""
        with writing(self._path):
            if self._target.exists():
                mode = stat.S_IMODE(self._target.stat().st_mode) | stat.S_IWUSR
            self.draft.unlink(missing_ok=True)
            while not self.draft.exists():  # another writer may delete it before it is locked
                self._held.close()
                descriptor = os.open(self.draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
                self._held.callback(os.close, descriptor)
                if not self._alone:
                    with suppress(OSError):  # a file system without locks
                        fcntl.flock(descriptor, fcntl.LOCK_EX)

    def sync(self) -> None:
        """Force the draft to the disk, with the permissions of the file that is there."""
        with writing(self._path):
            if _target(self._path).exists():
                self.draft.chmod(stat.S_IMODE(self._target.stat().st_mode))
            _sync(self.draft)

    def rename(self) -> None:
        """Rename the draft, which :meth:`sync` has forced to the disk, to the file's name."""
        with writing(self._path):
            self.draft.replace(self._target)
        self._held.close()
        with suppress(OSError):  # it is in its place already
            sync_directory(self._target.parent)

    def drop(self) -> None:
        """Delete the draft. After :meth:`rename` it does nothing."""
        self._held.close()
        with suppress(OSError):
            self.draft.unlink()


@contextmanager
def atomic_files(*paths: Path, alone: bool = False, mode: int = 0o666) -> Iterator[list[Path]]:
    """The drafts of some files; they become the files when the block ends without an error, and are deleted otherwise.

    None is put in its place before all are on the disk.

    Args:
        paths: Where the files belong; their directories exist. The last is put in its place last.
        alone: Whether no other process writes the files meanwhile.
        mode: Permissions of a file that does not exist, less the umask; any other keeps its own.

    Raises:
        BadFile: If a path is no regular file, or a file cannot be written.
    """
    replacements = [Replacement(path, alone=alone) for path in paths]
    try:
        for directory in {replacement.draft.parent for replacement in replacements if not alone}:
            _remove_drafts_of_the_killed(directory)
        for replacement in replacements:
            replacement.create(mode)
        with writing(paths[-1]):
            yield [replacement.draft for replacement in replacements]
        for replacement in replacements:
            replacement.sync()
        for replacement in replacements:
            replacement.rename()
    finally:
        for replacement in replacements:
            replacement.drop()


def write_file(path: Path, content: str | bytes, *, alone: bool = False, mode: int = 0o666) -> None:
    """Write a file, as :func:`write_files` does."""
    write_files({path: content}, alone=alone, mode=mode)


def write_private(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a file that no other process writes, into a directory that is made for this user alone if it is missing.

    ``mode`` holds for a new file, less the umask.

    Raises:
        BadFile: If it is no regular file, or cannot be written.
    """
    refuse_links(path)
    with writing(path):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_file(path, content, alone=True, mode=mode)


def remove_file(path: Path) -> None:
    """Delete a file that one process writes alone, if it is there, and the draft of it that a killed process left.

    Raises:
        BadFile: If a link inside the directory of a study leads to it; a link itself is deleted.
        OSError: If that is not possible.
    """
    refuse_links(path.parent)
    _own_draft(path).unlink(missing_ok=True)
    path.unlink(missing_ok=True)


def write_files(files: Mapping[Path, str | bytes], *, alone: bool = False, mode: int = 0o666) -> None:
    """Write files, text as UTF-8 with its own line ends. None is replaced before all are on the disk.

    Arguments and errors are those of :func:`atomic_files`.
    """
    with atomic_files(*files, alone=alone, mode=mode) as drafts:
        for draft, (path, content) in zip(drafts, files.items(), strict=True):
            with writing(path):
                draft.write_bytes(content.encode() if isinstance(content, str) else content)


class NewDirectory:
    """A draft of a directory that does not exist or is empty; it becomes the directory or is dropped.

    Attributes:
        draft: The directory that is filled.

    Raises:
        BadFile: If it cannot be made, or later not be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._target = Path(os.path.realpath(path))
        self.draft = self._target.parent / f".{secrets.token_hex(6)}.draft"
        refuse_links(path)
        with writing(path):
            self.draft.mkdir(parents=True)

    def commit(self) -> None:
        """Force every file of the draft to the disk, and rename it to the directory's name."""
        try:
            with writing(self._path):
                for directory, _, names in os.walk(self.draft):
                    for name in names:
                        _sync(Path(directory, name))
                    sync_directory(Path(directory))
                self.draft.replace(self._target)
                sync_directory(self._target.parent)
        finally:
            self.drop()

    def drop(self) -> None:
        """Delete the draft. After :meth:`commit` it does nothing."""
        shutil.rmtree(self.draft, ignore_errors=True)


def sync_directory(directory: Path) -> None:
    """Force the list of a directory's files to the disk. Raises OSError if it cannot be read."""
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
    refuse_links(path)
    with writing(path, (OSError, ValueError)):
        kind = irregular(path)
        found = Path(os.path.realpath(path))
    if kind:
        raise BadFile(path, f"is {kind}, not a regular file: choose another name")
    if not found.parent.is_dir():
        raise BadFile(path, "cannot be written (No such file or directory)")
    if found.exists() and not os.access(found, os.W_OK):
        raise BadFile(path, "cannot be written (Permission denied)")
    return found


def _remove_drafts_of_the_killed(directory: Path) -> None:
    """Delete the drafts of random name that no process has locked."""
    for draft in directory.glob(f".{'[0-9a-f]' * 12}.draft*"):
        with suppress(OSError):
            held = os.open(draft, os.O_WRONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
                draft.unlink()
            finally:
                os.close(held)


def _own_draft(target: Path) -> Path:
    """The draft of a file that one process writes alone."""
    return target.with_name(f".{target.name}.draft")


@contextmanager
def writing(path: Path, errors: type[Exception] | tuple[type[Exception], ...] = OSError) -> Iterator[None]:
    """Turn errors of writing into the mistake that a path cannot be written.

    Raises:
        BadFile: If the body raises one of ``errors``.
    """
    try:
        yield
    except errors as error:
        raise BadFile(path, f"cannot be written ({getattr(error, 'strerror', None) or error})") from error
