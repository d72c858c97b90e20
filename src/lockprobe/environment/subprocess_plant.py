"""A plant in a separate process, for processes in which OpenGL would hang.

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
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.environment.subprocess_host import say
from lockprobe.errors import PlantFault, UserMistake
from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Fact, Snapshot

__all__ = ["PlantElsewhere", "must_live_elsewhere"]

_PROGRAM = "import sys; sys.path[:] = sys.argv[1:]; from lockprobe.environment.subprocess_host import serve; serve()"

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
        self._closed = False
        self._has_camera = resolve_plant(spec).has_camera
        self._facts: Mapping[str, Fact] = self._ask("make", spec, box, labels, rng)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """What it is, its renderer as soon as it was looked at; what was known last if it is there no more."""
        if self._is_there:
            with suppress(PlantFault):
                self._facts = self._ask("facts")
        return self._facts

    def observe(self) -> Snapshot:
        """The truth before the first attempt."""
        return self._seen(self._ask("observe"))

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by place in panel order."""
        return self._seen(self._ask("attempt", joint))

    def close(self) -> None:
        """Let go of it; its process goes on for the next one. A second time does nothing."""
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
                say(self._process.stdin, request)
                kind, answer = pickle.load(self._process.stdout)  # noqa: S301 - from our own process
        except (OSError, ValueError, EOFError, pickle.UnpicklingError) as error:
            self.end()
            raise PlantFault(f"the plant's process ended ({type(error).__name__})") from error
        if kind == "mistake":
            raise UserMistake(answer)
        if kind == "fault":
            raise PlantFault(answer)
        return answer


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
