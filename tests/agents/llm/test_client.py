"""The line to a provider sends a conversation nowhere else, and takes no answer without bounds."""

import asyncio
import gzip

import pytest
from provider_server import Manner, completion, here

from lockprobe.agents.llm import client as lines
from lockprobe.agents.llm.settings import Access, Model
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import ModelFault
from lockprobe.trial.model_call import Call


def asked():
    """The fault of a call. Calls that hang or are dropped, and how many are on their way, are in ``tests/studies``."""

    async def one():
        line = lines.ModelClient(Model.parse("openai-api/fake/model"), Access(pause=0.01, retries=3))
        try:
            said = [Message(role="user", text="What now?")]
            return await line.ask(Call(key="", step=1, turn=1, request="", reply=None), said, {})
        finally:
            await line.aclose()

    with pytest.raises(ModelFault) as fault:
        asyncio.run(one())
    return fault.value


def reply(request):
    return completion("a reply")


@pytest.mark.parametrize("status", [301, 308])
def test_a_redirect_is_named_and_nothing_is_sent_there(served, status):
    with here(reply, keep=True) as elsewhere:
        with served(lambda request: (status, {}), Manner(more=(f"location: {elsewhere.url}",))) as server:
            fault = asked()
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
        fault = asked()
    assert str(fault) == f"the provider answered with {said}"
    assert (server.arrived.total(), fault.unanswered) == (1, 1)
