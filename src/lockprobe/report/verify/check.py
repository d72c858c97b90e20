"""One thing that was checked, as ``lockprobe verify`` says it."""

from __future__ import annotations

from collections.abc import Iterable
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

    @classmethod
    def of(cls, name: str, failed: Iterable[str], fails: str, holds: str) -> Check:
        """A check that holds if nothing fails; ``fails`` is said if anything does, {n} is how much."""
        every = tuple(failed)
        said = fails.replace("{n}", str(len(every))) if every else holds
        return cls(name=name, holds=not every, said=said, failed=every)


def also(count: int, said: str) -> str:
    """A further part of what was found, after its number; empty for none."""
    return f"; {count} {said}" if count else ""
