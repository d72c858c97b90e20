"""Baseline strategies that ignore all reports: random, random without repeats, round robin."""

from __future__ import annotations

from lockprobe.agents.policy import Policy, Told, View, evenly


class RandomAgent(Policy[None]):
    """A random choice among all joints at every step. Its success is the box's chance level."""

    looks = heeds_panel = False

    def begin(self, view: View) -> None:
        """Nothing."""

    def remember(self, view: View, memory: None, told: Told) -> None:
        """Nothing."""

    def probabilities(self, view: View, memory: None) -> tuple[float, ...]:
        """Equal for all joints."""
        return evenly(range(view.joints), view)


class RandomNoRepeat(Policy[int]):
    """A random choice among all joints except the one attempted last."""

    looks = heeds_panel = False

    def begin(self, view: View) -> int:
        """No joint was attempted."""
        return -1

    def remember(self, view: View, memory: int, told: Told) -> int:
        """The joint attempted last."""
        return told.joint

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """Equal for all others."""
        return evenly([joint for joint in range(view.joints) if joint != memory], view)


class RoundRobin(Policy[int]):
    """The joints in listed order, again and again, whatever happens."""

    looks = heeds_panel = False

    def begin(self, view: View) -> int:
        """No step was taken."""
        return 0

    def remember(self, view: View, memory: int, told: Told) -> int:
        """How many steps were taken, up to one round."""
        return (memory + 1) % view.joints

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """One of them."""
        return evenly([memory], view)


class RightToLeft(RoundRobin):
    """The joints from right to left on the panel, again and again, whatever happens: what places alone give away."""

    heeds_panel = True

    def remember_silence(self, view: View, memory: int, joint: int) -> int:
        """The same: it needs no report."""
        return (memory + 1) % view.joints

    def probabilities(self, view: View, memory: int) -> tuple[float, ...]:
        """One of them; the last in the list where no places are known."""
        order = sorted(range(view.joints), key=lambda joint: (view.places[joint] if view.places else (0.0, 0.0), joint))
        return evenly([order[-1 - memory]], view)
