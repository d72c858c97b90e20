"""The intervention ``forget``: the agent loses exchanges of its past at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from lockprobe.foundation.validation import check_probability
from lockprobe.trial.record import Task, Turn

__all__ = ["Forget"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Forget:
    """With probability p the agent forgets an exchange for good, from the following step on.

    Each exchange has its own number, whatever p is: what is forgotten once stays forgotten, and what is forgotten at a
    smaller p is forgotten at a larger one too.

    Attributes:
        p: Probability that an exchange is forgotten, [0, 1].

    Raises:
        BadValue: If it is no probability.
    """

    name: ClassVar[str] = "forget"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    p: float = 0.0

    def __post_init__(self) -> None:
        check_probability("p", self.p)

    def recall(self, past: tuple[Turn, ...], task: Task, rng: np.random.Generator) -> tuple[Turn, ...]:
        """The exchanges that are not forgotten."""
        seed: Any = rng.bit_generator.seed_seq
        numbers = np.random.default_rng(seed).random(len(past))
        return tuple(turn for turn, number in zip(past, numbers, strict=True) if number >= self.p)
