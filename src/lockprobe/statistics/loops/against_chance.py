"""Whether action loops are more or less frequent than by chance: their rate against the chance levels of random agents.

The verdict compares the 95 % interval of the loop rate with the range between two chance levels for trials of the same
lengths: uniformly random actions, and random actions without immediate repeats. It is a verdict only if the interval
lies outside this range. The chance levels of other null models stand beside it in the report.
"""

from __future__ import annotations

from typing import Literal

from lockprobe.statistics.behaviour import Behaviour

ChanceVerdict = Literal["more", "less", "not detected"]


def chance_range(found: Behaviour) -> tuple[float, float]:
    """The lower and the higher of the two chance levels, [0, 1]; 0 where a level is not known."""
    low, high = sorted((found.chance_uniform or 0.0, found.chance_no_repeat or 0.0))
    return low, high


def against_chance(found: Behaviour) -> ChanceVerdict:
    """Whether the loop rate lies above or below both chance levels, with its 95 % interval."""
    low, high = chance_range(found)
    if found.loops.low > high:
        return "more"
    return "less" if found.loops.high < low else "not detected"
