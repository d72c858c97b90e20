"""The intervention ``distract``: an irrelevant sentence next to the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lockprobe.interventions.luck import Luck, check_luck, check_steps, hits, stream_of, within
from lockprobe.validation import check_probability

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.record import Briefing, Moment, Task

__all__ = ["ASIDES", "Distract"]

ASIDES = (
    "Note: the room in which the panel stands has a window.",
    "Note: the table under the panel is as wide as the panel.",
    "Note: somebody has put a cup of coffee beside the panel.",
    "Note: the panel was built in a workshop on the ground floor.",
    "Note: the labels of the joints are printed in dark letters.",
    "Note: a calendar with pictures of boats hangs on the wall.",
)
"""What is said: nothing of what moved or may move, and nothing that changes what the report says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Distract:
    """With probability p an irrelevant sentence comes with the report; the report stays as it is.

    It comes at moments that are drawn, unlike ``remark``, and before every step but the first. Agents that read no
    words pay no attention to it. Two numbers are drawn per step whatever p is (one with ``luck=flip``), so what is said
    at a smaller p is said at a larger one too.

    Attributes:
        p: Probability that a sentence is said, [0, 1].
        luck: Whose steps it hits: its own, or those at which ``flip`` lies at the same p.
        at: The steps with whose reports it can come; empty for all of them.

    Raises:
        BadValue: If a value is none of these.
    """

    name: ClassVar[str] = "distract"
    dose: ClassVar[str] = "p"
    later: ClassVar[tuple[str, ...]] = ("luck", "at")
    p: float = 0.0
    luck: Luck = "own"
    at: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        check_probability("distract rate p", self.p)
        check_luck(self.luck)
        check_steps(self.at)

    @property
    def stream(self) -> str:
        """The name of its random stream."""
        return stream_of(self.luck, type(self))

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with a sentence, or without."""
        if self.luck == "flip":
            said = rng.random() if len(past) > 1 else 1.0
            which = within(said, self.p) if said < self.p else 0.0
        else:
            said, which = rng.random(2)
        if len(past) < 2 or said >= self.p or not hits(self.at, len(past) - 1):
            return briefing
        return briefing.remarking(ASIDES[int(which * len(ASIDES))])
