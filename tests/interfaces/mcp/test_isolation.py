"""A client that could read the records is refused, unless somebody says otherwise."""

import os
import shutil
import tempfile
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.interfaces.mcp import isolation
from lockprobe.interfaces.mcp.isolation import Client, check_isolation, client_of_stdio, may_read, named_client

OWN, OTHER = os.getuid(), 54321


@pytest.fixture
def place():
    """A directory that anybody may reach; those of pytest are private."""
    found = Path(tempfile.mkdtemp())
    found.chmod(0o755)
    yield found
    shutil.rmtree(found)


def test_the_own_user_and_root_may_read_whatever_the_permissions(place):
    for mode in (0o700, 0o755):
        place.chmod(mode)
        assert may_read(Client(OWN), place)
        assert may_read(Client(0), place)


def test_another_user_may_read_what_is_open_to_all(place):
    inner = place / "a" / "b"
    inner.mkdir(parents=True)
    assert may_read(Client(OTHER), inner)
    for closed in (inner, inner.parent, place):
        closed.chmod(0o700)
        assert not may_read(Client(OTHER), inner)
        closed.chmod(0o755)


def test_a_group_counts(place, monkeypatch):
    monkeypatch.setattr(isolation, "_groups", lambda user: frozenset([place.stat().st_gid]))
    place.chmod(0o710)
    assert may_read(Client(OTHER), place)
    place.chmod(0o701)
    assert not may_read(Client(OTHER), place)


def test_what_is_not_there_yet_will_be_private(place):
    assert may_read(Client(OWN), place / "new" / "S")
    assert not may_read(Client(OTHER), place / "new" / "S")


def test_a_client_that_sees_other_files_may_not_read_them(place):
    root = place / "root"
    (root / place.relative_to("/")).mkdir(parents=True)
    assert not may_read(Client(OWN, root), place)  # another directory under the same path
    empty = place / "empty"
    empty.mkdir()
    assert not may_read(Client(OWN, empty), place)  # none
    assert may_read(Client(OWN, place / "gone"), place)  # nothing is known of a process that has gone


def test_a_client_of_whom_nothing_is_known_may_read(place):
    assert may_read(Client(None), place)


def test_over_stdio_the_client_is_the_parent(monkeypatch):
    monkeypatch.delenv("SUDO_UID", raising=False)
    found = client_of_stdio()
    assert found.user == Path(f"/proc/{os.getppid()}").stat().st_uid
    monkeypatch.setenv("SUDO_UID", str(OTHER))
    assert client_of_stdio().user == OTHER
    monkeypatch.setattr(os, "getppid", lambda: 2**22 + 1)
    monkeypatch.delenv("SUDO_UID")
    assert client_of_stdio() == Client(None)


def test_a_user_is_named_or_numbered():
    assert named_client("root") == Client(0)
    assert named_client("4711") == Client(4711)
    with pytest.raises(UnknownName, match="no user is called 'nobody-at-all'"):
        named_client("nobody-at-all")


def test_records_that_can_be_read_are_refused_in_one_line(place, monkeypatch):
    working = place / "project"
    working.mkdir()
    monkeypatch.chdir(working)
    out = place / "records"
    for client in (None, Client(None), Client(OWN)):
        with pytest.raises(UserMistake, match="could read the true outcomes") as refused:
            check_isolation(out, "checked", client)
        assert "\n" not in str(refused.value)
        assert check_isolation(out, "declared", client) == "declared"
        assert check_isolation(out, "none", client) == "none"
    assert check_isolation(out, "checked", Client(OTHER)) == "checked"
    with pytest.raises(UnknownName):
        check_isolation(out, "perhaps", Client(OTHER))
    assert not out.exists()


@pytest.mark.parametrize("kind", ["checked", "declared", "none"])
def test_records_never_lie_where_the_client_works(place, monkeypatch, kind):
    working = place / "project" / "inner"
    working.mkdir(parents=True)
    monkeypatch.chdir(working)
    for out in (working, working / "S", Path("S"), place / "project", place):
        with pytest.raises(BadValue, match="outside of the working directory"):
            check_isolation(out, kind, Client(OTHER))
    assert check_isolation(place / "project" / "S", kind, Client(OTHER)) == kind
