"""An intervention on what is told."""

from dataclasses import dataclass, replace

from lockprobe import BadValue


@dataclass(frozen=True, kw_only=True)
class Late:
    """Every report is the one that was true ``lag`` attempts ago; nothing is false.

    Attributes:
        lag: Attempts by which a report is late, from 0.
    """

    doses = ("lag",)
    lag: int = 1

    def __post_init__(self):
        if self.lag < 0:
            raise BadValue("lag", self.lag, "a whole number from 0")

    def perceive(self, percept, past, task, rng):
        if percept.joint is None or self.lag == 0:  # the first look is no report of an attempt
            return percept
        if len(past) <= self.lag:
            return replace(percept, joint=None, outcome=None, positions=None)
        was = past[-self.lag].was
        return replace(percept, joint=was.joint, outcome=was.outcome, positions=was.positions)
