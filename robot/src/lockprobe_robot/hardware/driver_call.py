"""Calls into a device's driver with a time-out, which turn every error into a :class:`PlantFault`."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from lockprobe.foundation.errors import LockprobeError, PlantFault, kind_and_words

_T = TypeVar("_T")


def call_driver(what: str, work: Callable[[], _T]) -> _T:
    """Call a driver in this thread; ``what`` names the device in messages.

    Raises:
        PlantFault: If it raises anything; Lockprobe's own errors pass unchanged.
    """
    try:
        return work()
    except LockprobeError:
        raise
    except Exception as error:
        raise PlantFault(f"{what}: {kind_and_words(error)}") from error


class DriverThread:
    """A daemon thread that calls one driver, so that a hanging call can be abandoned.

    It never keeps the process alive. After a time-out, every further call is refused.
    """

    def __init__(self) -> None:
        self._work: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._hangs = ""
        self._thread: threading.Thread | None = None

    def call(self, what: str, work: Callable[[], _T], seconds: float) -> _T:
        """Call a driver with a time-out.

        Raises:
            PlantFault: If the call takes longer, raises, or an earlier call still hangs.
        """
        if self._hangs:
            raise PlantFault(f"{what}: an earlier call hangs ({self._hangs})")
        if self._thread is None:
            self._thread = threading.Thread(target=self._serve, daemon=True, name="driver")
            self._thread.start()
        answer: Future[_T] = Future()

        def run() -> None:
            try:
                answer.set_result(call_driver(what, work))
            except LockprobeError as error:
                answer.set_exception(error)

        self._work.put(run)
        try:
            return answer.result(seconds)
        except TimeoutError:
            self._hangs = what
            raise PlantFault(f"{what}: no answer within {seconds:g} s") from None

    def _serve(self) -> None:
        while True:
            self._work.get()()
