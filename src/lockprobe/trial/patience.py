"""The time limit of a decision of an agent that somebody wrote: it may await for ever, or keep its thread for ever.

What awaits is cancelled. In what keeps its thread, another thread raises an error, which ends every loop of Python; of
a call that does not come back, such as one of another language, it says where it hangs. Nothing simpler does all of
this: a signal reaches the main thread alone, and what is left behind in a thread of its own computes on.
"""

from __future__ import annotations

import asyncio
import ctypes
import sys
import sysconfig
import threading
import time
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass, field
from pathlib import PurePath
from traceback import walk_stack, walk_tb
from types import FrameType
from typing import TypeVar

from lockprobe.foundation.errors import ModelFault
from lockprobe.foundation.terminal_text import printable

_T = TypeVar("_T")

_LOOK = 1.0
"""Seconds between looks at what keeps its thread."""


class _Hangs(BaseException):
    """Raised in a thread that decides for too long; a handler of ``Exception`` does not stop it."""


@dataclass(slots=True, eq=False)
class _Deciding:
    agent: str
    limit: float
    thread: int = field(default_factory=threading.get_ident)
    began: float = field(default_factory=time.monotonic)
    looks: int = 0

    def said(self, seconds: float, frames: Iterable[tuple[FrameType, int]]) -> str:
        where = f" in {line}" if (line := own_line(frames)) else ""
        return f"{self.agent} has been deciding for {seconds:.3g} s{where} (its class may set step_seconds)"

    def raising(self, error: type[BaseException] | None) -> None:
        """Raise an error in its thread as soon as that runs Python; None takes back what is not raised yet."""
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self.thread), error and ctypes.py_object(error))


class Patience:
    """Watches the decisions of this process; ``stuck`` is told of one that could not be ended."""

    def __init__(self) -> None:
        self.stuck: Callable[[str], object] = lambda said: sys.stderr.write(
            f"lockprobe: {printable(said)}; nothing finished is lost by Ctrl-C, twice if need be\n"
        )
        self._now, self._lock = set[_Deciding](), threading.Lock()
        self._thread: threading.Thread | None = None  # none before it is needed: it may be a forked process then

    async def limited(self, decision: Awaitable[_T], agent: str, seconds: float) -> _T:
        """Wait for a decision for so many seconds."""
        one = _Deciding(agent, seconds)
        with self._lock:
            self._now.add(one)
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._watch, name="patience", daemon=True)
                self._thread.start()
        try:
            async with asyncio.timeout(seconds) as limit:
                return await decision
        except (TimeoutError, _Hangs) as late:
            if isinstance(late, TimeoutError) and not limit.expired():  # one of its own
                raise
            ended = late.__context__ if isinstance(late, TimeoutError) else late  # where it was cancelled, or raised
            raise ModelFault(one.said(seconds, walk_tb(ended.__traceback__ if ended else None))) from late
        finally:
            with self._lock:
                self._now.discard(one)
            if one.looks:  # what is not raised yet would be raised in the loop
                one.raising(None)

    def _watch(self) -> None:
        while True:
            time.sleep(_LOOK)
            with self._lock:
                for one in self._now:
                    seconds = time.monotonic() - one.began
                    if seconds <= one.limit + (one.looks + 1) * _LOOK:
                        continue
                    one.looks += 1
                    if one.looks == 1:
                        one.raising(_Hangs)
                    elif one.looks == 2 and (frame := sys._current_frames().get(one.thread)):  # noqa: SLF001
                        self.stuck(one.said(seconds, reversed([*walk_stack(frame)])))


def own_line(frames: Iterable[tuple[FrameType, int]]) -> str:
    """The file's name and the last line, of code neither installed nor of Lockprobe; empty without such code."""
    installed = tuple(sysconfig.get_path(kind) for kind in ("stdlib", "platstdlib", "purelib", "platlib"))
    found = ""
    for frame, line in frames:
        module, file = str(frame.f_globals.get("__name__")), frame.f_code.co_filename
        if not (module.startswith(("lockprobe.", "lockprobe_robot.")) or file.startswith(("<frozen", *installed))):
            found = f"{PurePath(file).name}, line {line}"
    return found


PATIENCE = Patience()
"""That of this process."""
