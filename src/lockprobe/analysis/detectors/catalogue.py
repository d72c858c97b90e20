"""The detectors: name, rule or score, where it comes from."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

from lockprobe.analysis.detectors.rules import holds_loop, in_a_row, stuck
from lockprobe.analysis.detectors.scores import autocorrelation, compression, coverage, determinism, phrase_length

__all__ = ["DETECTORS", "Detector"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Detector:
    """Something that says how much a trial looks like going round in circles.

    Attributes:
        name: Short and unique.
        description: What it looks at, in one line.
        source: The framework whose rule it follows, or where the method is from.
        score: Actions in order, and whether each moved its joint as the agent was told -> higher for more of a loop.
        rule: Whether the score is a verdict, 0 or 1; other scores need a threshold.
        needs_outcome: Whether it looks at the outcomes; the others may be given none.
        online: Whether it can stop a trial that still runs: once it flags, more steps do not change that.
    """

    name: str
    description: str
    source: str
    score: Callable[[Sequence[Hashable], Sequence[bool]], float]
    rule: bool = False
    needs_outcome: bool = False
    online: bool = False


DETECTORS = (
    Detector(
        name="any-loop",
        description="a run of three or more actions stands twice without overlap",
        source="the paper, Sec. 3.3",
        score=holds_loop,
        rule=True,
        online=True,
    ),
    Detector(
        name="coverage",
        description="share of the trial in its best cover by loops of three or more",
        source="the paper, Sec. 3.3",
        score=coverage,
    ),
    Detector(
        name="openhands-like",
        description="4 identical (action, outcome) in a row, 3 identical failing actions, or ABABAB",
        source="OpenHands, StuckDetector",
        score=stuck,
        rule=True,
        needs_outcome=True,
        online=True,
    ),
    Detector(
        name="goose-like",
        description="more than 3 identical actions in a row",
        source="goose, RepetitionInspector with max_repetitions 3",
        score=in_a_row(4),
        rule=True,
        online=True,
    ),
    Detector(
        name="gemini-cli-like",
        description="5 identical actions in a row",
        source="gemini-cli, LoopDetectionService",
        score=in_a_row(5),
        rule=True,
        online=True,
    ),
    Detector(
        name="autocorrelation",
        description="greatest share of actions equal to the one a lag before, lags to half the trial",
        source="autocorrelation of a categorical series",
        score=autocorrelation,
    ),
    Detector(
        name="determinism",
        description="share of recurrences on diagonals of two or more",
        source="recurrence quantification (Webber and Zbilut 1994; Marwan et al. 2007)",
        score=determinism,
    ),
    Detector(
        name="lz76",
        description="mean length of the phrases of the Lempel-Ziv parsing",
        source="Lempel and Ziv 1976; Kaspar and Schuster 1987",
        score=phrase_length,
    ),
    Detector(
        name="compression",
        description="actions per byte of a deflate stream",
        source="zlib, level 9",
        score=compression,
    ),
)
"""The paper's two first."""
