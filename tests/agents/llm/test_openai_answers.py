"""Every shape of an answer is a reply, a refusal or a fault of the provider, whichever provider's class reads it."""

import asyncio
import os

import pytest
from provider_server import Manner, here

from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import REFUSED, Message
from lockprobe.foundation.errors import ModelFault

lines = pytest.importorskip("lockprobe.agents.llm.client")
answers = pytest.importorskip("lockprobe.agents.llm.openai_answers")

PROVIDERS = ("openai-api/fake/model", "openai/gpt-4o", "openrouter/a/b")


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)


def asked(monkeypatch, answer, model=PROVIDERS[0], **access):
    """What came of one request, and how often it was made."""
    with here(lambda request: answer, Manner(keeps=False)) as server:
        for provider in ("FAKE", "OPENAI", "OPENROUTER"):
            monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")

        async def ask():
            line = lines.ModelClient(model, ModelSettings(), Access(**({"pause": 0, "retries": 1} | access)))
            try:
                return await line.ask([Message(role="user", text="joints: A, B")], {"type": "object"})
            except ModelFault as fault:
                return fault
            finally:
                await line.aclose()

        return asyncio.run(ask()), server.arrived.total()


def said_in_responses(monkeypatch, output, status="completed", **more):
    usual = {"id": "x", "object": "response", "created_at": 1, "model": "fake", "parallel_tool_calls": True}
    usage = {
        "input_tokens": 11,
        "output_tokens": 5,
        "total_tokens": 16,
        "output_tokens_details": {"reasoning_tokens": 5},
    }
    answer = usual | {"tools": [], "tool_choice": "auto", "status": status, "output": output, "usage": usage} | more
    return asked(monkeypatch, (200, answer), "openai/o3")


def message(*texts, kind="output_text"):
    key = "refusal" if kind == "refusal" else "text"
    parts = [{"type": kind, key: text, "annotations": []} for text in texts]
    return {"type": "message", "id": "y", "role": "assistant", "status": "completed", "content": parts}


REASONING = {"type": "reasoning", "id": "r", "summary": []}


@pytest.mark.parametrize(
    ("output", "more", "text", "stop"),
    [
        ([REASONING, message("a r", "eply")], {}, "a reply", "stop"),
        ([message("I cannot help.", kind="refusal")], {}, "I cannot help.", REFUSED),
        ([], {"status": "incomplete", "incomplete_details": {"reason": "content_filter"}}, REFUSED, REFUSED),
        (
            [REASONING],
            {"status": "incomplete", "incomplete_details": {"reason": "max_output_tokens"}},
            "",
            "max_tokens",
        ),
        ([REASONING], {}, "", "stop"),
    ],
)
def test_the_newer_interface_says_the_same(monkeypatch, output, more, text, stop):
    reply, times = said_in_responses(monkeypatch, output, **more)
    assert (reply.text, reply.stop, times) == (text, stop, 1)


@pytest.mark.parametrize(
    ("output", "more"),
    [
        ([], {}),
        ([message()], {}),
        ([message("")], {"usage": {"input_tokens": 11, "output_tokens": 0, "total_tokens": 11}}),
        ([], {"status": "queued"}),
        ([message("a r")], {"status": "in_progress"}),
        ([message("a r")], {"status": "incomplete"}),
        ([], {"status": "failed"}),
        ([message("a r")], {"status": "cancelled"}),
        ([message("a r")], {"status": "failed", "error": {"code": "server_error", "message": "Upstream error"}}),
    ],
)
def test_the_newer_interface_has_the_same_faults(monkeypatch, output, more):
    fault, times = said_in_responses(monkeypatch, output, **more)
    assert (type(fault), times) == (ModelFault, 2)


def test_a_client_is_changed_once_and_what_is_streamed_is_left_alone():
    openai = pytest.importorskip("openai")

    async def changed():
        client = openai.AsyncOpenAI(api_key="k", base_url="http://here/v1")

        async def usual(**request):
            return openai.types.chat.ChatCompletion.model_construct(choices=[], usage=None)

        client.chat.completions.create = usual
        answers.check_answers(client)
        create = client.chat.completions.create
        answers.check_answers(client)
        assert client.chat.completions.create is create
        with pytest.raises(answers.Declined):
            await create()
        assert (await create(stream=True)).choices == []
        await client.close()

    asyncio.run(changed())


@pytest.mark.parametrize("client", [None, object()])
def test_other_clients_are_left_alone(client):
    answers.check_answers(client)
