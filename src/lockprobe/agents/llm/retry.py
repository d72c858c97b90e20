"""Retries of requests to a provider: exponential back-off, limits, and the final error.

The provider's classification in Inspect AI decides which failures are transient: status 429 and 5xx, dropped
connections and so on. Three kinds are added: no reply in time, a reply whose body is cut off or not JSON, and every
status that says that the same request may succeed later (408, 409 and 425 as well as 5xx). Retries
back off exponentially from :attr:`lockprobe.agents.model_access.Access.pause` (twice that for rate limits), capped at
one minute; a provider's own Retry-After takes precedence. With default settings an unreachable provider fails after
about 30 s.

A provider may charge for replies that never arrived. Attempts that were cut off, dropped or unreadable are counted, and
the budget is checked before such a request is made again. If a provider counts the tokens of an error, they are kept.
"""

from __future__ import annotations

import asyncio
import random
import socket
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import asdict, replace
from typing import NamedTuple, Protocol, TypeVar

from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import LockprobeError, ModelFault
from lockprobe.foundation.redaction import without_secrets
from lockprobe.trial.model_call import Usage

LONGEST_PAUSE = 60.0
"""The longest wait in seconds, unless the provider asks for more."""

LONGEST_OBEYED = 600.0
"""The longest wait in seconds at a provider's request; a run does not wait for hours."""

_LONGEST_SAID = 400
"""The most characters kept of a provider's message."""

_UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""Exceptions of libraries for an unreadable body."""

_NOT_SENT = {"ConnectError", "ConnectTimeout", "PoolTimeout", "ClientConnectorError"}
"""Names of exceptions for requests that did not reach the provider."""

_CONNECTION = {"TransportError", "APIConnectionError", "ClientConnectionError", *_NOT_SENT}
"""Names of exceptions, or of their base classes, for failed connections at any time."""

_GAVE_UP_WAITING = (504, 524)
"""Statuses of a gateway without an answer from the server behind it, which may have continued its work."""

_NOTHING = Usage()

_T = TypeVar("_T")

Again = Callable[[int], Awaitable[None]]
"""Called before a request is made again, with how many of its attempts may have been charged for, if that has grown."""


class Tries(NamedTuple):
    """The attempts of one request.

    Attributes:
        retries: How often it was repeated.
        unanswered: Failed attempts that the provider may charge for and whose tokens it did not count.
        lost: The tokens that it counted for failed attempts.
    """

    retries: int = 0
    unanswered: int = 0
    lost: Usage = _NOTHING


class Declined(Exception):
    """A provider's error in place of a reply; it is its own :class:`Judgement`.

    Args:
        words: The provider's words.
        status_code: The status that it names, or None.
        usage: The tokens that it counts for the attempt, or None.
        charged: Whether it may charge for the attempt although it counts nothing.
    """

    def __init__(
        self, words: str, status_code: int | None = None, *, usage: Usage | None = None, charged: bool = False
    ) -> None:
        super().__init__(words)
        self.status_code, self.charged = status_code, charged
        self.usage = None if usage is None else replace(usage, calls=0)

    @property
    def retry(self) -> bool:
        """Whether a retry may succeed."""
        return self.status_code is None or self.status_code == 429 or _passes(self.status_code)

    @property
    def kind(self) -> str:
        """As :attr:`Judgement.kind`."""
        return "rate_limit" if self.status_code == 429 else "transient"

    retry_after = None


def _passes(status: int | None) -> bool:
    """Whether a status says that the same request may succeed later. That of a rate limit can also be a spent quota."""
    return status in (408, 409, 425) or (status is not None and status >= 500)


class RefusedReply(Exception):
    """A refused answer that is not requested again; ``charged``: the provider may charge for it."""

    def __init__(self, what: str, *, charged: bool = False) -> None:
        super().__init__(what)
        self.charged = charged


async def pausing(seconds: float) -> None:
    """Wait before the next attempt."""
    await asyncio.sleep(seconds)


class Judgement(Protocol):
    """The classification of a failure, for example Inspect AI's ``RetryDecision``."""

    @property
    def retry(self) -> bool:
        """Whether the failure may be temporary."""
        ...

    @property
    def kind(self) -> str:
        """``rate_limit`` or ``transient``."""
        ...

    @property
    def retry_after(self) -> float | None:
        """Seconds that the provider asks to wait."""
        ...


async def with_retries(
    attempt: Callable[[], Awaitable[_T]],
    judge: Callable[[Exception], Judgement],
    access: Access,
    again: Again | None = None,
) -> tuple[_T, Tries]:
    """Repeat a request until there is an answer, or until the retries are used up.

    ``attempt`` makes it once, and ``judge`` classifies a failure. ``again`` is called before it is made again where
    that may cost once more; what it raises ends the request.

    Raises:
        ModelFault: If there is no answer; the message has the last error and the number of attempts.
    """
    patience = _Patience(judge, access)
    known = 0
    while True:
        if again is not None and patience.unanswered > known:
            await again(known := patience.unanswered)
        try:
            async with asyncio.timeout(access.timeout):
                answer = await attempt()
        except LockprobeError:  # the run is being ended
            raise
        except Exception as error:  # noqa: BLE001 - libraries raise anything
            await pausing(patience.after(error))
        else:
            return answer, patience.spent(retries=patience.failed)


class _Patience:
    """How long one request is tried: its failed attempts, and what they may have cost."""

    def __init__(self, judge: Callable[[Exception], Judgement], access: Access) -> None:
        self._judge, self._access = judge, access
        self.failed = self.unanswered = self._counted = 0
        self._lost = _NOTHING

    def spent(self, retries: int) -> Tries:
        """The attempts so far, so many of them repeated."""
        return Tries(retries, self.unanswered - self._counted, self._lost)

    def after(self, error: Exception) -> float:
        """Seconds to wait after a failed attempt.

        Raises:
            ModelFault: If the request is not made again.
        """
        self.failed += 1
        if refused := next((link for link in _chain(error) if isinstance(link, RefusedReply)), None):
            self.unanswered += refused.charged
            raise self._fault(refused, "") from error
        judged = self._judge(error)
        if isinstance(error, Declined) and error.usage is not None and error.usage != _NOTHING:
            self.unanswered += 1
            self._counted += 1
            self._lost += error.usage
        else:
            self.unanswered += judged.kind != "rate_limit" and _may_be_charged(error)
        if (asked := judged.retry_after or 0.0) > LONGEST_OBEYED:
            raise self._fault(error, f"; it asks to be left alone for {asked:.0f} s") from error
        passes = judged.retry or _passes(_status(error)) or isinstance(error, (TimeoutError, *_UNREADABLE))
        if not passes or self.failed > self._access.retries:
            tried = f" (tried {self.failed} times)" if self.failed > 1 else ""
            raise self._fault(error, tried) from error
        return self._pause(judged)

    def _pause(self, judged: Judgement) -> float:
        if (asked := judged.retry_after) is not None:
            return asked * random.uniform(1, 1.25)  # noqa: S311 - no secret
        first = self._access.pause * (2 if judged.kind == "rate_limit" else 1)
        pause = min(LONGEST_PAUSE, first * 2.0 ** min(self.failed - 1, 30))
        return pause * random.uniform(0.75, 1.25)  # noqa: S311 - no secret

    def _fault(self, error: Exception, more: str) -> ModelFault:
        return fault(_said(error, self._access) + more, self.spent(retries=self.failed - 1))


def fault(message: str, tries: Tries, usage: Usage = _NOTHING) -> ModelFault:
    """The fault of a request after its attempts; ``usage`` is what the last of them cost."""
    cost = tries.lost + usage
    spent = {} if cost == _NOTHING else asdict(cost)
    return ModelFault(message, retries=tries.retries, unanswered=tries.unanswered, usage=spent)


def _said(error: Exception, access: Access) -> str:
    """The error in place of an answer, on one line. It never quotes the request."""
    if isinstance(error, TimeoutError):
        return f"no reply within {access.timeout:g} s"
    if (status := _status(error)) is not None:
        return f"the provider answered {status}: {_words(error)}"
    if isinstance(error, Declined | RefusedReply):
        return f"the provider answered with {'an error: ' if isinstance(error, Declined) else ''}{_words(error)}"
    chain = list(_chain(error))
    if any(isinstance(link, OSError) or not _CONNECTION.isdisjoint(_kinds(link)) for link in chain):
        return f"no connection to the provider: {_words(chain[-1])}"
    if isinstance(error, _UNREADABLE):
        return f"a reply that cannot be read ({type(error).__name__}: {_words(error)})"
    return f"{type(error).__name__}: {_words(chain[-1])}"


def _status(error: Exception) -> int | None:
    """The status that a provider answered with; libraries keep it under one of two names."""
    for name in ("status_code", "code"):
        if isinstance(status := getattr(error, name, None), int):
            return status
    return None


def _may_be_charged(error: Exception) -> bool:
    """Whether a failed request may have been charged for: it arrived, and its result is unknown."""
    if isinstance(error, Declined):
        return error.charged
    if (status := _status(error)) is not None:
        return status in _GAVE_UP_WAITING
    refused = (ConnectionRefusedError, socket.gaierror)
    return not any(isinstance(link, refused) or not _NOT_SENT.isdisjoint(_kinds(link)) for link in _chain(error))


def _kinds(error: BaseException) -> Iterator[str]:
    return (kind.__name__ for kind in type(error).__mro__)


def _chain(error: BaseException) -> Iterator[BaseException]:
    """An error and those behind it."""
    link: BaseException | None = error
    while link is not None:
        yield link
        link = link.__cause__ or link.__context__


def _words(error: BaseException) -> str:
    """The provider's message on one line, if the error stores it separately; else the error's text."""
    body = getattr(error, "body", None)
    said = body.get("message") if isinstance(body, dict) else None
    words = without_secrets(str(said or getattr(error, "message", None) or error))  # before a key is cut in two
    return " ".join(words.split())[:_LONGEST_SAID]
