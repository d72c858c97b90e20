"""Sections of a report: one that cannot be made is left out, named with its reason, and the others are made.

Whatever computes, draws or writes a part of a report does so through :func:`section`. While failures are collected
(:func:`leaving_out`) an error leaves that part out; otherwise it is raised, as for a program that calls one analysis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from typing import TypeVar

from lockprobe.foundation.errors import kind_and_words
from lockprobe.foundation.terminal_text import printable

_T = TypeVar("_T")

_LONGEST = 200
"""Characters of a reason."""

_NAMED = 3
"""Sections that the line on a report names; the others are counted."""


@dataclass(frozen=True, slots=True)
class LeftOutSection:
    """A part of a report that could not be made, and why in one line."""

    section: str
    reason: str

    def plain(self) -> dict[str, str]:
        """The same for JSON."""
        return asdict(self)


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
        said = printable(" ".join(kind_and_words(error).split()))
        cut = said if len(said) <= _LONGEST else f"{said[: _LONGEST - 1]}\N{HORIZONTAL ELLIPSIS}"
        left_out = LeftOutSection(name, cut)
        if left_out not in found:
            found.append(left_out)
        return instead()


def without(left_out: Sequence[LeftOutSection]) -> str:
    """What a report is without, for the end of the line that names it; empty for a whole report.

    >>> without([LeftOutSection("Loops", "ValueError: no")])
    ', without Loops (ValueError: no)'
    """
    if not left_out:
        return ""
    named = "; ".join(f"{one.section} ({one.reason})" for one in left_out[:_NAMED])
    more = len(left_out) - _NAMED
    return f", without {named}" + (f" and {more} more section{'s' * (more > 1)}, named on the page" if more > 0 else "")
