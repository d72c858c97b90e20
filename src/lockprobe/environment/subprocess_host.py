"""The process in which plants of :mod:`lockprobe.environment.subprocess_plant` live."""

from __future__ import annotations

import os
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import IO

import numpy as np

from lockprobe.errors import TrialFault, UserMistake
from lockprobe.lockbox.box import Configuration, Lockbox
from lockprobe.pictures.frame import Frame
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.protocols import Plant
from lockprobe.record import Fact, Snapshot

__all__ = ["say", "serve"]

_Facts = dict[str, Fact]


def say(pipe: IO[bytes], what: object) -> None:
    """Write one message. It is read by ``pickle.load``."""
    pickle.dump(what, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.flush()


def serve() -> None:
    """Run plants for another process, until it closes the pipe: requests on standard input, answers on output.

    All plants live in one thread, as OpenGL wants it; what breaks in that thread is an answer too.
    """
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever libraries print goes where people read it
    served = _Served()
    with ThreadPoolExecutor(1) as plants:
        while True:
            try:
                number, what, *arguments = pickle.load(sys.stdin.buffer)  # noqa: S301 - from our own process
            except EOFError:
                return
            done = plants.submit(getattr(served, what), number, *arguments)
            error = done.exception()
            if error is None:
                answer = ("answer", done.result())
            elif isinstance(error, UserMistake):
                answer = ("mistake", str(error))
            else:
                said = str(error) if isinstance(error, TrialFault) else f"{type(error).__name__}: {error}"
                answer = ("fault", said)
            say(answers, answer)


class _Served:
    """Plants by number, and how each was seen last."""

    def __init__(self) -> None:
        self._plants: dict[int, Plant] = {}
        self._last: dict[int, Snapshot] = {}

    def make(self, number: int, spec: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> _Facts:
        self._plants[number] = resolve_plant(spec).make(box, labels, rng)
        return self.facts(number)

    def facts(self, number: int) -> _Facts:
        return dict(self._plants[number].facts)

    def observe(self, number: int) -> Snapshot:
        return self._kept(number, self._plants[number].observe())

    def attempt(self, number: int, joint: int) -> Snapshot:
        return self._kept(number, self._plants[number].attempt(joint))

    def look(self, number: int) -> Frame:
        look = self._last[number].look
        assert look is not None
        return look()

    def render(self, number: int, configuration: Configuration) -> Frame:
        render = self._last[number].render
        assert render is not None
        return render(configuration)

    def close(self, number: int) -> _Facts:
        facts = self.facts(number)
        self._last.pop(number, None)
        self._plants.pop(number).close()
        return facts

    def _kept(self, number: int, snapshot: Snapshot) -> Snapshot:
        self._last[number] = snapshot
        return replace(snapshot, look=None, render=None)
