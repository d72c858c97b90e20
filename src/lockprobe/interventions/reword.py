"""The intervention ``reword``: the same report in other words."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lockprobe.foundation.validation import check_probability
from lockprobe.trial.record import Moment, Percept, Task

__all__ = ["SENTENCES", "Reword", "pattern_of"]

SENTENCES = {
    "{} moved.": (
        "{} has moved.",
        "{} changed its position.",
        "The attempt moved {}.",
        "There was movement at {}.",
        "{} went to its other position.",
    ),
    "{} did not move.": (
        "{} has not moved.",
        "{} stayed where it was.",
        "The attempt left {} unmoved.",
        "There was no movement at {}.",
        "{} kept its position.",
    ),
    "You attempted {}.": (
        "The joint of the attempt was {}.",
        "Your attempt was at {}.",
        "What you attempted was {}.",
        "The last attempt was at {}.",
        "You have attempted {}.",
    ),
    "At 1: {}.": (
        "In position 1: {}.",
        "Now standing at 1: {}.",
        "At position 1 there is: {}.",
        "What is at 1: {}.",
        "Position 1 is taken by: {}.",
    ),
}
"""Each sentence of a report and its paraphrases: equally many for each sentence, and all distinct."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reword:
    """With probability p a report tells the same facts in other words: noise in the prompt without falsehood.

    It acts on the words of the report, after all interventions that change its facts; unknown sentences stay
    unchanged. Agents that read no words ignore it. Three numbers are drawn per report whatever p is, so
    the reports reworded at a smaller p are reworded in the same way at a larger one.

    Attributes:
        p: Probability that a report is reworded, [0, 1].

    Raises:
        BadValue: If it is no probability.
    """

    name: ClassVar[str] = "reword"
    doses: ClassVar[tuple[str, ...]] = ("p",)
    after_words: ClassVar[bool] = True
    always_tells: ClassVar[bool] = True
    p: float = 0.0

    def __post_init__(self) -> None:
        check_probability("reword rate p", self.p)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its text in other words, or as it is."""
        reworded, outcome, positions = rng.random(3)
        if reworded >= self.p:
            return percept
        text = percept.text
        for (said, others), which in zip(SENTENCES.items(), (outcome, outcome, outcome, positions), strict=True):
            text = re.sub(pattern_of(said), others[int(which * len(others))].format(r"\1"), text)
        return replace(percept, text=text)


def pattern_of(sentence: str) -> str:
    """A sentence with its fact as a regular expression; it matches whole sentences only."""
    before, after = map(re.escape, sentence.split("{}"))
    return rf"(?:(?<=^)|(?<=[.] )){before}(\w+(?:, \w+)*){after}(?= |$)"
