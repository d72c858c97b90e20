"""How often a provider is asked again, how long is waited before, and what is said when it is enough.

Which failures pass is for the provider's classification in Inspect AI to say: status 429 and 5xx, connections that
drop and so on. Two kinds are added: no reply in time, and a reply whose body breaks off or is no JSON. Waits double
from :attr:`lockprobe.agents.access.Access.pause`, for rate limits from twice that, up to a minute; what a provider asks
for goes first. As settings come, one that is down is given up on after about half a minute.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from typing import Protocol, TypeVar

from tenacity import AsyncRetrying, RetryCallState, stop_after_attempt, wait_random

from lockprobe.agents.access import Access
from lockprobe.errors import ModelFault, without_secrets

__all__ = ["LONGEST_BATCH", "LONGEST_OBEYED", "LONGEST_PAUSE", "Judgement", "patiently", "pausing"]

LONGEST_PAUSE = 60.0
"""Seconds waited at most where the provider asks for no more."""

LONGEST_BATCH = 26 * 3600.0
"""Seconds after which a batch is given up; providers promise them within a day."""

LONGEST_OBEYED = 600.0
"""Seconds waited at most where it does: a run has no place for one that asks for hours."""

_LONGEST_SAID = 400
"""Characters kept of what a provider says."""

_UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""What libraries raise over a body that is not what it should be."""

_T = TypeVar("_T")


async def pausing(seconds: float) -> None:
    """Wait before the next attempt."""
    await asyncio.sleep(seconds)


class Judgement(Protocol):
    """What is made of a failure. Inspect AI's ``RetryDecision`` is one."""

    @property
    def retry(self) -> bool:
        """Whether it may pass."""
        ...

    @property
    def kind(self) -> str:
        """``rate_limit`` or ``transient``."""
        ...

    @property
    def retry_after(self) -> float | None:
        """Seconds that the provider asks to wait."""
        ...


async def patiently(
    attempt: Callable[[], Awaitable[_T]], judge: Callable[[Exception], Judgement], access: Access
) -> tuple[_T, int]:
    """Make a request until there is an answer, or it is enough.

    Args:
        attempt: Makes it once.
        judge: What its provider makes of a failure.
        access: How long an attempt may take, how often it is made again, and after which pause.

    Returns:
        The answer, and how often the request was made again.

    Raises:
        ModelFault: If there is none; says what came last and how often it was tried.
    """
    patience = _Patience(judge, access)

    async def timed() -> _T:
        async with asyncio.timeout(LONGEST_BATCH if access.batch else access.timeout):
            return await attempt()

    retrying = AsyncRetrying(
        retry=patience.again,
        wait=patience.wait,
        stop=stop_after_attempt(access.retries + 1),
        retry_error_callback=patience.give_up,
        sleep=pausing,
    )
    answer: _T = await retrying(timed)
    return answer, patience.tries - 1


class _Patience:
    """What tenacity asks about one request."""

    def __init__(self, judge: Callable[[Exception], Judgement], access: Access) -> None:
        self._judge, self._access = judge, access
        self._judgement: Judgement | None = None
        self.tries = 0

    def again(self, state: RetryCallState) -> bool:
        self.tries = state.attempt_number
        error = state.outcome.exception() if state.outcome is not None else None
        if not isinstance(error, Exception):  # an answer, or the run is being ended
            return False
        self._judgement = judged = self._judge(error)
        if (asked := judged.retry_after or 0.0) > LONGEST_OBEYED:
            raise ModelFault(f"{_said(error, self._access)}; it asks to be left alone for {asked:.0f} s") from error
        if not judged.retry and not isinstance(error, (TimeoutError, *_UNREADABLE)):
            raise ModelFault(_said(error, self._access) + self._tried) from error
        return True

    def wait(self, state: RetryCallState) -> float:
        assert self._judgement is not None
        if (asked := self._judgement.retry_after) is not None:
            return asked + wait_random(0, asked / 4)(state)
        first = self._access.pause * (2 if self._judgement.kind == "rate_limit" else 1)
        pause = min(LONGEST_PAUSE, first * 2.0 ** min(state.attempt_number - 1, 30))
        return pause * wait_random(0.75, 1.25)(state)

    def give_up(self, state: RetryCallState) -> None:
        error = state.outcome.exception() if state.outcome is not None else None
        assert isinstance(error, Exception)
        raise ModelFault(_said(error, self._access) + self._tried) from error

    @property
    def _tried(self) -> str:
        return f" (tried {self.tries} times)" if self.tries > 1 else ""


def _said(error: Exception, access: Access) -> str:
    """What came instead of an answer, in one line. Requests stand in no provider's errors, and in none of this."""
    if isinstance(error, TimeoutError):
        return f"no reply within {LONGEST_BATCH if access.batch else access.timeout:g} s"
    if (status := getattr(error, "status_code", None)) is not None:
        return f"the provider answered {status}: {_words(error)}"
    chain = list(_chain(error))
    if any(isinstance(link, OSError) or type(link).__name__ == "ConnectError" for link in chain):
        return f"no connection to the provider: {_words(chain[-1])}"
    if isinstance(error, _UNREADABLE):
        return f"a reply that cannot be read ({type(error).__name__}: {_words(error)})"
    return f"{type(error).__name__}: {_words(chain[-1])}"


def _chain(error: BaseException) -> Iterator[BaseException]:
    """An error and those behind it."""
    link: BaseException | None = error
    while link is not None:
        yield link
        link = link.__cause__ or link.__context__


def _words(error: BaseException) -> str:
    """What a provider says, on one line, if its error keeps that apart; else what the error says."""
    body = getattr(error, "body", None)
    said = body.get("message") if isinstance(body, dict) else None
    words = without_secrets(str(said or getattr(error, "message", None) or error))  # before a key is cut in two
    return " ".join(words.split())[:_LONGEST_SAID]
