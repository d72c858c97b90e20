"""The time limit of a decision of an agent that somebody wrote: it may await for ever, or keep its thread for ever.

What awaits is cancelled. In what keeps its thread, an error is raised from another thread. That ends every loop of
Python; of a call that does not come back, as of another language, it is only said where it hangs.
"""

from __future__ import annotations

import asyncio
import ctypes
import sys
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from traceback import walk_stack, walk_tb
from typing import TypeVar

from lockprobe.foundation.errors import ModelFault
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.boundary import own_line

_T = TypeVar("_T")

_LOOK = 1.0
"""Seconds between looks at what keeps its thread; by so many it may exceed its limit."""


class _Hangs(BaseException):
    """Raised in a thread that decides for too long; a handler of ``Exception`` does not stop it."""


@dataclass(slots=True, eq=False)
class _Deciding:
    agent: str
    limit: float
    thread: int = field(default_factory=threading.get_ident)
    began: float = field(default_factory=time.monotonic)
    looks: int = 0


class Patience:
    """Watches the decisions that are being made in this process, from a thread that the first of them starts.

    Attributes:
        stuck: Told of a decision that could not be ended either.
    """

    def __init__(self) -> None:
        self.stuck: Callable[[str], object] = lambda said: sys.stderr.write(
            f"lockprobe: {printable(said)}; nothing finished is lost by Ctrl-C, twice if need be\n"
        )
        self._now: set[_Deciding] = set()
        self._lock = threading.Lock()
        self._watching = False

    async def limited(self, decision: Awaitable[_T], agent: str, seconds: float) -> _T:
        """Wait for a decision for so many seconds at most.

        Raises:
            ModelFault: If there is none by then; it names the agent, and the file and the line where it hangs.
        """
        try:
            with self._watched(_Deciding(agent, seconds)):
                async with asyncio.timeout(seconds) as limit:
                    return await decision
        except (TimeoutError, _Hangs) as late:
            if isinstance(late, TimeoutError) and not limit.expired():  # one of its own
                raise
            ended = late.__context__ if isinstance(late, TimeoutError) else late  # where it was cancelled, or raised
            line = own_line(walk_tb(ended.__traceback__ if ended else None))
            raise ModelFault(_said(agent, seconds, line)) from late

    @contextmanager
    def _watched(self, one: _Deciding) -> Iterator[None]:
        with self._lock:
            self._now.add(one)
            if not self._watching:
                self._watching = True
                threading.Thread(target=self._watch, name="patience", daemon=True).start()
        try:
            yield
        finally:
            with self._lock:
                self._now.discard(one)
            if one.looks:  # what is not raised yet would be raised in the loop
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(one.thread), None)

    def _watch(self) -> None:
        while True:
            time.sleep(_LOOK)
            with self._lock:
                for one in self._now:
                    seconds = time.monotonic() - one.began
                    if seconds < one.limit + (one.looks + 1) * _LOOK:
                        continue
                    one.looks += 1
                    if one.looks == 1:
                        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(one.thread), ctypes.py_object(_Hangs))
                    elif one.looks == 2 and (frame := sys._current_frames().get(one.thread)):  # noqa: SLF001
                        self.stuck(_said(one.agent, seconds, own_line(reversed([*walk_stack(frame)]))))


def _said(agent: str, seconds: float, line: str) -> str:
    return f"{agent} has been deciding for {seconds:.3g} s{f' in {line}' * bool(line)} (its class may set step_seconds)"


PATIENCE = Patience()
"""That of this process."""
