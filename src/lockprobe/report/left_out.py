"""Sections of a report: one that cannot be made is left out, named with its reason, and the others are made.

Whatever computes, draws or writes a part of a report does so through :func:`section`. While failures are collected
(:func:`leaving_out`) an error leaves that part out; otherwise it is raised, as for a program that calls one analysis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, TypeVar

from lockprobe.foundation.errors import kind_and_words
from lockprobe.foundation.terminal_text import printable

_T = TypeVar("_T")

_LONGEST = 200
"""Characters of a reason."""


class LeftOutSection(NamedTuple):
    """A part of a report that could not be made, and why in one line."""

    section: str
    reason: str


_failed: ContextVar[list[LeftOutSection] | None] = ContextVar("sections left out", default=None)


@contextmanager
def leaving_out() -> Iterator[list[LeftOutSection]]:
    """Within it no section raises; those that fail are in the list, in the order in which they failed."""
    found: list[LeftOutSection] = []
    token = _failed.set(found)
    try:
        yield found
    finally:
        _failed.reset(token)


def section(name: str, make: Callable[[], _T], instead: Callable[[], _T]) -> _T:
    """A part of a report, or what stands in its place if it cannot be made, such as the same of no trials.

    ``name`` is what a reader would call it.
    """
    found = _failed.get()
    if found is None:
        return make()
    try:
        return make()
    except (Exception, SystemExit) as error:  # noqa: BLE001  whatever it is, the others do not depend on it
        left_out = LeftOutSection(name, printable(" ".join(kind_and_words(error).split()))[:_LONGEST])
        if left_out not in found:
            found.append(left_out)
        return instead()
