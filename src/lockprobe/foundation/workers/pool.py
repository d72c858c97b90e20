"""Hands out jobs to workers and collects their results: every job has exactly one.

A worker is hired for every processor. It sets itself up once and then works on one job after the other. A worker may
be lost with its job: its process dies, or a node of a cluster goes away. The job is then given to another one, and if
it has lost as many workers as the pool allows, it is :class:`Lost`. The work ends only if workers keep being lost with
nothing finished in between.
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
        losses: Workers that a job may lose before it is lost.
        remedy: What helps if workers keep being lost.
    """

    losses: ClassVar[int]
    remedy: str

    def each(self, begin: Begin[_J, _R], jobs: Iterable[_J]) -> Iterator[tuple[_J, _R | Lost]]:
        """Yield each job with its one result, in the order in which results arrive.

        Jobs are taken when a worker is free for them. Raises what ``begin`` or a job raises, and ``Missing`` if workers
        keep being lost.
        """
        processors, todo, lost_in_a_row, why = max(1, self.processors()), iter(jobs), 0, ""
        queue = deque[tuple[_J, int]]()  # how many workers each has lost
        working = dict[Any, tuple[_J, int] | None]()  # a new one sets itself up
        try:
            while lost_in_a_row <= processors + 1:  # a node is lost with all that it does
                queue.extend((job, 0) for job in islice(todo, max(0, processors - len(queue))))
                busy = sum(now is not None for now in working.values())
                if not (queue or busy):
                    return
                for _ in range(min(processors, busy + len(queue)) - len(working)):
                    working[self.hire(begin)] = None
                for worker, answer in self.answers([*working], _WAIT):
                    now = working.pop(worker)
                    if isinstance(answer, Lost):
                        self.dismiss(worker, idle=False)
                        lost_in_a_row, why = lost_in_a_row + (not answer.explained), answer.why
                        if now and not answer.explained and now[1] + 1 < self.losses:
                            queue.append((now[0], now[1] + 1))
                            now = None
                    elif queue:  # at once, so that it works while its result is written down
                        working[worker] = after = queue.popleft()
                        self.send(worker, after[0])
                    else:
                        self.dismiss(worker, idle=True)
                    if now:
                        lost_in_a_row *= isinstance(answer, Lost)
                        yield now[0], answer
            often = f"{lost_in_a_row} times in a row, with nothing finished in between"
            raise Missing(f"workers were lost {often} ({why})", self.remedy)
        finally:
            for worker in working:
                self.dismiss(worker, idle=False)

    @abstractmethod
    def processors(self) -> int:
        """How many workers there can be."""

    @abstractmethod
    def hire(self, begin: Begin[Any, Any]) -> Any:
        """A new worker, which answers when it has set itself up; what does not matter."""

    @abstractmethod
    def send(self, worker: Any, job: Any) -> None:
        """Send an idle worker a job."""

    @abstractmethod
    def answers(self, workers: Sequence[Any], seconds: float) -> Iterator[tuple[Any, Any]]:
        """The results of workers that have answered or are lost; wait up to so many seconds for the first.

        Raises what a worker raised.
        """

    @abstractmethod
    def dismiss(self, worker: Any, *, idle: bool) -> None:
        """End a worker; what it is doing is lost."""
