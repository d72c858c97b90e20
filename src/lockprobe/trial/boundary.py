"""Attributes what breaks in a trial to the part of the loop that broke: agent, interventions or plant."""

from __future__ import annotations

import asyncio
import sysconfig
from collections.abc import Iterable
from pathlib import PurePath
from traceback import walk_tb
from types import FrameType, TracebackType

from lockprobe.foundation.errors import ChannelFault, LockprobeError, ModelFault, PlantFault, TrialFault, kind_and_words

_PASSING = (LockprobeError, KeyboardInterrupt, GeneratorExit)
"""What passes every boundary. An agent's sys.exit() does not: it ends its trial, not the study."""


class Boundary:
    """Turns any error inside into one kind of fault. Lockprobe's own errors pass unchanged.

    >>> with AGENT:
    ...     raise SystemExit(3)
    Traceback (most recent call last):
    lockprobe.foundation.errors.ModelFault: SystemExit: 3

    Args:
        fault: The kind of fault.
        part: What the message calls code that somebody wrote for this part; its file and line are named then.
    """

    __slots__ = ("_fault", "_part")

    def __init__(self, fault: type[TrialFault], part: str = "") -> None:
        self._fault, self._part = fault, part

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None and not (isinstance(error, _PASSING) or _is_end_of_task(error)):
            line = own_line(walk_tb(trace)) if self._part else ""
            where = f"in {self._part} ({line}): " if line else ""
            raise self._fault(f"{where}{kind_and_words(error)}") from error


def _is_end_of_task(error: BaseException) -> bool:
    """Whether the task that plays is cancelled. What only says so, as after a timeout inside an agent, is an error."""
    if not isinstance(error, asyncio.CancelledError):
        return False
    try:
        task = asyncio.current_task()
    except RuntimeError:  # nothing here can be cancelled
        return False
    return task is not None and task.cancelling() > 0


def own_line(frames: Iterable[tuple[FrameType, int]]) -> str:
    """The file's name and the last line, of code neither installed nor of Lockprobe; empty without such code."""
    installed = tuple(sysconfig.get_path(kind) for kind in ("stdlib", "platstdlib", "purelib", "platlib"))
    found = ""
    for frame, line in frames:
        module, file = str(frame.f_globals.get("__name__")), frame.f_code.co_filename
        if not (module.startswith("lockprobe") or file.startswith(("<frozen", *installed))):
            found = f"{PurePath(file).name}, line {line}"
    return found


AGENT = Boundary(ModelFault, "the agent")
INTERVENTIONS, PLANT = Boundary(ChannelFault), Boundary(PlantFault)
