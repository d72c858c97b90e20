"""A plant in a process of its own, for processes in which OpenGL would hang.

OpenGL does not survive a fork: a child of a process that has used it waits for ever for threads that it does not have.
``gymnasium.vector.AsyncVectorEnv`` forks by default. A plant that can be looked at then runs in an interpreter that is
started anew, one for each forked process, and is spoken to through a pipe; it is the same plant, with the same luck.
"""

from __future__ import annotations

import itertools
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from lockprobe.errors import PlantFault, TrialFault, UserMistake
from lockprobe.lockbox.box import Lockbox
from lockprobe.pictures.frame import Frame
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Fact, Snapshot
from lockprobe.seams import Plant

__all__ = ["PlantElsewhere", "must_live_elsewhere", "serve"]

_PROGRAM = "import sys; sys.path[:] = sys.argv[1:]; from lockprobe.environment.elsewhere import serve; serve()"

_forked: list[bool | None] = [False]
"""Whether this process is a fork in which OpenGL would hang; None: a fork that has not been looked at yet."""


def _after_fork() -> None:
    _forked[0] = None
    _Host.running = None  # the parent's, with which a child must not speak


def must_live_elsewhere() -> bool:
    """Whether this process was forked from one in which an OpenGL library was loaded."""
    if _forked[0] is None:
        _forked[0] = _opengl_is_loaded()
    return bool(_forked[0])


def _opengl_is_loaded() -> bool:
    maps = Path("/proc/self/maps")
    loaded = maps.read_text("utf-8", "replace") if maps.exists() else ""
    return any(f"/{name}" in loaded for name in ("libEGL", "libOSMesa", "libGLX", "libGL."))


class PlantElsewhere:
    """A plant that runs in another process.

    Args:
        spec: The plant's spec.
        box: The box.
        labels: Of its joints, in panel order.
        rng: The trial's stream ``plant``.

    Raises:
        UserMistake: If it cannot be had here.
        PlantFault: If it breaks, or its process does.
    """

    def __init__(self, spec: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> None:
        self._host = _Host.here()
        self._number = self._host.number()
        self._has_camera = resolve_plant(spec).has_camera
        self.facts: Mapping[str, Fact] = self._ask("make", spec, box, labels, rng)

    def observe(self) -> Snapshot:
        """The truth before the first attempt."""
        return self._seen(self._ask("observe"))

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by place in panel order."""
        return self._seen(self._ask("attempt", joint))

    def close(self) -> None:
        """Let go of it; its process goes on for the next one."""
        if self._host is _Host.running:
            self._ask("close")

    def _seen(self, snapshot: Snapshot) -> Snapshot:
        return replace(snapshot, look=partial(self._ask, "look")) if self._has_camera else snapshot

    def _ask(self, what: str, *arguments: object) -> Any:
        return self._host.ask((self._number, what, *arguments))


class _Host:
    """The other process. It ends when the pipe to it does, whatever becomes of this one."""

    running: _Host | None = None

    def __init__(self) -> None:
        self._process = subprocess.Popen(  # noqa: S603 - this interpreter, and a program that stands above
            [sys.executable, "-c", _PROGRAM, *sys.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self._numbers = itertools.count()
        self._turn = threading.Lock()

    @classmethod
    def here(cls) -> _Host:
        """The one of this process."""
        if cls.running is None:
            cls.running = cls()
        return cls.running

    def number(self) -> int:
        """A number for another plant."""
        return next(self._numbers)

    def end(self) -> None:
        """Let it end, and wait for it. A second time does nothing."""
        if _Host.running is self:
            _Host.running = None
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(OSError):  # what could not be said any more
                pipe.close()
        self._process.kill()
        self._process.wait()

    def ask(self, request: tuple[object, ...]) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            with self._turn:
                _say(self._process.stdin, request)
                kind, answer = pickle.load(self._process.stdout)  # noqa: S301 - from our own process
        except (OSError, ValueError, EOFError, pickle.UnpicklingError) as error:
            self.end()
            raise PlantFault(f"the plant's process ended ({type(error).__name__})") from error
        if kind == "mistake":
            raise UserMistake(answer)
        if kind == "fault":
            raise PlantFault(answer)
        return answer


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
            _say(answers, answer)


class _Served:
    """Plants by number, and how each was seen last."""

    def __init__(self) -> None:
        self._plants: dict[int, Plant] = {}
        self._last: dict[int, Snapshot] = {}

    def make(
        self, number: int, spec: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator
    ) -> dict[str, Fact]:
        self._plants[number] = resolve_plant(spec).make(box, labels, rng)
        return dict(self._plants[number].facts)

    def observe(self, number: int) -> Snapshot:
        return self._kept(number, self._plants[number].observe())

    def attempt(self, number: int, joint: int) -> Snapshot:
        return self._kept(number, self._plants[number].attempt(joint))

    def look(self, number: int) -> Frame:
        look = self._last[number].look
        assert look is not None
        return look()

    def close(self, number: int) -> None:
        self._last.pop(number, None)
        if (plant := self._plants.pop(number, None)) is not None:
            plant.close()

    def _kept(self, number: int, snapshot: Snapshot) -> Snapshot:
        self._last[number] = snapshot
        return replace(snapshot, look=None)


def _say(pipe: IO[bytes], what: object) -> None:
    pickle.dump(what, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.flush()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
