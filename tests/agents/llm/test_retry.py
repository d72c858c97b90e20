"""How often a provider is asked again: what passes, what is waited, what is said in the end."""

import asyncio
import socket
from dataclasses import dataclass

import pytest

from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BudgetReached, ModelFault

patience = pytest.importorskip("lockprobe.agents.llm.retry")


@dataclass
class Judged:
    retry: bool = True
    kind: str = "transient"
    retry_after: float | None = None


class Refusal(Exception):
    def __init__(self, status_code, message):
        super().__init__(f"{status_code} {message}")
        self.status_code, self.message = status_code, message


def asked(monkeypatch, course, *, judged=None, **access):
    """What came of a request that fares so, and the pauses between; a course ends in an answer or repeats its end."""
    pauses, made = [], []

    async def pausing(seconds):
        pauses.append(seconds)

    async def attempt():
        made.append(None)
        fate = course[min(len(made), len(course)) - 1]
        if fate is asyncio:
            await asyncio.Event().wait()
        if isinstance(fate, BaseException):
            raise fate
        return fate

    monkeypatch.setattr(patience, "pausing", pausing)
    try:
        came = asyncio.run(patience.with_retries(attempt, lambda error: judged or Judged(), Access(**access)))
    except ModelFault as fault:
        came = str(fault)
    return came, pauses, len(made)


def test_what_passes_is_asked_again_and_counted(monkeypatch):
    came, pauses, made = asked(monkeypatch, [Refusal(500, "no"), Refusal(429, "no"), "yes"])
    assert came == ("yes", patience.Tries(2, 0))
    assert (len(pauses), made) == (2, 3)


def test_waits_double_up_to_a_minute(monkeypatch):
    _, pauses, _ = asked(monkeypatch, [Refusal(500, "no")], retries=12, pause=0.5)
    for number, pause in enumerate(pauses):
        middle = min(patience.LONGEST_PAUSE, 0.5 * 2**number)
        assert 0.75 * middle <= pause <= 1.25 * middle
    assert len(pauses) == 12
    assert pauses[-1] >= 0.75 * patience.LONGEST_PAUSE


def test_a_rate_limit_is_given_twice_the_time(monkeypatch):
    _, (pause,), _ = asked(monkeypatch, [Refusal(429, "no"), "yes"], judged=Judged(kind="rate_limit"), pause=0.5)
    assert 0.75 <= pause <= 1.25


def test_a_provider_that_says_how_long_to_wait_is_obeyed(monkeypatch):
    _, (pause,), _ = asked(monkeypatch, [Refusal(429, "no"), "yes"], judged=Judged(retry_after=200.0))
    assert 200 <= pause <= 250


def test_a_provider_that_asks_for_hours_is_not_waited_for(monkeypatch):
    said, pauses, made = asked(monkeypatch, [Refusal(429, "daily limit")], judged=Judged(retry_after=7200.0))
    assert said == "the provider answered 429: daily limit; it asks to be left alone for 7200 s"
    assert (pauses, made) == ([], 1)


def test_what_does_not_pass_is_not_asked_again(monkeypatch):
    said, _, made = asked(monkeypatch, [Refusal(401, "wrong\n key"), "yes"], judged=Judged(retry=False))
    assert (said, made) == ("the provider answered 401: wrong key", 1)


@pytest.mark.parametrize("retries", [0, 2])
def test_it_is_bounded(monkeypatch, retries):
    said, _, made = asked(monkeypatch, [Refusal(500, "no")], retries=retries)
    assert made == retries + 1
    assert said == "the provider answered 500: no" + (" (tried 3 times)" if retries else "")


def test_a_request_that_hangs_is_asked_again(monkeypatch):
    came, _, made = asked(monkeypatch, [asyncio, "yes"], judged=Judged(retry=False), timeout=0.02)
    assert (came, made) == (("yes", patience.Tries(1, 1)), 2)
    said, _, made = asked(monkeypatch, [asyncio], judged=Judged(retry=False), timeout=0.02, retries=1)
    assert (said, made) == ("no reply within 0.02 s (tried 2 times)", 2)


def test_a_body_that_cannot_be_read_is_asked_again(monkeypatch):
    torn = ValueError("Expecting value: line 1 column 1")
    came, _, _ = asked(monkeypatch, [torn, "yes"], judged=Judged(retry=False))
    assert came == ("yes", patience.Tries(1, 1))
    said, _, _ = asked(monkeypatch, [torn], judged=Judged(retry=False), retries=0)
    assert said == "a reply that cannot be read (ValueError: Expecting value: line 1 column 1)"


def test_what_lies_behind_a_lost_connection_is_said(monkeypatch):
    lost = RuntimeError("Connection error.")
    lost.__cause__ = ConnectionRefusedError(111, "Connection refused")
    said, _, _ = asked(monkeypatch, [lost], retries=0)
    assert said == "no connection to the provider: [Errno 111] Connection refused"


def test_a_run_that_is_being_ended_is_not_held_up(monkeypatch):
    with pytest.raises(asyncio.CancelledError):
        asked(monkeypatch, [asyncio.CancelledError()])


class ConnectError(Exception):
    """Of a library that did not reach anybody."""


class TransportError(Exception):
    """Of a library whose connection failed at some time."""


class RemoteProtocolError(TransportError):
    """The same, derived."""


def behind(error, cause):
    error.__cause__ = cause
    return error


DROPPED = behind(RuntimeError("Connection error."), RemoteProtocolError("Server disconnected without a response."))


@pytest.mark.parametrize(
    ("failure", "charged"),
    [
        (asyncio, 1),
        (ValueError("Expecting value"), 1),
        (DROPPED, 1),
        (ConnectionResetError(104, "Connection reset by peer"), 1),
        (Refusal(504, "gateway timeout"), 1),
        (Refusal(500, "no"), 0),
        (Refusal(429, "no"), 0),
        (ConnectionRefusedError(111, "Connection refused"), 0),
        (behind(RuntimeError("Connection error."), socket.gaierror(-2, "Name or service not known")), 0),
        (behind(RuntimeError("Connection error."), ConnectError("All connection attempts failed")), 0),
        (patience.Declined("no credit left"), 0),
        (patience.Declined("an empty reply", charged=True), 1),
    ],
)
def test_attempts_that_may_have_been_charged_are_counted_whether_an_answer_comes_or_not(monkeypatch, failure, charged):
    came, _, _ = asked(monkeypatch, [failure, failure, "yes"], timeout=0.02)
    assert came == ("yes", patience.Tries(2, 2 * charged))

    async def attempt():
        if failure is asyncio:
            await asyncio.Event().wait()
        raise failure

    with pytest.raises(ModelFault) as fault:
        asyncio.run(patience.with_retries(attempt, lambda error: Judged(), Access(retries=2, timeout=0.02, pause=0)))
    assert (fault.value.retries, fault.value.unanswered) == (2, 3 * charged)


def test_a_connection_that_drops_is_said_as_one(monkeypatch):
    said, _, _ = asked(monkeypatch, [DROPPED], retries=0)
    assert said == "no connection to the provider: Server disconnected without a response."


def test_an_error_in_place_of_a_reply_is_said_in_the_providers_words(monkeypatch):
    said, _, _ = asked(monkeypatch, [patience.Declined("still\n loading")], retries=0)
    assert said == "the provider answered with an error: still loading"
    said, _, _ = asked(monkeypatch, [patience.Declined("no credit left", 402)], retries=0)
    assert said == "the provider answered 402: no credit left"
    statuses = (None, 400, 401, 402, 404, 408, 409, 422, 425, 429, 500, 503, 529)
    passing = [code for code in statuses if patience.Declined("x", code).retry]
    assert passing == [None, 408, 409, 425, 429, 500, 503, 529]


def test_whoever_keeps_the_money_is_asked_before_it_may_cost_once_more_and_can_end_it():
    told, fates = [], [Refusal(500, "no"), ValueError("torn"), Refusal(500, "no"), TimeoutError(), "yes"]

    async def attempt():
        fate = fates[len(made)]
        made.append(fate)
        if isinstance(fate, Exception):
            raise fate
        return fate

    async def again(unanswered):
        told.append((len(made), unanswered))

    async def no_more(unanswered):
        raise BudgetReached(1.0, 1.0, 0.5)

    def with_retries(hook):
        return asyncio.run(patience.with_retries(attempt, lambda error: Judged(), Access(pause=0), hook))

    made = []
    assert with_retries(again) == ("yes", patience.Tries(4, 2))
    assert told == [(2, 1), (4, 2)]
    made = []
    with pytest.raises(BudgetReached):
        with_retries(no_more)
    assert len(made) == 2
