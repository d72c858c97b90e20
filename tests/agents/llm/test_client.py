"""The line to a provider: who is asked, how often, how many at once, and what is kept of it."""

import asyncio
import gzip
import socket

import pytest
from provider_server import Manner, Script, completion, here

from lockprobe.agents.llm import client as lines
from lockprobe.agents.llm.settings import Access, Model
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import ModelFault
from lockprobe.trial.model_call import Call

MODEL = "openai-api/fake/model"
SCHEMA = {"type": "object", "properties": {"joint": {"type": "string"}}, "required": ["joint"]}


def asked(name=MODEL, times=1, **access):
    """Answers to so many conversations, asked for side by side."""

    async def all_of_them():
        line = lines.ModelClient(Model.parse(name), Access(**({"pause": 0.01} | access)))

        async def one(number):
            async with line.slots:
                said = Message(role="user", text=f"joints: A, B; trial {number}")
                return await line.ask(Call(key="", step=1, turn=1, request="", reply=None), [said], SCHEMA)

        try:
            return await asyncio.gather(*map(one, range(times)), return_exceptions=True)
        finally:
            await line.aclose()

    answers = asyncio.run(all_of_them())
    for answer in answers:
        if isinstance(answer, BaseException) and not isinstance(answer, ModelFault):
            raise answer
    return answers if times > 1 else answers[0]


def reply(request):
    return completion("a reply")


def test_a_request_that_hangs_is_made_again_and_attempts_that_may_have_been_charged_are_counted(served):
    with served(reply, Script("truncated", "500", "stalled", "dropped", "429 with Retry-After")) as server:
        answer = asked(timeout=0.5)
    assert answer.reply == "a reply"
    assert answer.seconds >= 0.5
    # where the machine is busy, other attempts may be late
    assert answer.retries == server.arrived.total() - 1 >= 5
    assert answer.unanswered == answer.retries - 2  # all but those with a status


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_server_that_is_down_is_reported_in_one_line(monkeypatch, host):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    monkeypatch.setenv("FAKE_BASE_URL", f"http://{host}:{port}/v1")
    fault = asked(retries=1)
    assert str(fault).startswith("no connection to the provider: ")
    assert str(fault).endswith(" (tried 2 times)")
    assert "refused" in str(fault) or "Connect call failed" in str(fault)


def test_no_more_requests_are_on_their_way_than_there_are_connections(served):
    with served(reply, Manner(median=0.02)) as server:
        answers = asked(times=12, connections=3)
    assert [answer.reply for answer in answers] == ["a reply"] * 12
    assert server.peak == 3


@pytest.mark.parametrize("status", [301, 308])
def test_a_redirect_is_named_and_nothing_is_sent_there(served, status):
    with here(reply, keep=True) as elsewhere:
        with served(lambda request: (status, {}), Manner(more=(f"location: {elsewhere.url}",))) as server:
            fault = asked(retries=3)
        said = f"it sends the conversation to {elsewhere.url}; to mend it, name that server"
        assert str(fault) == f"the provider answered {status}: {said}"
        assert (elsewhere.requests, server.arrived.total(), fault.unanswered) == ([], 1, 0)


@pytest.mark.parametrize(
    ("content", "more", "said"),
    [
        (b" " * 200_000, (), "an answer of more than 100000 bytes"),
        (gzip.compress(b" " * 200_000), ("content-encoding: gzip",), "an answer of more than 100000 bytes"),
        (b"x", ("content-encoding: br",), "an answer compressed with br, which was not requested"),
    ],
)
def test_an_answer_without_end_or_packed_as_nobody_asked_is_refused(served, monkeypatch, content, more, said):
    monkeypatch.setattr(lines, "LARGEST_ANSWER", 100_000)
    with served(lambda request: (200, content), Manner(more=more)) as server:
        fault = asked(retries=3)
    assert str(fault) == f"the provider answered with {said}"
    assert (server.arrived.total(), fault.unanswered) == (1, 1)
