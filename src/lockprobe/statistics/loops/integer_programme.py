"""The paper's binary integer linear programme (ILP, Sec. 3.3), solved to optimality by HiGHS: the reference."""

from __future__ import annotations

import numpy as np

from lockprobe.foundation.errors import LockprobeError
from lockprobe.statistics.loops.words import Interval, all_loops


def programme_pieces(text: str, min_length: int, *, overlap: bool) -> list[Interval]:
    """The pieces of a greatest cover, in order.

    Each action is covered at most once. The gain is the covered length, less a bit per piece, plus a smaller bit for
    long pieces.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array

    n, loops = len(text), all_loops(text, min_length, overlap=overlap)
    if not (choices := [(start, len(word)) for word, starts in loops.items() for start in starts]):
        return []
    rows, columns = zip(*((start + k, c) for c, (start, size) in enumerate(choices) for k in range(size)), strict=True)
    matrix = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, len(choices)))
    gains = np.array([size - 1 / (n + 1) + size**2 / (n + 1) ** 3 for _, size in choices])
    solution = milp(
        -gains,
        integrality=np.ones(len(choices), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(matrix, ub=1),
        options={"mip_rel_gap": 0.0},
    )
    if not solution.success:
        raise LockprobeError(f"the loop cover of a trial of {n} actions was not found: {solution.message}")
    return sorted(piece for piece, x in zip(choices, solution.x, strict=True) if x > 0.5)
