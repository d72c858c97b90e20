"""Hands out jobs to workers and collects their results: every job has exactly one.

A worker is hired for every processor. It sets itself up once and then works on the jobs that it receives, short ones
several at once. A worker may be lost with what it was doing: its process dies, or a node of a cluster goes away. Its
jobs are then given to others, each alone. A job that alone has lost as many workers as the pool allows is
:class:`Lost`. The work ends only if workers keep being lost with nothing finished in between.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, ClassVar, TypeVar

from lockprobe.foundation.errors import Missing

_J = TypeVar("_J")
_R = TypeVar("_R")

Begin = Callable[[], Callable[[_J], _R]]
"""Called once in every worker; returns the function that works on a job. It is sent by name."""

_WAIT = 1.0
"""Seconds after which a wait for workers begins anew, so that Ctrl-C is heard."""


@dataclass(frozen=True, slots=True)
class Lost:
    """The result of a job whose workers were all lost, and why the last one was.

    If that is ``explained`` it is the reason of the job, which gave itself up, and says nothing of the pool.
    """

    why: str
    explained: bool = False


class Pool(ABC):
    """A place where workers are hired.

    Attributes:
        losses: Workers that a job may lose, alone, before it is lost.
        remedy: What helps if workers keep being lost.
    """

    losses: ClassVar[int]
    remedy: str

    def each(self, begin: Begin[_J, _R], jobs: Iterable[_J], *, at_once: int = 1) -> Iterator[tuple[_J, _R | Lost]]:
        """Yield each job with its one result, in the order in which results arrive.

        Jobs are taken when a worker is free for them. Up to ``at_once`` are sent together; if their worker is lost,
        all of them are done again. Raises what ``begin`` or a job raises, and ``Missing`` if workers keep being lost.
        """
        processors, todo = max(1, self.processors()), iter(jobs)
        batches = iter(lambda: [*islice(todo, at_once)], [])
        # jobs that a worker gets at once, and how many workers a single one has lost
        queue, lost_in_a_row = deque[tuple[list[_J], int]](), 0
        working = dict[Any, tuple[list[_J], int]]()
        try:
            while True:
                queue.extend((batch, 0) for batch in islice(batches, max(0, processors - len(queue))))
                busy = sum(bool(batch) for batch, _ in working.values())
                if not (queue or busy):
                    return
                for _ in range(min(processors, busy + len(queue)) - len(working)):
                    working[self.hire(begin)] = [], 0
                for worker, answer in self.answers([*working], _WAIT):
                    batch, losses = working.pop(worker)
                    if isinstance(answer, Lost):
                        self.dismiss(worker, idle=False)
                        losses += len(batch) == 1
                        if len(batch) == 1 and (answer.explained or losses == self.losses):
                            yield batch[0], answer
                        else:
                            queue.extend(([job], losses) for job in batch)
                        lost_in_a_row += not answer.explained
                        if lost_in_a_row > processors + 1:  # a node is lost with all that it does
                            often = f"{lost_in_a_row} times in a row, with nothing finished in between"
                            raise Missing(f"workers were lost {often} ({answer.why})", self.remedy)
                        continue
                    lost_in_a_row = 0 if batch else lost_in_a_row
                    if queue:  # at once, so that it works while its results are written down
                        working[worker] = queue.popleft()
                        self.send(worker, working[worker][0])
                    else:
                        self.dismiss(worker, idle=True)
                    yield from zip(batch, answer, strict=True)
        finally:
            for worker in working:
                self.dismiss(worker, idle=False)

    @abstractmethod
    def processors(self) -> int:
        """How many workers there can be."""

    @abstractmethod
    def hire(self, begin: Begin[Any, Any]) -> Any:
        """A new worker, which answers with no results when it has set itself up."""

    @abstractmethod
    def send(self, worker: Any, jobs: Sequence[Any]) -> None:
        """Send an idle worker a batch."""

    @abstractmethod
    def answers(self, workers: Sequence[Any], seconds: float) -> Iterator[tuple[Any, Sequence[Any] | Lost]]:
        """The results of workers that have answered or are lost; wait up to so many seconds for the first.

        Raises what a worker raised.
        """

    @abstractmethod
    def dismiss(self, worker: Any, *, idle: bool) -> None:
        """End a worker; what it is doing is lost."""
