"""Planning under a belief: the expected steps of each attempt.

If reports may be false, they are QMDP's (Littman, Cassandra and Kaelbling 1995): one step plus the distance averaged
over the posterior, which assumes full knowledge after this attempt. That is a lower bound and gives no credit for
information. If every report is true, they are exact, by branch and bound.

A belief is then a configuration and the set of interlocks that are still possible. An attempt that moves the joint
under all of them keeps the set; any other attempt splits it::

    V(set, c) = min over joints of 1 + f V(set that moves, c') + (1 - f) V(set that does not, c)

with f the share of the set that lets the joint move; V is 0 once the target moves. The mean distance over the set, as
if the interlock were known, is a lower bound of V. From the start, this bound prunes the search to 152 of 6400 beliefs
under ``single-parent`` over 4 joints, and to 7141 of 271 498 under ``any-literal``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.beliefs import Belief, Interlocks, as_mask
from lockprobe.foundation.errors import BadValue

MOST_PLANNED = 60_000
"""Interlocks times configurations up to which exact planning takes well below a second per decision."""

SAME = 1e-9
"""Steps closer than this are equal."""


def best_joints(belief: Belief) -> NDArray[np.bool_]:
    """The joints whose attempt takes the fewest expected steps, within rounding, shape (n,).

    The steps are exact for a naive observer, with a ``BadValue`` if there are too many interlocks for that; QMDP's
    lower bound for others.
    """
    known, configuration = belief.interlocks, belief.configuration
    if belief.noise.naive:
        values = np.array(planner(known).values(belief.alive, belief.likeliest))
    else:
        moves = known.may_move(configuration)
        after = configuration[:, None] ^ (moves << np.arange(known.joints))
        left = known.distance[np.arange(len(known))[:, None], after & ~1]
        left[:, 0] *= ~moves[:, 0]
        values = 1.0 + belief.weights @ left
    chosen: NDArray[np.bool_] = values <= values.min() + SAME
    return chosen


class Planner:
    """Minimum expected steps if every report is true. A set of interlocks is a number with bit s for interlock s.

    Each set passed to a method must be solvable from its configuration. ``BadValue`` if there are too many interlocks.
    ``value`` leads from a set and a configuration to the steps of the best attempts.
    """

    def __init__(self, interlocks: Interlocks) -> None:
        if interlocks.distance.size > MOST_PLANNED:
            raise BadValue(
                "plan steps, told the truth",
                f"{len(interlocks)} interlocks of prior {interlocks.prior} over {interlocks.joints} joints",
                f"at most {MOST_PLANNED} interlocks times configurations; noise=aware has no such limit",
            )
        self._known = interlocks
        self.value = cache(self._search)
        self._at: list[list[tuple[int, int]]] = [
            [(int(steps), as_mask(column == steps)) for steps in np.unique(column)] for column in interlocks.distance.T
        ]

    def values(self, alive: int, configuration: int) -> tuple[float, ...]:
        """Expected steps for each joint if it is attempted next."""
        return tuple(self._through(alive, configuration, joint, self.value) for joint in range(self._known.joints))

    def _through(self, alive: int, configuration: int, joint: int, of: Callable[[int, int], float]) -> float:
        """Expected steps through an attempt, given what is left ``of`` each set and configuration behind it."""
        moved = alive & self._known.masks[configuration][joint]
        share = moved.bit_count() / alive.bit_count()
        steps = 1.0
        if moved and joint:
            steps += share * of(moved, configuration ^ (1 << joint))
        if moved != alive:
            steps += (1.0 - share) * of(alive & ~moved, configuration)
        return steps

    def _bound(self, alive: int, configuration: int) -> float:
        """The lower bound: expected steps if the interlock were known."""
        total = sum(steps * (alive & mask).bit_count() for steps, mask in self._at[configuration])
        return total / alive.bit_count()

    def _search(self, alive: int, configuration: int) -> float:
        """Make all certain moves, then evaluate the splits in the order of their bounds until none can be better."""
        if alive & (alive - 1) == 0:
            return self._bound(alive, configuration)
        best, away, joints = inf, {configuration: 0}, range(self._known.joints)
        splits, queue = list[tuple[float, int, int]](), [(configuration, joint) for joint in joints]
        for here, joint in queue:
            moved, there = alive & self._known.masks[here][joint], here ^ (1 << joint)
            if moved == alive and joint == 0:
                best = away[here] + 1.0
                break
            if moved == alive and there not in away:
                away[there] = away[here] + 1
                queue += [(there, next_joint) for next_joint in joints]
            elif 0 < moved < alive:
                splits.append((away[here] + self._through(alive, here, joint, self._bound), here, joint))
        for bound, here, joint in sorted(splits):
            if bound >= best - SAME:
                break
            best = min(best, away[here] + self._through(alive, here, joint, self.value))
        return best


planner = cache(Planner)
"""The planner of these interlocks, with a cache of its results; ``BadValue`` if there are too many."""
