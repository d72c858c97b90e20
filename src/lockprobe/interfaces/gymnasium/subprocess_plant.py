"""A plant in a separate process, for processes in which OpenGL would hang.

OpenGL does not survive a fork: a child of a process that has used it waits forever for threads that it does not have.
``gymnasium.vector.AsyncVectorEnv`` forks by default. A plant with a camera then runs in a new interpreter, one for each
forked process, and answers through a pipe. It is the same plant with the same luck.
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

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import PlantFault, TrialFault, UserMistake, kind_and_words
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.safe_path import interpreter, safe_path
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact, Snapshot

__all__ = ["SubprocessPlant", "needs_subprocess", "serve"]

_PROGRAM = (
    "import sys; sys.path[:] = sys.argv[1:]; from lockprobe.interfaces.gymnasium.subprocess_plant import serve; serve()"
)

_forked: list[bool | None] = [False]
"""Whether this process is a fork in which OpenGL would hang; None: a fork that was not checked yet."""


def _after_fork() -> None:
    _forked[0] = None
    _Host.running = None  # it belongs to the parent


def needs_subprocess() -> bool:
    """Whether this process was forked from one in which an OpenGL library was loaded."""
    if _forked[0] is None:
        _forked[0] = _opengl_is_loaded()
    return bool(_forked[0])


def _opengl_is_loaded() -> bool:
    maps = Path("/proc/self/maps")
    loaded = maps.read_text("utf-8", "replace") if maps.exists() else ""
    return any(f"/{name}" in loaded for name in ("libEGL", "libOSMesa", "libGLX", "libGL."))


class SubprocessPlant:
    """A plant that runs in another process.

    Args:
        spec: The plant's spec.
        box: The box.
        labels: Of its joints, in panel order.
        rng: The trial's stream ``plant``.

    Raises:
        UserMistake: If the plant cannot be made here.
        PlantFault: If the plant or its process breaks.
    """

    def __init__(self, spec: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> None:
        self._host = _Host.here()
        self._number = next(self._host.numbers)
        self._closed = False
        self._has_camera = resolve_plant(spec).has_camera
        self._facts: Mapping[str, Fact] = self._ask("make", spec, box, labels, rng)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Facts of the plant, with the renderer after the first look; the last known facts if it is gone."""
        if self._is_there:
            with suppress(PlantFault):
                self._facts = self._ask("facts")
        return self._facts

    def observe(self) -> Snapshot:
        """The truth before the first attempt."""
        return self._seen(self._ask("observe"))

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order."""
        return self._seen(self._ask("attempt", joint))

    def close(self) -> None:
        """Close the plant; its process stays for the next one. Idempotent."""
        if self._is_there:
            self._closed = True
            self._facts = self._ask("close")

    @property
    def _is_there(self) -> bool:
        return not self._closed and self._host is _Host.running

    def _seen(self, snapshot: Snapshot) -> Snapshot:
        if not self._has_camera:
            return snapshot
        return replace(snapshot, look=partial(self._ask, "look"), render=partial(self._ask, "render"))

    def _ask(self, what: str, *arguments: object) -> Any:
        return self._host.ask((self._number, what, *arguments))


class _Host:
    """The other process. It ends when its pipe closes, even if this process is killed."""

    running: _Host | None = None

    def __init__(self) -> None:
        with safe_path():
            self._process = subprocess.Popen(  # noqa: S603 - this interpreter and the program above
                interpreter("-c", _PROGRAM, *sys.path), stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
        self.numbers = itertools.count()
        self._turn = threading.Lock()

    @classmethod
    def here(cls) -> _Host:
        """The host of this process."""
        if cls.running is None:
            cls.running = cls()
        return cls.running

    def end(self) -> None:
        """End the process and wait for it. Idempotent."""
        if _Host.running is self:
            _Host.running = None
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(OSError):  # a message that was not written
                pipe.close()
        self._process.kill()
        self._process.wait()

    def ask(self, request: tuple[object, ...]) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            with self._turn:
                _send(self._process.stdin, request)
                kind, answer = pickle.load(self._process.stdout)  # noqa: S301 - from our own process
        except (OSError, ValueError, EOFError, pickle.UnpicklingError) as error:
            self.end()
            raise PlantFault(f"the plant's process ended ({type(error).__name__})") from error
        if kind == "mistake":
            raise UserMistake(answer)
        if kind == "fault":
            raise PlantFault(answer)
        return answer


def _send(pipe: IO[bytes], what: object) -> None:
    """Write one message for ``pickle.load``."""
    pickle.dump(what, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.flush()


def serve() -> None:
    """Run plants for another process until it closes the pipe: requests on standard input, answers on output.

    All plants live in one thread, because OpenGL needs it. An error in that thread is an answer, too.
    """
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print goes to standard error
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
                said = str(error) if isinstance(error, TrialFault) else kind_and_words(error)
                answer = ("fault", said)
            _send(answers, answer)


class _Served:
    """Plants by number, and the last snapshot of each."""

    def __init__(self) -> None:
        self._plants: dict[int, Plant] = {}
        self._last: dict[int, Snapshot] = {}

    def make(
        self, number: int, spec: str, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator
    ) -> dict[str, Fact]:
        allow(spec)  # whose process has checked it
        self._plants[number] = resolve_plant(spec).make(box, labels, rng)
        return self.facts(number)

    def facts(self, number: int) -> dict[str, Fact]:
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

    def close(self, number: int) -> dict[str, Fact]:
        facts = self.facts(number)
        self._last.pop(number, None)
        self._plants.pop(number).close()
        return facts

    def _kept(self, number: int, snapshot: Snapshot) -> Snapshot:
        self._last[number] = snapshot
        return replace(snapshot, look=None, render=None)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
