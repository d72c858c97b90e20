"""Runs the same function on many jobs in parallel, in processes of this machine."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, Protocol, TypeVar

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.interrupts import end_at_interrupt, held_back
from lockprobe.foundation.safe_path import safe_path

_J = TypeVar("_J")
_R = TypeVar("_R")


class Pool(Protocol):
    """A pool of workers. :class:`lockprobe.foundation.cluster.Cluster` is another implementation."""

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """The results in the order of the jobs. ``work`` is a function of a module, and has no state."""
        ...


class Spawned(ProcessPoolExecutor):
    """Fresh processes of this machine. Ctrl-C is held back in each until its ``initializer`` says what it does."""

    def __init__(self, count: int, initializer: Callable[..., None], *initargs: Any) -> None:
        with safe_path():  # the first semaphore starts a process that keeps track of all
            super().__init__(count, mp_context=get_context("spawn"), initializer=initializer, initargs=initargs)

    def submit(self, fn: Callable[..., _R], /, *args: Any, **kwargs: Any) -> Future[_R]:
        """Submit a job, for which a process may be started."""
        with held_back():
            return super().submit(fn, *args, **kwargs)


@dataclass(frozen=True, slots=True)
class Processes:
    """Processes of this machine.

    Attributes:
        count: The number of processes, at least 1. One is this process.
    """

    count: int = 1

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """The results in the order of the jobs.

        Raises:
            Missing: If a process dies.
        """
        if self.count == 1:
            yield from map(work, jobs)
            return
        pool = Spawned(self.count, begin_helper)
        try:
            under_way = deque(pool.submit(work, job) for job in jobs)
            while under_way:
                yield under_way.popleft().result()
        except BrokenProcessPool:
            remedy = f"is there memory enough for {self.count}? try --workers 1"
            raise Missing("a worker process died before its work was done", remedy) from None
        finally:
            pool.shutdown(cancel_futures=True)


def begin_helper() -> None:
    """What a process that helps another one does first: it ends with that one, and at Ctrl-C."""
    end_at_interrupt()
    end_with_parent()


def end_with_parent() -> None:
    """End this process when the one that started it is gone: where that is killed, it would wait for work forever."""
    Thread(target=_wait_and_end, args=(parent_process(),), daemon=True).start()


def _wait_and_end(parent: BaseProcess | None) -> None:
    if parent:
        parent.join()
        os._exit(1)


THIS_PROCESS = Processes(1)
"""One job after the other, here."""
