"""Atomic file replacement: readers see either the complete new file or the old one.

A file is written as a draft in the same directory, forced to the disk (fsync), and renamed (``os.replace``). An error
leaves what was there before and no draft. The draft of a file that exists has its permissions from the first byte on.

A process that is killed may leave a draft, a hidden file of a random name such as ``.0123456789ab.draft.csv``. It is
locked while its process lives, and the next writer in the directory deletes those that are not.

Only regular files are replaced. Devices, pipes, sockets and directories are refused, because a rename would put a file
where they were. A link is followed: the file that it leads to is replaced, and the link stays. But none is followed
below the outermost directory with a study in it: that may come from anywhere, and archives and Git carry links. That
directory itself, and what is above it, may be a link: the person who names it chooses it.
"""

from __future__ import annotations

import fcntl
import os
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import irregular

_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL

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


def _absolute(path: Path) -> Path:
    """The path from the root on, with its links; what comes before dots is resolved, as the system does."""
    full = Path.cwd() / path
    if ".." not in full.parts:
        return full
    last = len(full.parts) - full.parts[::-1].index("..")
    return Path(os.path.realpath(Path(*full.parts[:last])), *full.parts[last:])


def _is_marked(directory: Path) -> bool:
    return os.path.lexists(os.path.join(directory, MARK))  # noqa: PTH118 - four times as fast


@contextmanager
def writing(path: Path, errors: type[Exception] | tuple[type[Exception], ...] = OSError) -> Iterator[None]:
    """Turn errors of writing into the mistake that a path cannot be written."""
    try:
        yield
    except errors as error:
        raise BadFile(path, f"cannot be written ({getattr(error, 'strerror', None) or error})") from error


class Replacement:
    """A draft of a file, which replaces the file or is dropped.

    Attributes:
        draft: Its path, with the ending of the file's name. The draft does not exist yet.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._held = path, ExitStack()
        refuse_links(path)
        with writing(path, (OSError, ValueError)):
            kind = irregular(path)
            self._target = target = Path(os.path.realpath(path))
            if kind:
                raise BadFile(path, f"is {kind}, not a regular file: choose another name")
            if target.exists() and not os.access(target, os.W_OK):
                raise BadFile(path, "cannot be written (Permission denied)")
        self.draft = target.parent / f".{secrets.token_hex(6)}.draft{target.suffix}"

    def create(self, mode: int = 0o666) -> None:
        """Make an empty draft; ``mode`` is for a new file, less the umask, and another keeps its own."""
        with writing(self._path):
            own = stat.S_IMODE(self._target.stat().st_mode) if self._target.exists() else None
            while not self.draft.exists():  # another writer may delete it before it is locked
                self._held.close()
                descriptor = os.open(self.draft, _NEW, mode if own is None else own)
                self._held.callback(os.close, descriptor)
                if own is not None:  # whatever the umask says
                    os.fchmod(descriptor, own)
                with suppress(OSError):  # a file system without locks
                    fcntl.flock(descriptor, fcntl.LOCK_EX)

    def sync(self) -> None:
        """Force the draft to the disk."""
        with writing(self._path):
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


def _warily(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK)


def _sync(path: Path) -> None:
    """Force a file, or the list of a directory's files, to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def atomic_files(*paths: Path, mode: int = 0o666, tidy: bool = True) -> Iterator[list[Path]]:
    """The drafts of some files; they become the files when the block ends without an error, and are deleted otherwise.

    None is put in its place before all are on the disk, and the last of them last. Their directories exist. ``mode`` is
    for a file that does not, less the umask; any other keeps its own. Without ``tidy`` nobody looks for the drafts of
    the killed, which takes long in a directory of many files.
    """
    replacements = [Replacement(path) for path in paths]
    try:
        for directory in {replacement.draft.parent for replacement in replacements if tidy}:
            for draft in directory.glob(f".{'[0-9a-f]' * 12}.draft*"):
                with suppress(OSError), open(draft, "rb", opener=_warily) as left:  # one that no process has locked
                    fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    draft.unlink()
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
    make_directory(path.parent, mode=0o700)
    write_file(path, content, mode=mode)


def make_directory(path: Path, *, mode: int = 0o777) -> None:
    """Make a directory with those above it, unless it is there."""
    refuse_links(path)
    with writing(path):
        path.mkdir(mode=mode, parents=True, exist_ok=True)


def remove_file(path: Path) -> None:
    """Delete a file, if it is there; a link itself is deleted."""
    refuse_links(path.parent)
    path.unlink(missing_ok=True)
