"""Baseline strategies that ignore all reports: random, random without repeats, round robin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lockprobe.agents.policy import Policy, Told, View, evenly, pick

if TYPE_CHECKING:
    import numpy as np


class RandomAgent(Policy[None]):
    """A random choice among all joints at every step. Its success is the box's chance level."""

    looks = False

    def begin(self, view: View) -> None:
        """Nothing."""

    def remember(self, view: View, memory: None, told: Told) -> None:
        """Nothing."""

    def probabilities(self, view: View, memory: None) -> tuple[float, ...]:
        """Equal for all joints."""
        return evenly(range(view.joints), view)

    def choose(self, view: View, memory: None, rng: np.random.Generator) -> int:
        """Any joint."""
        return pick(range(view.joints), rng)


class RandomNoRepeat(Policy[int]):
    """A random choice among all joints except the one attempted last."""

    looks = False

    def begin(self, view: View) -> int:
        """No joint was attempted."""
        return -1

    def remember(self, view: View, memory: int, told: Told) -> int:
        """The joint attempted last."""
        return told.joint

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """Equal for all others."""
        return evenly(_others(view, memory), view)

    def choose(self, view: View, memory: int, rng: np.random.Generator) -> int:
        """Any joint but the last."""
        return pick(_others(view, memory), rng)


def _others(view: View, last: int) -> list[int]:
    return [joint for joint in range(view.joints) if joint != last]


class RoundRobin(Policy[int]):
    """The joints in listed order, again and again, whatever happens."""

    looks = False

    def begin(self, view: View) -> int:
        """The first."""
        return 0

    def remember(self, view: View, memory: int, told: Told) -> int:
        """The next in the list."""
        return (memory + 1) % view.joints

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """One of them."""
        return evenly([memory], view)

    def choose(self, view: View, memory: int, rng: np.random.Generator) -> int:
        """That one, without a draw."""
        return memory
