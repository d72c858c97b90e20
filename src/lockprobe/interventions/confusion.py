"""A confusion matrix as text in a spec: how often an agent misreads what its attempts did, by joint and outcome.

One entry of a joint is ``slider:0.2:0.05``: of its attempts that moved it 20 % were taken for failures (hidden moves),
of those that did not 5 % for moves (invented moves).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from lockprobe.foundation.errors import BadValue

Rates = Mapping[str, tuple[float, float]]
"""Joint -> the rates at which its moves are hidden and at which moves of it are invented, [0, 1]."""

_EXAMPLE = "joints with the rates of hidden and of invented moves, such as slider:0.2:0.05;lever:0:0.1"


def entries_of(rates: Rates) -> tuple[str, ...]:
    """The entries of a confusion matrix, as a spec holds them.

    >>> entries_of({"slider": (0.2, 0.05)})
    ('slider:0.2:0.05',)
    """
    return tuple(f"{joint}:{hidden:g}:{invented:g}" for joint, (hidden, invented) in rates.items())


@cache
def rates_of(entries: tuple[str, ...]) -> Rates:
    """The confusion matrix that entries describe.

    Raises:
        BadValue: If an entry is none, a rate is none, or a joint comes twice.
    """
    found = dict[str, tuple[float, float]]()
    for entry in entries:
        joint, *texts = entry.rsplit(":", 2)
        try:
            hidden, invented = map(float, texts)
        except ValueError:
            raise BadValue("rates", entry, _EXAMPLE) from None
        if not joint or joint in found or not (0 <= hidden <= 1 and 0 <= invented <= 1):
            raise BadValue("rates", entry, _EXAMPLE)
        found[joint] = hidden, invented
    return found
