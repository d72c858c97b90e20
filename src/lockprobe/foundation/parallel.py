"""Runs the same function on many jobs in parallel, in processes of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, Protocol, TypeVar

from lockprobe.foundation.errors import Missing

__all__ = ["THIS_PROCESS", "Each", "Pool", "Processes", "end_with_parent"]

Each = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""Applies a function to several jobs and keeps their order: ``map``, or a pool of processes."""

_J = TypeVar("_J")
_R = TypeVar("_R")


class Pool(Protocol):
    """A pool of workers. :class:`lockprobe.foundation.cluster.Cluster` is another implementation."""

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """The results in the order of the jobs. ``work`` is a function of a module, and has no state."""
        ...


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
        try:
            with ProcessPoolExecutor(self.count, mp_context=get_context("spawn")) as pool:
                yield from pool.map(work, jobs)
        except BrokenProcessPool:
            remedy = f"is there memory enough for {self.count}? try --workers 1"
            raise Missing("a worker process died before its work was done", remedy) from None


def end_with_parent() -> None:
    """End this process when the one that started it is gone: where that is killed, it would wait for work forever."""
    Thread(target=_wait_and_end, args=(parent_process(),), daemon=True).start()


def _wait_and_end(parent: BaseProcess | None) -> None:
    if parent:
        parent.join()
        os._exit(1)


THIS_PROCESS = Processes(1)
"""One job after the other, here."""
