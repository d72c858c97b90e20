"""The paper's binary integer linear programme (ILP, Sec. 3.3), solved to optimality by HiGHS: the reference."""

from __future__ import annotations

from itertools import accumulate
from typing import Literal

import numpy as np

from lockprobe.foundation.errors import LockprobeError
from lockprobe.statistics.loops.words import Interval, all_loops, whole_copies

__all__ = ["programme_pieces"]


def programme_pieces(
    text: str, rule: Literal["free", "repeat", "whole"], min_length: int, *, overlap: bool
) -> list[Interval]:
    """The pieces of a greatest cover, in order.

    Each action is covered at most once; under ``repeat`` twice a copy is at most the sum of its loop's.
    The gain is the covered length, less a bit per binary, plus a smaller bit for long pieces (``whole``: short).
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array

    n, loops = len(text), all_loops(text, min_length, overlap=overlap)
    if not (choices := whole_copies(loops) if rule == "whole" else _single_copies(loops)):
        return []
    cells = [(i + k, c, 1) for c, copies in enumerate(choices) for i, size in copies for k in range(size)]
    limits = [1] * n
    if rule == "repeat":
        limits += [0] * len(choices)
        ends = list(accumulate(len(starts) for starts in loops.values()))
        for first, end in zip([0, *ends], ends, strict=False):
            cells += [(n + c, d, 2 * (c == d) - 1) for c in range(first, end) for d in range(first, end)]
    rows, columns, factors = zip(*cells, strict=True)
    matrix = csr_array((factors, (rows, columns)), shape=(len(limits), len(choices)))
    lean = -1 if rule == "whole" else 1
    gains = [sum(size for _, size in c) - 1 / (n + 1) + lean * c[0][1] ** 2 / (n + 1) ** 3 for c in choices]
    solution = milp(
        -np.asarray(gains),
        integrality=np.ones(len(choices), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(matrix, ub=limits),
        options={"mip_rel_gap": 0.0},
    )
    if not solution.success:
        raise LockprobeError(f"the loop cover of a trial of {n} actions was not found: {solution.message}")
    return sorted(piece for copies, x in zip(choices, solution.x, strict=True) if x > 0.5 for piece in copies)


def _single_copies(loops: dict[str, list[int]]) -> list[list[Interval]]:
    return [[(start, len(word))] for word, starts in loops.items() for start in starts]
