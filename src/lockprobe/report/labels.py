"""Names beside what they name, none on another one."""

from __future__ import annotations

from collections.abc import Sequence


def placed(wanted: Sequence[float], low: float, high: float, apart: float) -> list[float]:
    """Heights of names near those of what they name: none closer to another than ``apart``, all within the axes.

    Neighbours that are too close become a block around their mean; blocks that meet become one.

    >>> placed([100, 104, 300], 0, 400, 24), placed([395, 396], 0, 400, 24), placed([], 0, 1, 24)
    ([90.0, 114.0, 300.0], [376.0, 400.0], [])
    """
    order = sorted(range(len(wanted)), key=lambda i: (wanted[i], i))
    blocks: list[tuple[list[int], float]] = []  # names from the top, and the height of the first
    for i in order:
        blocks.append(([i], min(max(wanted[i], low), high)))
        while len(blocks) > 1 and blocks[-1][1] < blocks[-2][1] + apart * len(blocks[-2][0]):
            (above, _), (below, _) = blocks[-2:]
            names = above + below
            tall = apart * (len(names) - 1)
            first = sum(wanted[name] for name in names) / len(names) - tall / 2
            blocks[-2:] = [(names, max(low, min(first, high - tall)))]
    found = {name: first + apart * i for names, first in blocks for i, name in enumerate(names)}
    return [float(found[i]) for i in range(len(wanted))]
