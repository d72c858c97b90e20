"""A plant: it obeys the interlock, and says what it senses."""

from lockprobe import Snapshot


class Weighed:
    """The rules, and the force that a hand would feel: friction where a joint moves, all its strength where not."""

    def __init__(self, *, box, labels, rng, friction: float = 2.0, strength: float = 20.0):
        self.facts = {"friction": friction, "strength": strength}
        self._box, self._now = box, box.initial

    def observe(self):
        return Snapshot(configuration=self._now)

    def attempt(self, joint):
        self._now, moved = self._box.attempt(self._now, joint)
        force = self.facts["friction" if moved else "strength"]
        outcome = "moved" if moved else "blocked"
        return Snapshot(configuration=self._now, joint=joint, outcome=outcome, sensed={"force_n": force})

    def close(self):
        pass
