"""Rules that agent frameworks stop an agent by, and the paper's: 1 if a trial breaks the rule anywhere, else 0.

All take the actions in order, and whether each moved its joint as the agent was told.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from itertools import groupby

from lockprobe.analysis.loops import any_loop

__all__ = ["holds_loop", "in_a_row", "stuck"]

Rule = Callable[[Sequence[Hashable], Sequence[bool]], float]


def holds_loop(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """Some run of three or more actions stands twice without overlap (paper, Sec. 3.3)."""
    return float(any_loop(actions))


def in_a_row(times: int) -> Rule:
    """The rule that the same action was taken so many times in a row."""

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
    """How often at most a value stands in a row."""
    return max((sum(1 for _ in run) for _, run in groupby(values)), default=0)
