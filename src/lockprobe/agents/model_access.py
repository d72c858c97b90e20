"""How hosted models are reached: connections, retries, batches. It changes no request."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.errors import BadValue

__all__ = ["Access"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """How hosted models are reached.

    Attributes:
        connections: Requests on their way at the same time, at least 1.
        timeout: Seconds after which a request that hangs is made again.
        retries: How often a request that the provider did not answer is made again before its trial ends as ``error``.
        pause: Seconds before it is made again for the first time; every further time twice as long, at most a minute.
            Where the provider says how long to wait, that holds.
        batch: Whether requests go through the provider's batch interface: cheaper, and hours instead of seconds.
        tick: Seconds between looks at how far batches are, and for which requests are gathered.

    Raises:
        BadValue: If a number is out of range.
    """

    connections: int = 10
    timeout: float = 120.0
    retries: int = 6
    pause: float = 0.5
    batch: bool = False
    tick: float = 15.0

    def __post_init__(self) -> None:
        if not 1 <= self.connections <= 10_000:
            raise BadValue("connections", self.connections, "a whole number from 1 to 10000")
        if not 0.01 <= self.timeout <= 86_400:
            raise BadValue("timeout", self.timeout, "seconds from 0.01 to a day")
        if not 0 <= self.retries <= 100:
            raise BadValue("retries", self.retries, "a whole number from 0 to 100")
        if not 0 <= self.pause <= 60:
            raise BadValue("pause", self.pause, "seconds from 0 to 60")
        if not 0 < self.tick <= 3600:
            raise BadValue("tick", self.tick, "seconds above 0, at most an hour")
