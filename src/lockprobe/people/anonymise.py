"""Diaries that are given away: they do not prove who somebody is, and do not say when it was."""

from __future__ import annotations

from lockprobe.people.diary_archive import Kept

__all__ = ["without_traces"]


def without_traces(kept: Kept, *, platform: bool = False) -> Kept:
    """The same without what proves who somebody is and without the time of day.

    Args:
        kept: A diary.
        platform: Whether what the recruitment platform said stays.

    Returns:
        No token; every moment in seconds since this participant joined, to the millisecond.
    """
    start = kept.joined.at
    joined = kept.joined.model_copy(
        update={"token": "", "at": 0.0, "platform": kept.joined.platform if platform else {}}
    )
    lines = (line.model_copy(update={"at": round(max(0.0, line.at - start), 3)}) for line in kept.lines)
    return Kept(joined, tuple(lines))
