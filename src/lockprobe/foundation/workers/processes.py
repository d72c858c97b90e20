"""Workers that are processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from threading import Thread
from typing import Any, ClassVar

from lockprobe.foundation.child_processes import held_back
from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.workers.pool import Begin, Lost, Pool

_ENDS = 5.0
"""Seconds that a process has to end by itself, and then by a signal."""


@dataclass(frozen=True, slots=True, eq=False)
class _Worker:
    process: SpawnProcess
    pipe: Connection


class Processes(Pool):
    """Processes of this machine, at most ``count``. Each begins anew, and ends with this one."""

    losses: ClassVar[int] = 1

    def __init__(self, count: int = 1) -> None:
        self.count = count
        self.remedy = f"is there memory enough for {count}? try --workers 1"

    def processors(self) -> int:
        """Their number."""
        return self.count

    def hire(self, begin: Begin[Any, Any]) -> _Worker:
        """Start a process. It imports nothing from the working directory."""
        context = multiprocessing.get_context("spawn")
        with held_back():
            ours, theirs = context.Pipe()
            process = context.Process(target=_work, args=(begin, theirs), daemon=True)
            process.start()
        theirs.close()
        return _Worker(process, ours)

    def send(self, worker: _Worker, job: Any) -> None:
        """Send a job through the pipe of a process."""
        with suppress(BrokenPipeError, ConnectionResetError):  # it died while it was idle; what it left says so
            worker.pipe.send(job)

    def answers(self, workers: Sequence[_Worker], seconds: float) -> Iterator[tuple[_Worker, Any]]:
        """What processes answered, or how they ended."""
        wait([one for worker in workers for one in (worker.pipe, worker.process.sentinel)], timeout=seconds)
        for worker in workers:
            ended, answer = not worker.process.is_alive(), None  # looked at first: what it said is in the pipe by then
            with suppress(EOFError, OSError):  # it was killed, perhaps within a message
                ended |= worker.pipe.poll()
                answer = worker.pipe.recv() if worker.pipe.poll() else None
            if isinstance(answer, UserMistake):
                raise answer
            if ended and answer is None:
                worker.process.join()
                answer = Lost(f"a worker process died, exit status {worker.process.exitcode}")
            if answer is not None:
                yield worker, answer

    def dismiss(self, worker: _Worker, *, idle: bool) -> None:
        """End a process: an idle one ends itself, with what its agent does at the end; another one is ended."""
        worker.pipe.close()
        if not idle:
            worker.process.terminate()
        for end in (worker.process.terminate, worker.process.kill):
            worker.process.join(_ENDS)
            if worker.process.is_alive():
                end()
        worker.process.join()


class _Here:
    """This process, if it is a worker."""

    pipe: Connection | None = None


def lose(why: str) -> None:
    """End this worker at once, from any thread; the job that it was doing is lost for this reason."""
    if _Here.pipe is not None:
        _Here.pipe.send(Lost(why, explained=True))
    os._exit(1)


def _work(begin: Begin[Any, Any], pipe: Connection) -> None:
    """The worker's side. It leaves Ctrl-C to the process that started it, and ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what agents print is no result
    Thread(target=_end_with_parent, daemon=True).start()
    _Here.pipe = pipe
    try:
        work = begin()
        pipe.send("ready")
        while True:
            try:
                job = pipe.recv()
            except (EOFError, OSError):  # the end of the work
                return
            pipe.send(work(job))
    except UserMistake as mistake:
        pipe.send(UserMistake(str(mistake)))
    except BaseException:  # noqa: BLE001 - whatever it is and whatever still runs, this worker is lost
        if (parent := multiprocessing.parent_process()) and parent.is_alive():  # else nobody is there to answer to
            traceback.print_exc()
        os._exit(1)


def _end_with_parent() -> None:
    """End this process when the one that started it is gone: killed, that would leave it waiting for work forever."""
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)
