"""Atomic file replacement: readers see either the complete new file or the old one.

A file is written as a draft in the same directory, forced to the disk (fsync), and renamed (``os.replace``). An error
leaves what was there before and no draft. The draft of a file that exists has its permissions from the first byte on.
A directory is written the same way where there was none, or an empty one.

A process that is killed may leave a draft, a hidden file of a random name such as ``.0123456789ab.draft.csv``. It is
locked while its process lives, and the next writer in the directory deletes those that are not.

Only regular files are replaced. A link is followed, except inside the directory of a study (:mod:`~.links`): the file
that it leads to is replaced, and the link stays. Devices, pipes, sockets and directories are refused, because a rename
would put a file where they were. All that goes wrong is a ``BadFile`` that names the path.
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

    Attributes:
        draft: Its path, with the ending of the file's name. The draft does not exist yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._held = ExitStack()
        refuse_links(path)
        with writing(path, (OSError, ValueError)):
            kind = irregular(path)
            self._target = target = Path(os.path.realpath(path))
        if kind:
            raise BadFile(path, f"is {kind}, not a regular file: choose another name")
        if not target.parent.is_dir():
            raise BadFile(path, "cannot be written (No such file or directory)")
        if target.exists() and not os.access(target, os.W_OK):
            raise BadFile(path, "cannot be written (Permission denied)")
        self.draft = _draft_of(target).with_suffix(f".draft{target.suffix}")

    def create(self, mode: int = 0o666) -> None:
        """Make an empty draft; ``mode`` is for a new file, less the umask."""
        with writing(self._path):
            if self._target.exists():
                mode = stat.S_IMODE(self._target.stat().st_mode) | stat.S_IWUSR
            while not self.draft.exists():  # another writer may delete it before it is locked
                self._held.close()
                descriptor = os.open(self.draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
                self._held.callback(os.close, descriptor)
                with suppress(OSError):  # a file system without locks
                    fcntl.flock(descriptor, fcntl.LOCK_EX)

    def sync(self) -> None:
        """Force the draft to the disk, with the permissions of the file that is there."""
        refuse_links(self._path)
        with writing(self._path):
            if self._target.exists():
                self.draft.chmod(stat.S_IMODE(self._target.stat().st_mode))
            _sync(self.draft)

    def rename(self) -> None:
        """Rename the draft, which :meth:`sync` has forced to the disk, to the file's name."""
        with writing(self._path):
            self.draft.replace(self._target)
        self._held.close()
        with suppress(OSError):  # it is in its place already
            _sync(self._target.parent)

    def drop(self) -> None:
        """Delete the draft. After :meth:`rename` it does nothing."""
        self._held.close()
        with suppress(OSError):
            self.draft.unlink()


@contextmanager
def atomic_files(*paths: Path, mode: int = 0o666) -> Iterator[list[Path]]:
    """The drafts of some files; they become the files when the block ends without an error, and are deleted otherwise.

    None is put in its place before all are on the disk, and the last of them last. Their directories exist. ``mode`` is
    for a file that does not, less the umask; any other keeps its own.
    """
    replacements = [Replacement(path) for path in paths]
    try:
        for directory in {replacement.draft.parent for replacement in replacements}:
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


def write_files(files: Mapping[Path, str | bytes], *, mode: int = 0o666) -> None:
    """Write files, as :func:`atomic_files` does, text as UTF-8 with its own line ends."""
    with atomic_files(*files, mode=mode) as drafts:
        for draft, (path, content) in zip(drafts, files.items(), strict=True):
            with writing(path):
                draft.write_bytes(content.encode() if isinstance(content, str) else content)


def write_file(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a file, as :func:`write_files` does."""
    write_files({path: content}, mode=mode)


def write_private(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a file, as :func:`write_file` does, into a directory that is made for this user alone if it is missing."""
    refuse_links(path)
    with writing(path):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_file(path, content, mode=mode)


def remove_file(path: Path) -> None:
    """Delete a file, if it is there; a link itself is deleted."""
    refuse_links(path.parent)
    path.unlink(missing_ok=True)


class NewDirectory:
    """A draft of a directory that does not exist or is empty: it is filled, and becomes the directory or is dropped."""

    def __init__(self, path: Path) -> None:
        self._path, self._target = path, Path(os.path.realpath(path))
        self.draft = _draft_of(self._target)
        refuse_links(path)
        with writing(path):
            self.draft.mkdir(parents=True)

    def commit(self) -> None:
        """Force every file of the draft to the disk, and rename it to the directory's name."""
        with writing(self._path):
            for directory, _, names in os.walk(self.draft):
                for name in (*names, "."):
                    _sync(Path(directory, name))
            self.draft.replace(self._target)
            _sync(self._target.parent)

    def drop(self) -> None:
        """Delete the draft. After :meth:`commit` it does nothing."""
        shutil.rmtree(self.draft, ignore_errors=True)


def _draft_of(target: Path) -> Path:
    """A hidden name beside a file or a directory that nothing has."""
    return target.parent / f".{secrets.token_hex(6)}.draft"


def _sync(path: Path) -> None:
    """Force a file, or the list of a directory's files, to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _remove_drafts_of_the_killed(directory: Path) -> None:
    """Delete the drafts that no process has locked."""
    for draft in directory.glob(f".{'[0-9a-f]' * 12}.draft*"):
        with suppress(OSError):
            held = os.open(draft, os.O_WRONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
                draft.unlink()
            finally:
                os.close(held)


@contextmanager
def writing(path: Path, errors: type[Exception] | tuple[type[Exception], ...] = OSError) -> Iterator[None]:
    """Turn errors of writing into the mistake that a path cannot be written."""
    try:
        yield
    except errors as error:
        raise BadFile(path, f"cannot be written ({getattr(error, 'strerror', None) or error})") from error
