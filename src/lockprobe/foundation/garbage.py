"""The collector of cyclic garbage while many small things are made and dropped.

The collector of Python looks through all objects again and again, also through those that imported libraries made,
which no run drops. With the libraries of hosted models this is a fifth of the processor time of a call.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["spared"]

_AT_ONCE = 10_000
"""Objects made and not dropped after which the collector looks at the young ones; Python's own value is 700 or 2000."""


@contextmanager
def spared() -> Iterator[None]:
    """Spare the collector what is already there, and let it look less often for what comes.

    Who lets it look as seldom already is left alone: to ask whether something is frozen takes time for all that is.
    """
    young, middle, old = gc.get_threshold()
    if young == 0 or young >= _AT_ONCE:
        yield
        return
    here = not gc.get_freeze_count()  # else somebody else has frozen what was there, for good
    if here:
        gc.freeze()
    gc.set_threshold(_AT_ONCE, middle, old)
    try:
        yield
    finally:
        gc.set_threshold(young, middle, old)
        if here:
            gc.unfreeze()
