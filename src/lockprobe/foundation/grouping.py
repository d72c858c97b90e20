"""Members of a sequence in groups."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

_Key = TypeVar("_Key", bound=Hashable)
_Member = TypeVar("_Member")


def grouped(members: Iterable[_Member], key: Callable[[_Member], _Key]) -> dict[_Key, list[_Member]]:
    """The members by key; keys and members stay in the order in which they come."""
    found: dict[_Key, list[_Member]] = {}
    for member in members:
        found.setdefault(key(member), []).append(member)
    return found
