"""The plant ``symbolic``: the rules of the box without physics (paper, Sec. 2.1, "Lockbox Simulation")."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from lockprobe.boxes.box import Lockbox
from lockprobe.trial.record import Fact, Snapshot


class SymbolicPlant:
    """A plant that follows the rules of the box, without body, time or noise."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, box: Lockbox) -> None:
        self._box = box
        self._configuration = box.initial

    def observe(self) -> Snapshot:
        """The truth now."""
        return Snapshot(configuration=self._configuration)

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order."""
        self._configuration, moved = self._box.attempt(self._configuration, joint)
        return Snapshot(configuration=self._configuration, joint=joint, outcome="moved" if moved else "blocked")

    def close(self) -> None:
        """Do nothing: there are no resources to release."""
