"""Connection settings of hosted models: concurrency and retries. They change no request."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_whole

MENDING = "; to mend it, "
"""Stands in the error of a call between what was said and what has to be done before the same request can succeed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """Connection settings of hosted models.

    Attributes:
        connections: Concurrent requests, at least 1.
        timeout: Seconds after which a hanging request is repeated.
        retries: How often an unanswered request is repeated before its trial ends as ``error``.
        pause: Seconds before the first retry, doubled for every further one up to a minute. A waiting time given by the
            provider takes precedence.
        connect: Seconds within which a server has to take a connection.

    Raises:
        BadValue: If a number is out of range.
    """

    connections: int = 10
    timeout: float = 120.0
    retries: int = 6
    pause: float = 0.5
    connect: float = 10.0

    def __post_init__(self) -> None:
        check_whole("connections", self.connections, 1, 10_000)
        if not 0.01 <= self.timeout <= 86_400:
            raise BadValue("timeout", self.timeout, "seconds from 0.01 to a day")
        check_whole("retries", self.retries, 0, 100)
        if not 0 <= self.pause <= 60:
            raise BadValue("pause", self.pause, "seconds from 0 to 60")
