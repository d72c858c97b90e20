"""The order of a study's blocks, in which tests that hold at every look take them.

A sequential test needs an order in which no block's place depends on its own outcome. The order of *arrival* is none:
of trials that are played at once, those that are solved soon end first. So blocks are taken as planned, up to the first
one with a trial that is still open. Whether a block is played at all may depend on those before it: a condition that is
decided is no longer played.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockOrder:
    """That what is said of an agent's trials must hold at every look, and in which order its blocks were planned.

    Attributes:
        plans: Repetitions, and trials per repetition, of the study as it was first planned and after each extension,
            every one at least as large as those before. Blocks of an earlier plan come before all added to it.
        margin: The largest difference in success that counts as none, (0, 1), if such statements are made too.
    """

    plans: tuple[tuple[int, int], ...]
    margin: float | None = None

    def rank(self, repetition: ArrayLike, trial: ArrayLike) -> NDArray[np.int64]:
        """The places of blocks in the order, from 0.

        >>> BlockOrder(plans=((1, 2), (2, 3))).rank([1, 1, 1, 2], [1, 2, 3, 1]).tolist()
        [0, 1, 2, 3]
        """
        rows, columns = (max(plan[i] for plan in self.plans) for i in (0, 1))
        place = np.full((rows, columns), -1, dtype=np.int64)
        for repetitions, trials in self.plans:
            part = place[:repetitions, :trials]
            new = part < 0
            part[new] = np.arange(new.sum()) + place.max() + 1
        found: NDArray[np.int64] = place[np.asarray(repetition, int) - 1, np.asarray(trial, int) - 1]
        return found


NO_ORDERS: Mapping[str, BlockOrder] = {}
"""No agent of whose trials anything must hold at every look: of a study of fixed size that is finished."""
