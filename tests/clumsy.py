"""A plant whose hand misses, so that attempts break the rules of the box."""

from typing import ClassVar

from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.record import Snapshot

__all__ = ["CLUMSY", "Clumsy"]


class Clumsy(SymbolicPlant):
    """The rules, except that the third attempt moves nothing."""

    facts: ClassVar = {"misses": 1}

    def __init__(self, *, box, labels, rng):
        super().__init__(box)
        self._attempts = 0

    def attempt(self, joint):
        self._attempts += 1
        if self._attempts == 3:
            return Snapshot(configuration=self._configuration, joint=joint, outcome="blocked")
        return super().attempt(joint)


CLUMSY = f"python:{__name__}:{Clumsy.__name__}"
