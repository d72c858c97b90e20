"""Which trial of which study an episode is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from lockprobe.environment.settings import whole
from lockprobe.errors import UnknownName

__all__ = ["Place", "read_place"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """The place of a trial in the tree of seeds.

    Attributes:
        seed: Seed of the study.
        repetition: From 1.
        trial: From 1.
    """

    seed: int
    repetition: int = 1
    trial: int = 1

    @property
    def next(self) -> Place:
        """The trial after it."""
        return Place(seed=self.seed, repetition=self.repetition, trial=self.trial + 1)


def read_place(before: Place, options: Mapping[str, Any] | None) -> Place:
    """The place that ``reset(options={"repetition": r, "trial": t})`` asks for.

    Args:
        before: Where the episode would be played without them.
        options: What came; either may be left out.

    Raises:
        UserMistake: If there is another option, or a number is not from 1 on.
    """
    if not options:
        return before
    for name in options:
        if name not in ("repetition", "trial"):
            raise UnknownName("option of reset", str(name), ("repetition", "trial"))
    return replace(before, **{name: whole(name, value) for name, value in options.items()})
