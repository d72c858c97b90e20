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
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import is_there

_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL

MARK = "study.json"
"""The file by which a directory is that of a study."""


def refuse_links(path: Path, *, within: Path | None = None) -> None:
    """Refuse to write to a path, which need not exist, that leads through a link inside the directory of a study.

    ``within`` is the directory of a study that has no settings yet.
    """
    whole = _absolute(path)
    above = list(reversed(whole.parents))
    marked = (one for one in above if os.path.lexists(os.path.join(one, MARK)))  # noqa: PTH118 - four times as fast
    root = _absolute(within) if within is not None else next(marked, None)
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


@contextmanager
def writing(path: Path, errors: type[Exception] | tuple[type[Exception], ...] = OSError) -> Iterator[None]:
    """Turn errors of writing into the mistake that a path cannot be written."""
    try:
        yield
    except errors as error:
        raise BadFile(path, f"cannot be written ({getattr(error, 'strerror', None) or error})") from error


def writable(path: Path) -> Path:
    """The file that is written under a path: itself, or where a link leads.

    Raises:
        BadFile: If it cannot be written, is no regular file, or leads through a link inside the directory of a study.
    """
    refuse_links(path)
    with writing(path, (OSError, ValueError)):
        target = Path(os.path.realpath(path))
        if is_there(path) and not os.access(target, os.W_OK):
            raise BadFile(path, "cannot be written (Permission denied)")
    return target


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

    A draft has the ending of its file's name. None is put in its place before all are on the disk, and the last of them
    last. Their directories exist. ``mode`` is for a file that does not, less the umask; any other keeps its own.
    Without ``tidy`` nobody looks for the drafts of the killed, which takes long in a directory of many files.
    """
    targets = [writable(path) for path in paths]
    drafts = [target.parent / f".{secrets.token_hex(6)}.draft{target.suffix}" for target in targets]

    def warily(path: str, flags: int) -> int:
        return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK)

    def drop(draft: Path) -> None:
        with suppress(OSError):  # also of a file system that is read-only, where none was made
            draft.unlink()

    with ExitStack() as held:
        for directory in {draft.parent for draft in drafts if tidy}:
            for draft in directory.glob(f".{'[0-9a-f]' * 12}.draft*"):
                with suppress(OSError), open(draft, "rb", opener=warily) as left:  # one that no process has locked
                    fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    draft.unlink()
        for path, target, draft in zip(paths, targets, drafts, strict=True):
            held.callback(drop, draft)
            with writing(path):
                own = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
                while not draft.exists():  # another writer may delete it before it is locked
                    descriptor = os.open(draft, _NEW, mode if own is None else own)
                    held.callback(os.close, descriptor)
                    if own is not None:  # whatever the umask says
                        os.fchmod(descriptor, own)
                    with suppress(OSError):  # a file system without locks
                        fcntl.flock(descriptor, fcntl.LOCK_EX)
        with writing(paths[-1]):
            yield drafts
        for path, draft in zip(paths, drafts, strict=True):
            with writing(path):
                _sync(draft)
        for path, target, draft in zip(paths, targets, drafts, strict=True):
            with writing(path):
                draft.replace(target)
            with suppress(OSError):  # it is in its place already
                _sync(target.parent)


def write_file(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a file, as :func:`atomic_files` does, text as UTF-8 with its own line ends."""
    with atomic_files(path, mode=mode) as (draft,):
        draft.write_bytes(content.encode() if isinstance(content, str) else content)


def append_whole(path: Path, lines: bytes) -> None:
    """Append lines to a file, on a new line, and force them to the disk; if not all can be written, none stays."""
    if not lines:
        return
    refuse_links(path)
    with writing(path), path.open("a+b", buffering=0) as file:
        end = file.seek(0, os.SEEK_END)
        if end and os.pread(file.fileno(), 1, end - 1) != b"\n":
            lines = b"\n" + lines
        try:
            while lines:
                lines = lines[file.write(lines) :]
            os.fsync(file.fileno())
        except OSError:
            file.truncate(end)
            raise


def write_private(path: Path, content: str | bytes, *, mode: int = 0o666) -> None:
    """Write a file, as :func:`write_file` does, into a directory that is made for this user alone if it is missing."""
    make_directory(path.parent, mode=0o700)
    write_file(path, content, mode=mode)


def make_directory(path: Path, *, mode: int = 0o777) -> None:
    """Make a directory with those above it, unless it is there."""
    refuse_links(path)
    with writing(path):
        path.mkdir(mode=mode, parents=True, exist_ok=True)
