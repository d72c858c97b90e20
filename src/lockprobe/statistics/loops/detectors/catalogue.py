"""The loop detectors: the paper's, rules of agent frameworks, and scores of repetitiveness.

A detector takes the actions in order, and for each whether the agent was told that the joint moved. A rule returns 1
if the trial breaks it anywhere, else 0. A score is higher for more repetition and needs a threshold. It ignores
outcomes and the names of actions, and is 0 for a trial without actions.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import eq

from lockprobe.statistics.loops import any_loop, cover
from lockprobe.statistics.loops.words import letters

__all__ = [
    "DETECTORS",
    "Detector",
    "autocorrelation",
    "compression",
    "coverage",
    "determinism",
    "holds_loop",
    "in_a_row",
    "phrase_length",
    "stuck",
]

Score = Callable[[Sequence[Hashable], Sequence[bool]], float]


def holds_loop(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """Whether some run of three or more actions stands twice without overlap (paper, Sec. 3.3)."""
    return float(any_loop(actions))


def in_a_row(times: int) -> Score:
    """The rule that flags the same action taken this many times in a row."""

    def rule(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
        return float(_longest_run(actions) >= times)

    return rule


def stuck(actions: Sequence[Hashable], moved: Sequence[bool]) -> float:
    """Four times the same action and outcome; three times the same failing action; or A B A B A B with outcomes."""
    pairs = list(zip(actions, moved, strict=True))
    failing = [(action, i if went else None) for i, (action, went) in enumerate(pairs)]
    alternating = [i for i in range(2, len(pairs)) if pairs[i] == pairs[i - 2]]
    steady = _longest_run([i - place for place, i in enumerate(alternating)])
    return float(_longest_run(pairs) >= 4 or _longest_run(failing) >= 3 or steady >= 4)


def _longest_run(values: Sequence[Hashable]) -> int:
    """The longest run of one value."""
    return max((sum(1 for _ in run) for _, run in groupby(values)), default=0)


def coverage(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The share of the trial in its best cover by loops, [0, 1] (paper, Sec. 3.3)."""
    return cover(actions).share


def autocorrelation(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The largest share of actions equal to the one k steps before, over lags k up to half the trial, [0, 1]."""
    text, n = letters(actions), len(actions)
    return max((sum(map(eq, text, text[lag:])) / (n - lag) for lag in range(1, n // 2 + 1)), default=0.0)


def determinism(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The share of recurrences (pairs of steps with the same action) on diagonals of two or more, [0, 1]."""
    text = letters(actions)
    points = alone = 0
    for lag in range(1, len(text)):
        diagonal = bytes(map(eq, text, text[lag:]))
        points += diagonal.count(1)
        alone += (b"\0" + diagonal.replace(b"\0", b"\0\0") + b"\0").count(b"\0\1\0")
    return (points - alone) / points if points else 0.0


def phrase_length(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The mean length of the phrases of Lempel and Ziv (1976), 1 or more: the trial's length over its complexity.

    Each phrase is the shortest run that is not a copy of an earlier one (the copy may overlap the phrase); the end may
    cut the last one short.
    """
    text, n = letters(actions), len(actions)
    start = phrases = 0
    while start < n:
        end = start + 1
        while end < n and text.find(text[start:end], 0, end - 1) >= 0:
            end += 1
        start, phrases = end, phrases + 1
    return n / phrases if phrases else 0.0


def compression(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """Actions per byte of the trial compressed as a raw deflate stream."""
    packer = zlib.compressobj(9, wbits=-15)
    packed = packer.compress(letters(actions).encode("utf-8", "surrogatepass")) + packer.flush()
    return len(actions) / len(packed)


@dataclass(frozen=True, slots=True, kw_only=True)
class Detector:
    """A loop detector: a score or rule that flags repetitive trials.

    Attributes:
        name: Short and unique.
        description: What it measures, in one line.
        source: The framework whose rule it follows, or the origin of the method.
        score: Function of the actions in order and of the told outcomes; higher means more repetitive.
        rule: Whether the score is a verdict, 0 or 1; other scores need a threshold.
        needs_outcome: Whether it uses the outcomes; others accept empty outcomes.
    """

    name: str
    description: str
    source: str
    score: Score
    rule: bool = False
    needs_outcome: bool = False


DETECTORS = (
    Detector(
        name="any-loop",
        description="a run of three or more actions stands twice without overlap",
        source="the paper, Sec. 3.3",
        score=holds_loop,
        rule=True,
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
    ),
    Detector(
        name="goose-like",
        description="more than 3 identical actions in a row",
        source="goose, RepetitionInspector with max_repetitions 3",
        score=in_a_row(4),
        rule=True,
    ),
    Detector(
        name="gemini-cli-like",
        description="5 identical actions in a row",
        source="gemini-cli, LoopDetectionService",
        score=in_a_row(5),
        rule=True,
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
"""All detectors; the paper's two come first."""
