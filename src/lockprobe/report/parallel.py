"""The work of a large report, shared with processes of their own. They change no byte of it."""

from __future__ import annotations

import atexit
import gc
import os
import pickle
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from lockprobe.foundation.parallel import Each, Pool, Spawned, begin_helper
from lockprobe.studies.file_names import RECORDS

LARGE = 500_000
"""Bytes of records from which on another process pays; a second of processor time starts it."""

HUGE = 1_000_000_000
"""Bytes of records from which on memory is short: this process then works alone."""

_NEEDED = ("lockprobe.report.report_files", "lockprobe.report.figures")
"""Modules that another process will need: two seconds of imports."""

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

    The matrices are small, and threads of two processes on two processors wait for each other. The last digits of sums
    depend on the number of threads: with one, they are the same on every machine.
    """
    return threadpool_limits(1)


def _on_one_thread(work: Callable[[_Job], _Done], job: _Job) -> _Done:
    """Work as it is done here, on another machine."""
    with one_thread():
        return work(job)


@contextmanager
def shared(directory: Path, processes: int, elsewhere: Pool | None = None) -> Iterator[Each]:
    """A way to work on several things at once, where that pays.

    Whoever is free takes the next job; the first is always done by this process. What another process had taken when
    it was killed, as where memory ends, is done by this one.

    Args:
        directory: The directory of a study.
        processes: This one and the others.
        elsewhere: Other machines, which then do it instead.
    """
    records = directory / RECORDS
    size = records.stat().st_size if records.is_file() else 0
    large = size >= LARGE
    if large and elsewhere is not None:
        yield lambda work, jobs: list(elsewhere.map(partial(_on_one_thread, work), list(jobs)))
    elif large and processes > 1 and size < HUGE:
        with Spawned(processes - 1, _begin) as pool, ThreadPoolExecutor(processes - 1) as errands:
            for _ in range(processes - 1):
                pool.submit(_import)  # while this one computes
            yield partial(_each, pool, errands, processes - 1)
    else:
        yield map


def _each(
    pool: Spawned, errands: ThreadPoolExecutor, others: int, work: Callable[[_Job], _Done], jobs: Iterable[_Job], /
) -> list[_Done]:
    """The results of all jobs, by this process and so many others."""
    waiting, lost, done = deque(enumerate(jobs)), list[tuple[int, _Job]](), dict[int, _Done]()

    def take(call: Callable[[_Job], _Done]) -> None:
        while waiting:
            try:
                i, job = waiting.popleft()
            except IndexError:
                return
            try:
                done[i] = call(job)
            except BrokenProcessPool:
                lost.append((i, job))
                return

    if not waiting:
        return []
    i, job = waiting.popleft()
    sent = _sent(work)  # before anything here changes what it holds
    elsewhere = [errands.submit(take, lambda job: pool.submit(_work, sent, job).result()) for _ in range(others)]
    try:
        done[i] = work(job)
        take(work)
    finally:
        waiting.clear()
    for errand in elsewhere:
        errand.result()
    done |= {i: work(job) for i, job in lost}
    return [done[i] for i in range(len(done))]


@lru_cache(maxsize=1)
def _sent(work: Callable[[Any], Any]) -> bytes:
    """Work as it is sent; that of results, which are long, once."""
    return pickle.dumps(work)


def _work(sent: bytes, job: _Job) -> Any:
    """Work that another process has sent, which is the same for many jobs."""
    return _received(sent)(job)


@lru_cache(maxsize=1)
def _received(sent: bytes) -> Callable[[Any], Any]:
    received: Callable[[Any], Any] = pickle.loads(sent)  # noqa: S301  of the process that started this one
    return received


def _import() -> None:
    for name in _NEEDED:
        import_module(name)


def _begin() -> None:
    """What another process does first: nobody collects there, and it does not outlive the one that started it."""
    begin_helper()
    gc.disable()
    atexit.register(os._exit, 0)  # freeing every object takes a second
    one_thread()  # for as long as the process lives
