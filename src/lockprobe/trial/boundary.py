"""Attributes what breaks in a trial to the part of the loop that broke: agent, interventions or plant."""

from __future__ import annotations

import asyncio

from lockprobe.foundation.errors import ChannelFault, LockprobeError, ModelFault, PlantFault, TrialFault

__all__ = ["AGENT", "INTERVENTIONS", "PLANT", "Boundary"]

_PASSING = (LockprobeError, KeyboardInterrupt, GeneratorExit, asyncio.CancelledError)
"""What passes every boundary. An agent's sys.exit() does not: it ends its trial, not the study."""


class Boundary:
    """Turns any error inside into one kind of fault. Lockprobe's own errors pass unchanged.

    >>> with AGENT:
    ...     raise SystemExit(3)
    Traceback (most recent call last):
    lockprobe.foundation.errors.ModelFault: SystemExit: 3

    Args:
        fault: The kind of fault.
    """

    __slots__ = ("_fault",)

    def __init__(self, fault: type[TrialFault]) -> None:
        self._fault = fault

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is not None and not isinstance(error, _PASSING):
            raise self._fault(f"{type(error).__name__}: {error}") from error


AGENT, INTERVENTIONS, PLANT = Boundary(ModelFault), Boundary(ChannelFault), Boundary(PlantFault)
