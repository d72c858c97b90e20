"""Checks whether a client could read the true outcomes in the records: many clients have a shell.

A client is isolated if its user may not enter the directory of the records, or sees other files under that path
(another mount, as in a container). Over stdio the client is the process that started the server. Over HTTP the client
is unknown before it connects, so its user has to be named. Access lists and the right to become another user (sudo)
are not checked.
"""

from __future__ import annotations

import os
import pwd
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast, get_args

from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake

__all__ = ["Client", "Isolation", "check_isolation", "client_of_stdio", "may_read", "named_client"]

Isolation = Literal["checked", "declared", "none"]
"""Whether the client can read the records: checked that it cannot, declared by the user that it cannot, or it can."""


@dataclass(frozen=True, slots=True)
class Client:
    """The process of a client.

    Attributes:
        user: The ID of its user; None if not known.
        root: Its root directory as the server sees it, for example ``/proc/42/root``; ``/`` if not known.
    """

    user: int | None
    root: Path = Path("/")


def client_of_stdio() -> Client:
    """The process that started this one; through sudo, the user who typed the command."""
    parent = os.getppid()
    own = Path(f"/proc/{parent}")
    asked = os.environ.get("SUDO_UID", "")
    try:
        user = int(asked) if asked.isdecimal() and os.getuid() != int(asked) else own.stat().st_uid
    except OSError:  # no /proc, or the parent is in another container
        return Client(None)
    return Client(user, own / "root")


def named_client(user: str) -> Client:
    """A client that runs as this user, given by name or ID.

    Raises:
        UnknownName: If there is no such user.
    """
    if user.isdecimal():
        return Client(int(user))
    try:
        return Client(pwd.getpwnam(user).pw_uid)
    except KeyError:
        raise UnknownName("user", user, [entry.pw_name for entry in pwd.getpwall()]) from None


def may_read(client: Client, directory: Path) -> bool:
    """Whether a client may read files in a directory; True if that is not known.

    A directory that does not exist yet will be private to the user of this process.
    """
    if client.user is None:
        return True
    directory = directory.resolve()
    there = next(path for path in (directory, *directory.parents) if path.exists())
    if not _sees(client.root, there):
        return False
    if client.user == 0:
        return True
    if there != directory and client.user != os.getuid():
        return False
    groups = _groups(client.user)
    return all(_enters(path.stat(), client.user, groups) for path in (*reversed(there.parents), there))


def _sees(root: Path, path: Path) -> bool:
    """Whether a process with this root directory sees the same directory under this path."""
    try:
        seen = (root / path.relative_to("/")).stat()
    except FileNotFoundError:
        return not root.exists()
    except OSError:  # the processes of other users show nothing of theirs
        return True
    return os.path.samestat(seen, path.stat())


def _enters(there: os.stat_result, user: int, groups: frozenset[int]) -> bool:
    """Whether a user may pass through a directory."""
    if there.st_uid == user:
        return bool(there.st_mode & stat.S_IXUSR)
    if there.st_gid in groups:
        return bool(there.st_mode & stat.S_IXGRP)
    return bool(there.st_mode & stat.S_IXOTH)


def _groups(user: int) -> frozenset[int]:
    try:
        entry = pwd.getpwuid(user)
    except KeyError:
        return frozenset()
    return frozenset(os.getgrouplist(entry.pw_name, entry.pw_gid))


def check_isolation(directory: Path, isolation: str, client: Client | None) -> Isolation:
    """Refuse records that the client could read, unless the user allows that or declares that it cannot.

    Args:
        directory: The directory of the study; it need not exist.
        isolation: ``checked``, ``declared`` or ``none``.
        client: The client; None if unknown.

    Raises:
        UnknownName: If there is no such isolation.
        BadValue: If the directory lies in the working directory, or the other way round.
        UserMistake: If the client could read it, and ``checked`` was asked for.
    """
    if isolation not in get_args(Isolation):
        raise UnknownName("isolation", isolation, get_args(Isolation))
    working, place = Path.cwd().resolve(), directory.resolve()
    if working != Path("/") and (place.is_relative_to(working) or working.is_relative_to(place)):
        raise BadValue("out", str(directory), f"a directory outside of the working directory {working}")
    if isolation == "checked" and (client is None or may_read(client, directory)):
        who = "whose user is not known" if client is None or client.user is None else f"user {client.user}"
        raise UserMistake(
            f"the client, {who}, could read the true outcomes in {directory}: start the server as another user "
            "(over HTTP with --client-user USER), or give --isolation declared if it has no way to these files, "
            "or --isolation none to play all the same; every record says which"
        )
    return cast(Isolation, isolation)
