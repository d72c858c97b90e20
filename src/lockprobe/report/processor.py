"""How a report uses its processor: without the collector of garbage, and on one thread; and how it uses a cluster."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TypeVar

from threadpoolctl import threadpool_limits

from lockprobe.foundation.parallel import Each, Pool
from lockprobe.studies.file_names import RECORDS

LARGE = 500_000
"""Bytes of records from which on a cluster pays."""

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")


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


def each_on(elsewhere: Pool | None, directory: Path) -> Each:
    """How the jobs of the report of this study are done: one after the other here, or those of a large one elsewhere.

    Another process of this machine would take more processor time to begin than it takes over.
    """
    records = directory / RECORDS
    if elsewhere is None or not records.is_file() or records.stat().st_size < LARGE:
        return map
    return lambda work, jobs: list(elsewhere.map(partial(_on_one_thread, work), list(jobs)))


def _on_one_thread(work: Callable[[_Job], _Done], job: _Job) -> _Done:
    """Work as it is done here, on another machine."""
    with one_thread():
        return work(job)
