"""Hands out jobs to workers and collects their results: every job has exactly one.

A worker is hired for every processor. It sets itself up once and then works on the jobs that it receives, which are
about a quarter of a second of work at once. A worker may be lost with what it was doing: its process dies, or a node of
a cluster goes away. Its jobs are then given to others, each alone, and what it may still return is ignored. A job that
has lost as many workers as the pool allows is :class:`Lost`. The work ends only if workers are lost three times in a
row with nothing finished in between.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Generic, TypeVar

from lockprobe.foundation.errors import Missing

_J = TypeVar("_J")
_R = TypeVar("_R")

Begin = Callable[[], Callable[[_J], _R]]
"""Called once in every worker; returns the function that works on a job. It is sent by name."""

_IN_A_ROW = 3
"""The most losses of workers in a row."""

_AT_ONCE = 0.25
"""Seconds of work that are sent at once. A call takes some milliseconds."""

_LOOK = 1.0
"""Seconds after which a pool is looked at for new processors and for workers that do not answer."""


@dataclass(frozen=True, slots=True)
class Lost:
    """The result of a job whose workers were all lost, and why the last one was.

    If that is ``explained`` it is the reason of the job, which gave itself up, and says nothing of the pool.
    """

    why: str
    explained: bool = False


@dataclass(frozen=True, slots=True)
class BatchResult:
    """The answer of a worker to a batch of jobs; its first, to no jobs, says that it has set itself up."""

    results: list[Any]
    seconds: float

    @classmethod
    def of(cls, work: Callable[[Any], Any], jobs: Sequence[Any]) -> BatchResult:
        """Do a batch of jobs."""
        began = time.perf_counter()
        return cls([work(job) for job in jobs], time.perf_counter() - began)


class Pool(ABC):
    """A place where workers are hired.

    Attributes:
        losses: Workers that a job may lose, alone, before it is lost.
        patience: Seconds after which a silent worker is given up; 20 times the longest answer if that is longer.
        remedy: What helps if workers keep being lost.
    """

    losses: ClassVar[int]
    patience: ClassVar[float]
    remedy: str

    def each(
        self,
        begin: Begin[_J, _R],
        jobs: Iterable[_J],
        hear: Callable[[Any], None] = lambda said: None,
        *,
        together: bool = True,
    ) -> Iterator[tuple[_J, _R | Lost]]:
        """Yield each job with its one result, in the order in which results arrive.

        ``hear`` is called with what a worker says meanwhile (:func:`.tell`), where the place can hear it. Short jobs
        are sent ``together``; if their worker is lost, all of them are done again. Raises what ``begin`` or a job
        raises, and ``Missing`` if workers keep being lost.
        """
        work = _Driver(self, begin, jobs, hear, _AT_ONCE if together else 0.0)
        try:
            yield from work.results()
        finally:
            for call in work.calls.values():
                self.dismiss(call.worker)

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """The results in the order of the jobs. ``work`` is a function of a module, and has no state."""
        kept, following = dict[int, _R](), 0
        begin: Begin[tuple[int, _J], _R] = partial(_of_numbered, work)
        for (number, _), result in self.each(begin, list(enumerate(jobs))):
            if isinstance(result, Lost):
                raise Missing(f"a worker was lost before its work was done ({result.why})", self.remedy)
            kept[number] = result
            while following in kept:
                yield kept.pop(following)
                following += 1

    @abstractmethod
    def processors(self) -> int:
        """How many workers there can be now."""

    @abstractmethod
    def hire(self, begin: Begin[Any, Any]) -> tuple[Any, Any]:
        """A new worker, and the reference of its first answer."""

    @abstractmethod
    def send(self, worker: Any, jobs: Sequence[Any]) -> Any:
        """Send an idle worker a batch, and return the reference of its answer."""

    @abstractmethod
    def answered(self, references: Sequence[Any], seconds: float, hear: Callable[[Any], None]) -> list[Any]:
        """The references that have an answer; wait up to so many seconds for the first."""

    @abstractmethod
    def answer(self, reference: Any) -> BatchResult | Lost:
        """The answer of a reference; raises what the worker raised."""

    @abstractmethod
    def dismiss(self, worker: Any) -> None:
        """End a worker; what it is doing is lost."""


def _of_numbered(work: Callable[[_J], _R]) -> Callable[[tuple[int, _J]], _R]:
    return lambda job: work(job[1])


@dataclass(slots=True)
class _QueuedJob(Generic[_J]):
    value: _J
    losses: int = 0
    alone: bool = False


@dataclass(slots=True)
class _Call(Generic[_J]):
    """A pending call of a worker; its first has no jobs and sets the worker up."""

    worker: Any
    since: float
    jobs: list[_QueuedJob[_J]] = field(default_factory=list)


class _Driver(Generic[_J, _R]):
    """The driver's side of :meth:`Pool.each`; ``calls`` are those on their way."""

    def __init__(
        self, pool: Pool, begin: Begin[_J, _R], jobs: Iterable[_J], hear: Callable[[Any], None], at_once: float
    ) -> None:
        self.calls: dict[Any, _Call[_J]] = {}
        self._pool, self._begin, self._hear, self._at_once = pool, begin, hear, at_once
        self._queue = deque(_QueuedJob(job) for job in jobs)
        self._lost_in_a_row, self._counted = 0, -math.inf
        self._seconds = _AT_ONCE  # of one job, as measured
        self._longest = 0.0
        self._processors, self._looked = 0, -_LOOK

    def results(self) -> Iterator[tuple[_J, _R | Lost]]:
        while self._queue or any(call.jobs for call in self.calls.values()):
            if time.monotonic() - self._looked >= _LOOK:  # processors may join and leave
                self._looked, self._processors = time.monotonic(), max(1, self._pool.processors())
            busy = sum(bool(call.jobs) for call in self.calls.values())
            for _ in range(min(self._processors, busy + len(self._queue)) - len(self.calls)):
                worker, reference = self._pool.hire(self._begin)
                self.calls[reference] = _Call(worker, time.monotonic())
            for reference in self._pool.answered(list(self.calls), _LOOK, self._hear):
                answer = self._pool.answer(reference)
                yield from self._lose(reference, answer) if isinstance(answer, Lost) else self._go_on(reference, answer)
            patience = max(self._pool.patience, 20 * self._longest)
            late = [one for one, call in self.calls.items() if call.jobs and time.monotonic() - call.since > patience]
            for reference in late:
                yield from self._lose(reference, Lost("it did not answer"))

    def _go_on(self, reference: Any, answer: BatchResult) -> Iterator[tuple[_J, _R]]:
        """Give a worker its next jobs, or dismiss it, and yield the results of the last."""
        call = self.calls.pop(reference)
        if call.jobs:
            self._lost_in_a_row, self._counted = 0, time.monotonic()
            self._longest = max(self._longest, time.monotonic() - call.since)
            self._seconds = (self._seconds + answer.seconds / len(call.jobs)) / 2
        # jobs for about a quarter of a second, fewer at the end; a lost job goes alone
        most = min(self._at_once / max(self._seconds, 1e-6), len(self._queue) / (2 * max(1, self._processors)))
        jobs: list[_QueuedJob[_J]] = []
        while self._queue and len(jobs) < max(1, most) and not (jobs and (self._queue[0].alone or jobs[0].alone)):
            jobs.append(self._queue.popleft())
        if jobs:  # at once, so that it works while its results are written down
            sent = self._pool.send(call.worker, [job.value for job in jobs])
            self.calls[sent] = _Call(call.worker, time.monotonic(), jobs)
        else:
            self._pool.dismiss(call.worker)
        for job, result in zip(call.jobs, answer.results, strict=True):
            yield job.value, result

    def _lose(self, reference: Any, lost: Lost) -> Iterator[tuple[_J, Lost]]:
        """Put the jobs of a lost worker at the end of the queue; yield those that lost too many alone."""
        call = self.calls.pop(reference)
        self._pool.dismiss(call.worker)
        if call.since > self._counted and not lost.explained:  # what is lost together, as with its node, is one loss
            self._lost_in_a_row, self._counted = self._lost_in_a_row + 1, time.monotonic()
        for job in call.jobs:
            job.losses += len(call.jobs) == 1
            job.alone = True
            if job.losses >= self._pool.losses or (lost.explained and len(call.jobs) == 1):
                yield job.value, lost
            else:
                self._queue.append(job)
        if self._lost_in_a_row >= _IN_A_ROW:
            often = f"{_IN_A_ROW} times in a row, with nothing finished in between"
            raise Missing(f"workers were lost {often} ({lost.why})", self._pool.remedy)
