"""One thing that ``lockprobe verify`` checks, and what it found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: Its name.
        holds: Whether it holds.
        said: What was found, in one line.
        failed: What fails: keys of trials, or fields.
    """

    name: str
    holds: bool
    said: str
    failed: tuple[str, ...] = ()


def check_of(name: str, failed: Sequence[str], holds: str, fails: str) -> Check:
    """The check that holds if nothing failed.

    Args:
        name: Its name.
        failed: What fails.
        holds: What is said if nothing does.
        fails: What is said after the number of failures.
    """
    said = f"{len(failed)} {fails}" if failed else holds
    return Check(name=name, holds=not failed, said=said, failed=tuple(failed))


def also(count: int, said: str) -> str:
    """A further part of what was found, after its number; empty for none.

    >>> also(2, "are not there"), also(0, "are not there")
    ('; 2 are not there', '')
    """
    return f"; {count} {said}" if count else ""
