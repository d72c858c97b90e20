"""How a report uses its processor: without the collector of garbage, and on one thread."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def uncollected() -> Iterator[None]:
    """Without the collector of cyclic garbage, which would look through all trials again and again and find little.

    What was made within it then counts as old, so that the next look at what is young does not begin with all of it.
    """
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.freeze()
            gc.unfreeze()
            gc.enable()


def one_thread() -> threadpool_limits:
    """A context in which products of matrices take one thread.

    The last digits of sums depend on the number of threads: with one, they are the same on every machine.
    """
    return threadpool_limits(1)
