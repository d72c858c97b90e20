"""Priors over interlocks, all of equal weight: chains, single parents, any literal.

Joints are numbers; the target is joint 0. A configuration is a number whose bit j says that joint j is "open" (away
from its start). In every interlock, a joint is always free or depends on the position of one other joint:

* ``chains``: the target needs another joint open, that one the next, and so on through all; the last is free. The
  orders of the only public code of this lineage (Baum et al., IROS 2017), 6 for 4 joints.
* ``single-parent``: every joint is free or needs one other open; 142 for 4 joints.
* ``any-literal``: every joint is free or needs one other in one of its two positions; 2152 for 4 joints.

Interlocks under which the target can never move are left out (114 of 256, 249 of 2401). A box with two conditions on
one joint is in none of these priors, so its reports can be impossible for an observer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise, permutations, product
from math import factorial

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, UnknownName

MOST_INTERLOCKS = 20_000
"""The largest prior that is built."""

NEVER = 255
"""The distance of configurations from which the target can never move."""

Need = tuple[int, int] | None
"""The other joint that a joint needs, and its position; None for a joint that is free."""

Masks = tuple[tuple[int, ...], ...]
"""For every configuration and joint a set of interlocks, bit s for interlock s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Interlocks:
    """The interlocks of one prior over n joints.

    Attributes:
        needs: The condition of every joint, one tuple of n per interlock.
        asks: Bit mask of the joint that a condition reads, shape (interlocks, n); 0 for a free joint.
        finds: The value that the masked bit must have, of the same shape.
        distance: Fewest steps that solve the box from every configuration, shape (interlocks, 2**n); 255 if it is
            unsolvable.
    """

    prior: str
    joints: int
    needs: tuple[tuple[Need, ...], ...]
    asks: NDArray[np.int64]
    finds: NDArray[np.int64]
    distance: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.needs)

    def may_move(self, configuration: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether each joint may move in the configuration of each interlock: from (..., interlocks) to (..., n)."""
        allowed: NDArray[np.bool_] = (configuration[..., None] & self.asks) == self.finds
        return allowed

    def moves(self, configuration: NDArray[np.int64], joint: int) -> NDArray[np.bool_]:
        """Whether this joint may move in the configuration under each interlock, shape (..., interlocks)."""
        allowed: NDArray[np.bool_] = (configuration & self.asks[:, joint]) == self.finds[:, joint]
        return allowed

    @cached_property
    def masks(self) -> Masks:
        """The interlocks that let each joint move in each configuration."""
        return tuple(
            tuple(as_mask(column) for column in self.may_move(np.full(len(self), c, dtype=np.int64)).T)
            for c in range(1 << self.joints)
        )


def as_mask(chosen: NDArray[np.bool_]) -> int:
    """A choice of interlocks as a number, bit s for interlock s."""
    return int.from_bytes(np.packbits(chosen, bitorder="little").tobytes(), "little")


def _chains(joints: int) -> list[tuple[Need, ...]]:
    found = []
    for order in permutations(range(1, joints)):
        need: dict[int, Need] = {a: (b, 1) for a, b in pairwise((0, *order))}
        found.append(tuple(need.get(joint) for joint in range(joints)))
    return found


def _literals(joints: int, positions: tuple[int, ...]) -> list[tuple[Need, ...]]:
    choices: list[list[Need]] = [
        [None, *((other, position) for other in range(joints) if other != joint for position in positions)]
        for joint in range(joints)
    ]
    return list(product(*choices))


_PRIORS: Mapping[str, tuple[Callable[[int], int], Callable[[int], list[tuple[Need, ...]]]]] = {
    "chains": (lambda n: factorial(n - 1), _chains),
    "single-parent": (lambda n: n**n, lambda n: _literals(n, (1,))),
    "any-literal": (lambda n: (2 * n - 1) ** n, lambda n: _literals(n, (0, 1))),
}
"""Of each prior over n joints the number of interlocks, unsolvable ones included, and the interlocks."""

PRIORS = tuple(_PRIORS)
"""Names of the stated priors."""


@cache
def interlocks(prior: str, joints: int) -> Interlocks:
    """All interlocks of a prior over 2 or more joints that can be solved from the start.

    >>> len(interlocks("single-parent", 4))
    142
    """
    if prior not in PRIORS:
        raise UnknownName("prior", prior, PRIORS)
    counted, listed = _PRIORS[prior]
    if (count := counted(joints)) > MOST_INTERLOCKS:
        raise BadValue(
            f"prior {prior} over {joints} joints", f"{count} interlocks", f"at most {MOST_INTERLOCKS}; chains has fewer"
        )
    needs = listed(joints)
    asks = np.array([[need[0] + 1 if need else 0 for need in row] for row in needs], dtype=np.int64)
    bits = np.concatenate([[0], 1 << np.arange(joints, dtype=np.int64)])[asks]
    finds = np.where([[bool(need and need[1]) for need in row] for row in needs], bits, 0)
    every = np.arange(1 << joints, dtype=np.int64)
    allowed = [(every & bits[:, [joint]]) == finds[:, [joint]] for joint in range(joints)]
    distance, nearer = np.full(allowed[0].shape, NEVER), np.where(allowed[0], 1, NEVER)
    while not np.array_equal(nearer, distance):  # value iteration over all interlocks and configurations
        distance = nearer
        for joint in range(1, joints):
            beyond = np.where(allowed[joint], distance[:, every ^ (1 << joint)] + 1, NEVER)
            nearer = np.minimum(nearer, beyond)
    solvable = distance[:, 0] < NEVER
    return Interlocks(
        prior=prior,
        joints=joints,
        needs=tuple(row for row, kept in zip(needs, solvable.tolist(), strict=True) if kept),
        asks=bits[solvable],
        finds=finds[solvable],
        distance=distance[solvable],
    )
