"""An agent: a rule whose whole memory is one small value."""

from dataclasses import asdict, dataclass

from lockprobe import Policy


@dataclass(kw_only=True)
class Stubborn(Policy):
    """Tries a joint until it is told so many times that it is blocked, then the next of the listing.

    Attributes:
        tries: Times that a joint has to be reported blocked, from 1.
    """

    tries: int = 2

    @property
    def facts(self):
        return asdict(self)

    def begin(self, view):
        return 0, 0  # the joint, and how often it was reported blocked

    def remember(self, view, memory, told):
        joint, blocked = memory
        if told.joint != joint:
            return memory
        if told.moved or blocked + 1 >= self.tries:
            return (joint + 1) % view.joints, 0
        return joint, blocked + 1

    def probabilities(self, view, memory):
        return tuple(float(joint == memory[0]) for joint in range(view.joints))
