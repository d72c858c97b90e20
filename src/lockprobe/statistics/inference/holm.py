"""Holm's correction of P values for their number (1979)."""

from __future__ import annotations

from collections.abc import Hashable, Sequence


def holm(values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number; None where there is no test."""
    adjusted, largest = list(values), 0.0
    tested = sorted((value, i) for i, value in enumerate(values) if value is not None)
    for smaller, (value, i) in enumerate(tested):
        largest = max(largest, min(1.0, (len(tested) - smaller) * value))
        adjusted[i] = largest
    return adjusted


def holm_by_family(families: Sequence[Hashable], values: Sequence[float | None]) -> list[float | None]:
    """P values corrected for their number in each family, which has an entry of its own for each of them."""
    adjusted: list[float | None] = [None] * len(values)
    for family in dict.fromkeys(families):
        places = [i for i, other in enumerate(families) if other == family]
        for i, value in zip(places, holm([values[i] for i in places]), strict=True):
            adjusted[i] = value
    return adjusted
