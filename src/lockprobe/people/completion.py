"""Who of those that joined a study came to its end, from their diaries; a report says it, since it bends all else."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from lockprobe.people.diary import Broken
from lockprobe.people.diary_archive import Kept, kept_diaries
from lockprobe.people.withdrawal import withdrawn

__all__ = ["BoxesAt", "Flow", "flow_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxesAt:
    """Boxes of one condition.

    Attributes:
        modality: How they are shown.
        p: Flip probability, [0, 1].
        given: Boxes that people got when they joined.
        left_open: Of these, the boxes that are not over: left, or still to come.
    """

    modality: str
    p: float
    given: int
    left_open: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """All who joined a study.

    Attributes:
        joined: How many joined and have not withdrawn.
        finished: How many of them have no box open any more.
        left_open: How many have: they left, or are still at it.
        withdrawn: How many withdrew besides; nothing else is known of them.
        checks: Attention checks answered.
        right: Of these, answered right.
        boxes: By condition, p ascending.
    """

    joined: int
    finished: int
    left_open: int
    withdrawn: int
    checks: int
    right: int
    boxes: tuple[BoxesAt, ...]


def flow_of(directory: Path) -> Flow | None:
    """How many came to the end of the study in a directory; None where nobody has taken part.

    Raises:
        BadFile: If a diary is damaged.
    """
    diaries, gone = kept_diaries(directory), withdrawn(directory)
    if not diaries and not gone:
        return None
    given: Counter[tuple[str, float]] = Counter()
    left: Counter[tuple[str, float]] = Counter()
    for kept in diaries:
        over = _over(kept)
        given.update((slot.modality, slot.p) for slot in kept.joined.slots)
        left.update((slot.modality, slot.p) for box, slot in enumerate(kept.joined.slots, 1) if box not in over)
    at_the_end = sum(len(_over(kept)) == len(kept.joined.slots) for kept in diaries)
    checks = [act.right for kept in diaries for act in kept.acts if act.right is not None]
    return Flow(
        joined=len(diaries),
        finished=at_the_end,
        left_open=len(diaries) - at_the_end,
        withdrawn=gone,
        checks=len(checks),
        right=sum(checks),
        boxes=tuple(
            BoxesAt(modality=one[0], p=one[1], given=given[one], left_open=left[one])
            for one in sorted(given, key=lambda one: (one[1], one[0]))
        ),
    )


def _over(kept: Kept) -> set[int]:
    """The boxes that came to an end, from 1; those that were given to others did not."""
    ended = {act.box for act in kept.acts if act.ended is not None and act.box}
    return ended | {line.box for line in kept.lines if isinstance(line, Broken) and line.box}
