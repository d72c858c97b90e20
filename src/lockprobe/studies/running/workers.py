"""Worker processes for trials that need a processor: local models and simulated plants.

Each worker builds its agent once and receives one plan at a time. The parent writes a finished trial to disk before it
sends the next plan. If a worker dies, its trial ends as an ``error`` at the boundary ``model`` or ``plant``, whichever
needs the processor, and a new worker replaces it. One in which an agent hangs ends itself, and says where.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import cast

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import Missing, ModelFault, PlantFault, UserMistake
from lockprobe.foundation.interrupts import held_back
from lockprobe.foundation.plugins import allow, allowed
from lockprobe.studies.records.picture_store import Album
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.loop import broken
from lockprobe.trial.patience import PATIENCE
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Step, Trial

OnStep = Callable[[str, Step], None]
Finish = Callable[[Trial, Timing], None]

_MAX_DEATHS = 3
"""The number of deaths without a finished trial in between after which the run ends."""


@dataclass(slots=True, eq=False)
class _Worker:
    process: SpawnProcess
    pipe: Connection
    plan: Plan | None = None
    hangs: str = ""


def play_in_workers(
    plans: list[Plan], workers: int, on_step: OnStep, finish: Finish, *, pictures: Path | None = None
) -> None:
    """Play plans of one agent, in their order, on at least one process.

    ``on_step`` and ``finish`` are called in this process, ``finish`` before the worker begins another trial. Workers
    store the pictures that records name in the directory ``pictures``.

    Raises:
        UserMistake: If the agent is not available, or workers keep dying.
    """
    pool = _Pool(plans, on_step, finish, pictures)
    try:
        pool.start(min(workers, len(plans)))
        pool.serve()
    finally:
        pool.stop()


class _Pool:
    """The parent's side of the worker pool: one pipe per worker."""

    def __init__(self, plans: list[Plan], on_step: OnStep, finish: Finish, pictures: Path | None) -> None:
        self._queue = list(reversed(plans))
        self._agent = plans[0].agent
        self._fault = PlantFault if resolve(self._agent).engine == "inline" else ModelFault
        self._pictures = pictures
        self._on_step = on_step
        self._finish = finish
        self._workers: dict[Connection, _Worker] = {}
        self._deaths = 0

    def start(self, count: int) -> None:
        context = multiprocessing.get_context("spawn")
        for _ in range(count):
            ours, theirs = context.Pipe()
            process = context.Process(target=_work, args=(self._agent, self._pictures, allowed(), theirs), daemon=True)
            with held_back():
                process.start()
            theirs.close()
            self._workers[ours] = _Worker(process, ours)

    def serve(self) -> None:
        """Serve the workers until every plan is played."""
        while self._workers:
            for pipe in wait(list(self._workers)):
                worker = self._workers[cast(Connection, pipe)]
                try:
                    kind, content = worker.pipe.recv()
                except (EOFError, ConnectionResetError):
                    self._replace_dead(worker)
                else:
                    self._receive(worker, kind, content)

    def _receive(self, worker: _Worker, kind: str, content: tuple[object, ...]) -> None:
        if kind == "step":
            self._on_step(*cast(tuple[str, Step], content))
            return
        if kind == "hangs":
            worker.hangs = str(content[0])
            return
        if kind == "mistake":
            raise UserMistake(str(content[0]))
        if kind == "trial":
            self._deaths = 0
            self._finish(*cast(tuple[Trial, Timing], content))
        worker.plan = self._queue.pop() if self._queue else None
        worker.pipe.send(worker.plan)
        if worker.plan is None:
            del self._workers[worker.pipe]
            worker.process.join()

    def _replace_dead(self, worker: _Worker) -> None:
        """Record the trial that a dead worker was playing, and replace it."""
        del self._workers[worker.pipe]
        worker.process.join()
        self._deaths += not worker.hangs
        what = f"the worker process of {self._agent} died (exit status {worker.process.exitcode})"
        if worker.plan is not None:
            trial = broken(worker.plan, ModelFault(worker.hangs) if worker.hangs else self._fault(what))
            self._finish(trial, Timing(key=trial.key, seconds=0.0, steps=0))
        if not worker.hangs and self._deaths >= _MAX_DEATHS:
            often = f"{self._deaths} times with no finished trial in between"
            raise Missing(f"{what}, {often}", "is there memory enough? try --workers 1")
        if self._queue:
            self.start(1)

    def stop(self) -> None:
        for worker in self._workers.values():
            worker.process.terminate()
        for worker in self._workers.values():
            worker.process.join()


def _work(spec: str, pictures: Path | None, code: tuple[str, ...], pipe: Connection) -> None:
    """The worker's side. It leaves Ctrl-C to the parent, and exits when the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what agents print is no result
    allow(*code)

    def end(said: str) -> None:
        pipe.send(("hangs", (said,)))
        os._exit(1)

    PATIENCE.stuck = end
    try:
        agent = resolve(spec).make()
        keep = None if pictures is None else Album(pictures).keep
        pipe.send(("ready", ()))
        while (plan := pipe.recv()) is not None:
            result = asyncio.run(play_timed(plan, agent, lambda key, step: pipe.send(("step", (key, step))), keep))
            pipe.send(("trial", result))
    except UserMistake as mistake:
        pipe.send(("mistake", (str(mistake),)))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return
