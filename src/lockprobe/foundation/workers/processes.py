"""Workers that are processes of this machine."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, ClassVar, TypeVar, cast

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.interrupts import held_back
from lockprobe.foundation.workers.pool import BatchResult, Begin, Lost, Pool, Ready, tell, tell_by

_J = TypeVar("_J")
_R = TypeVar("_R")


@dataclass(slots=True, eq=False)
class _Worker:
    process: SpawnProcess
    pipe: Connection
    answer: Ready | BatchResult | Lost | UserMistake | None = None


@dataclass(frozen=True, slots=True)
class _Gone:
    """What a process says last, when it gives its job up."""

    why: str


class Processes(Pool):
    """Processes of this machine. Each begins anew, and ends with this one.

    Args:
        count: The most of them, at least 1. :meth:`map` needs none for 1.
    """

    losses: ClassVar[int] = 1
    patience: ClassVar[float] = math.inf

    def __init__(self, count: int = 1) -> None:
        self.count = count
        self.remedy = f"is there memory enough for {count}? try --workers 1"

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """:meth:`Pool.map`, in this process if there is one only."""
        return map(work, jobs) if self.count == 1 else super().map(work, jobs)

    def processors(self) -> int:
        """Their number."""
        return self.count

    def hire(self, begin: Begin[Any, Any]) -> tuple[_Worker, _Worker]:
        """Start a process. It imports nothing from the working directory."""
        context = multiprocessing.get_context("spawn")
        with held_back():
            ours, theirs = context.Pipe()
            process = context.Process(target=_work, args=(begin, theirs), daemon=True)
            process.start()
        theirs.close()
        worker = _Worker(process, ours)
        return worker, worker

    def send(self, worker: _Worker, jobs: Sequence[Any]) -> _Worker:
        """Send a batch through the pipe of a process."""
        worker.answer = None
        with suppress(BrokenPipeError, ConnectionResetError):  # it died while it was idle; what it left says so
            worker.pipe.send(jobs)
        return worker

    def answered(self, references: Sequence[_Worker], seconds: float, hear: Callable[[Any], None]) -> list[_Worker]:
        """The processes that have answered or ended."""
        by_pipe = {worker.pipe: worker for worker in references}
        for pipe in wait(list(by_pipe), timeout=seconds):
            worker = by_pipe[cast(Connection, pipe)]
            try:
                said = worker.pipe.recv()
            except (EOFError, ConnectionResetError):
                worker.process.join()
                said = Lost(f"a worker process died, exit status {worker.process.exitcode}")
            if isinstance(said, _Gone):
                said = Lost(said.why, explained=True)
            if isinstance(said, Ready | BatchResult | Lost | UserMistake):
                worker.answer = said
            else:
                hear(said)
        return [worker for worker in references if worker.answer is not None]

    def answer(self, reference: _Worker) -> Ready | BatchResult | Lost:
        """What a process answered."""
        answer, reference.answer = reference.answer, None
        if isinstance(answer, UserMistake):
            raise answer
        assert answer is not None
        return answer

    def dismiss(self, worker: _Worker) -> None:
        """End a process."""
        worker.process.terminate()
        worker.process.join()
        worker.pipe.close()


THIS_PROCESS = Processes(1)
"""One job after the other, here, for :meth:`Pool.map`."""


def lose(why: str) -> None:
    """End this worker at once, from any thread; the job that it was doing is lost for this reason."""
    tell(_Gone(why))
    os._exit(1)


def _work(begin: Begin[Any, Any], pipe: Connection) -> None:
    """The worker's side. It leaves Ctrl-C to the process that started it, and ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what agents print is no result
    Thread(target=_end_with, args=(multiprocessing.parent_process(),), daemon=True).start()
    tell_by(pipe.send)
    try:
        work = begin()
        pipe.send(Ready())
        while True:
            pipe.send(BatchResult.of(work, pipe.recv()))
    except UserMistake as mistake:
        pipe.send(UserMistake(str(mistake)))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _end_with(parent: BaseProcess | None) -> None:
    """End this process when another one is gone: where that is killed, it would wait for work forever."""
    if parent:
        parent.join()
        os._exit(1)
