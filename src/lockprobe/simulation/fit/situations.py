"""Choices in equal situations, which a model predicts equally: its likelihood is computed once for all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Situations"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Situations:
    """The situations of some choices, in order of first appearance.

    Attributes:
        which: The situation of each choice, shape (choices,).
        counts: The number of choices in each situation, at least 1, shape (situations,).
    """

    which: Integers
    counts: Array

    @classmethod
    def of(cls, *columns: NDArray[np.generic]) -> tuple[Situations, Integers]:
        """The situations, and the first choice in each, of choices that differ in some column.

        Columns have one row per choice, of any shape.
        """
        flat = [column.reshape(len(column), math.prod(column.shape[1:])) for column in columns]
        table = np.column_stack(flat).astype(np.float64) + 0.0  # so that -0 is 0
        rows = table.view(f"V{table.itemsize * table.shape[1]}").ravel().tolist()
        places: dict[bytes, int] = {}
        which = np.array([places.setdefault(row, len(places)) for row in rows], dtype=np.int64)
        first = np.unique(which, return_index=True)[1]
        return cls(which, np.bincount(which).astype(np.float64)), first

    def at(self, rows: Flags) -> tuple[Situations, Flags]:
        """The situations of some choices, a boolean array of shape (choices,), and which of these they are."""
        counts = np.bincount(self.which[rows], minlength=len(self.counts)).astype(np.float64)
        kept = counts > 0
        places = np.cumsum(kept) - 1
        return Situations(places[self.which[rows]], counts[kept]), kept
