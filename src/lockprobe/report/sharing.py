"""The work of a large report, shared with processes of their own. They change no byte of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from lockprobe.analysis.summary import Each

__all__ = ["LARGE", "shared"]

LARGE = 2_000_000
"""Bytes of records from which on another process pays; it takes about two seconds to start."""

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")


@contextmanager
def shared(directory: Path, processes: int) -> Iterator[tuple[Each, int]]:
    """A way to work on several things at once, where that pays, and on how many.

    Args:
        directory: The directory of a study.
        processes: This one, and how many beside it.
    """
    records = directory / "trials.jsonl"
    if processes < 2 or not records.is_file() or records.stat().st_size < LARGE:
        yield map, 1
        return
    with ProcessPoolExecutor(processes - 1, mp_context=get_context("spawn")) as pool:

        def each(work: Callable[[_Job], _Done], jobs: Iterable[_Job], /) -> list[_Done]:
            waiting = list(jobs)
            given = {i: pool.submit(work, job) for i, job in enumerate(waiting) if i % processes}
            done = {i: work(job) for i, job in enumerate(waiting) if i not in given}
            return [given[i].result() if i in given else done[i] for i in range(len(waiting))]

        yield each, processes
