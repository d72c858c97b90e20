"""A plant whose hand misses, so that attempts break the rules of the box."""

from lockprobe.trial.record import Snapshot

Steps = tuple[int, ...]


class Hand:
    """The rules of chain-4, except at some attempts, from 1: ``misses`` move nothing, ``forces`` move the joint.

    At ``knocks`` the joint to the left moves too.
    """

    facts: dict[str, str] = {}  # noqa: RUF012

    def __init__(self, *, box, labels, rng, misses: Steps = (), forces: Steps = (), knocks: Steps = ()):
        self._box, self._now, self._count = box, box.initial, 0
        self._misses, self._forces, self._knocks = misses, forces, knocks

    def observe(self):
        return Snapshot(configuration=self._now)

    def attempt(self, joint):
        self._count += 1
        moves = self._box.may_move(self._now, joint)
        moves = (moves and self._count not in self._misses) or self._count in self._forces
        toggled = {joint} if moves else set()
        toggled |= {joint - 1} if self._count in self._knocks else set()
        self._now = tuple(now ^ (i in toggled) for i, now in enumerate(self._now))
        return Snapshot(configuration=self._now, joint=joint, outcome="moved" if moves else "blocked")

    def close(self):
        pass


HAND = f"python:{__name__}:{Hand.__name__}"

CLUMSY = f"{HAND}?misses=3"
"""The rules, except that the third attempt moves nothing."""
