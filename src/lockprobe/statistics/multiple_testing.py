"""P values corrected for their number."""

from __future__ import annotations

from collections.abc import Hashable, Sequence


def holm(values: Sequence[float | None], families: Sequence[Hashable] = ()) -> list[float | None]:
    """P values corrected for their number (Holm 1979), or for that in the family of each; None without a test."""
    adjusted, of = list(values), families or [None] * len(values)
    for family in dict.fromkeys(of):
        tested = sorted((value, i) for i, value in enumerate(values) if value is not None and of[i] == family)
        largest = 0.0
        for smaller, (value, i) in enumerate(tested):
            adjusted[i] = largest = max(largest, min(1.0, (len(tested) - smaller) * value))
    return adjusted
