"""The name of a fork: its trial, the step, the arm, and the number of the continuation."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Self

__all__ = ["ForkName"]

_FORM = re.compile(r"(?P<parent>.+)/at=(?P<at>\d+)/(?P<arm>[^/]+)(?P<truthful>/then=truth)?/time=(?P<time>\d+)")


@dataclass(frozen=True, slots=True, kw_only=True)
class ForkName:
    """The key of a fork's record, in parts.

    >>> name = ForkName(parent="flips/random/p=0/rep=1/trial=7", at=8, arm="lie", time=2)
    >>> str(name)
    'flips/random/p=0/rep=1/trial=7/at=8/lie/time=2'
    >>> ForkName.parse(str(name)) == name
    True

    Attributes:
        parent: The key of the recorded trial.
        at: The step whose report is changed, from 1.
        arm: The arm of the fork: ``truth``, ``lie``, ``force=B`` and so on.
        truthful: Whether all later reports are true; else they are as in the trial's condition.
        time: The number of this continuation, from 1.
    """

    parent: str
    at: int
    arm: str
    truthful: bool = False
    time: int = 1

    def __str__(self) -> str:
        then = "/then=truth" if self.truthful else ""
        return f"{self.parent}/at={self.at}/{self.arm}{then}/time={self.time}"

    @classmethod
    def parse(cls, key: str) -> Self | None:
        """The parts of a key; None if it names no fork."""
        if (found := _FORM.fullmatch(key)) is None:
            return None
        return cls(
            parent=found["parent"],
            at=int(found["at"]),
            arm=found["arm"],
            truthful=found["truthful"] is not None,
            time=int(found["time"]),
        )
