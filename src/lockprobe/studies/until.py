"""When a study stops: at a fixed number of trials, or as soon as its questions are decided."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, Self

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import AS_WRITTEN

MARGIN = 0.1
"""The largest difference in success that counts as none where a study plays until it is decided. It is a convention."""

MOST = 300
"""Trials under each condition at most, unless ``--most`` says otherwise."""

LOOK_EVERY = 5
"""Blocks that are played between two looks, so that trials of a hosted model can be open at the same time."""

_EXPECTED = "decided, ±10 or another number of points, from 1 to 50"


@dataclass(frozen=True, slots=True, kw_only=True)
class Until:
    """What a study is played for.

    Attributes:
        rule: ``decided``: every difference is shown to be an effect, or to be smaller than ``points``. ``width``: the
            interval of every difference reaches at most ``points`` to either side.
        points: As a difference of shares, (0, 0.5].
    """

    __pydantic_config__ = AS_WRITTEN

    rule: Literal["decided", "width"]
    points: float = MARGIN

    def __post_init__(self) -> None:
        if self.rule not in ("decided", "width") or not 0.01 <= self.points <= 0.5:
            raise BadValue("until", f"{self.rule} {100 * self.points:g}", _EXPECTED)

    @classmethod
    def parse(cls, text: str) -> Self:
        """The rule of a text: ``decided``, or ``±10`` (also ``+-10`` or ``10``) for a width.

        >>> Until.parse("±10")
        Until(rule='width', points=0.1)
        """
        if text.strip() == "decided":
            return cls(rule="decided")
        found = re.fullmatch(r"\s*(?:±|\+-|\+/-)?\s*([0-9]{1,2}(?:\.[0-9]{1,3})?)\s*", text)
        if found is None or not 1 <= float(found[1]) <= 50:
            raise BadValue("until", text, _EXPECTED)
        return cls(rule="width", points=float(found[1]) / 100)

    def __str__(self) -> str:
        return "decided" if self.rule == "decided" else f"±{100 * self.points:g}"

    @property
    def margin(self) -> float | None:
        """The largest difference that counts as none; None where the study says of none that it is small."""
        return self.points if self.rule == "decided" else None


@dataclass(frozen=True, slots=True)
class EarlierSize:
    """The size that a study had before it was extended, in the fields of :class:`lockprobe.studies.study.Study`.

    Blocks of an earlier size come before those that were added to it, in what holds at every look.
    """

    __pydantic_config__ = AS_WRITTEN

    repetitions: int
    trials: int
    strategy_trials: int | None = None
