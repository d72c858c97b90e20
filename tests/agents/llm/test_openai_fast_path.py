"""What goes over the wire is what the client would have sent, and what comes back is what it would have given."""

import asyncio
import json

import pytest

openai = pytest.importorskip("openai")
httpx = pytest.importorskip("httpx2")
plainly = pytest.importorskip("lockprobe.agents.llm.openai_fast_path")

PICTURE = {"type": "image_url", "image_url": {"url": "data:image/png;base64,iVBORw0KGgo=", "detail": "high"}}
SCHEMA = {"type": "object", "properties": {"joint": {"type": "string", "enum": ["A", "B"]}}}
CHAT = {
    "model": "m",
    "messages": [
        {"role": "user", "content": [{"type": "text", "text": "joints: A, B é"}, PICTURE]},
        {"role": "assistant", "content": '{"joint": "A"}'},
        {"role": "user", "content": "A did not move."},
    ],
    "temperature": 0.0,
    "max_completion_tokens": 100,
    "response_format": {"type": "json_schema", "json_schema": {"name": "reply", "schema": SCHEMA, "strict": True}},
    "tools": openai.NOT_GIVEN,
    "tool_choice": openai.NOT_GIVEN,
    "stop": openai.omit,
    "extra_headers": {"x-irid": "17"},
}
RESPONSES = {
    "model": "m",
    "input": [{"role": "user", "content": [{"type": "input_text", "text": "joints: A, B"}]}],
    "reasoning": {"effort": "low"},
    "store": False,
    "text": {"format": {"type": "json_schema", "name": "reply", "schema": SCHEMA, "strict": True}},
    "tools": openai.NOT_GIVEN,
    "extra_headers": {"x-irid": "17"},
}
SAID = {"id": "x", "object": "chat.completion", "created": 1, "model": "fake", "choices": [
    {"index": 0, "message": {"role": "assistant", "content": "yes"}, "finish_reason": "stop"}]}  # fmt: skip
ANSWERED = {"id": "x", "object": "response", "created_at": 1, "model": "fake", "status": "completed", "output": [
    {"type": "message", "id": "y", "role": "assistant", "status": "completed",
     "content": [{"type": "output_text", "text": "yes", "annotations": []}]}],
    "parallel_tool_calls": True, "tool_choice": "auto", "tools": []}  # fmt: skip


def sent(request, *, as_is, answer=200):
    """The request as it arrives, and what the caller gets."""
    arrived = []

    def handle(asked):
        arrived.append(asked)
        body = SAID if asked.url.path.endswith("/chat/completions") else ANSWERED
        return httpx.Response(answer, json=body if answer == 200 else {"error": {"message": "no such model"}})

    async def call():
        http = httpx.AsyncClient(transport=httpx.MockTransport(handle))
        client = openai.AsyncOpenAI(api_key="k", base_url="http://here/v1", http_client=http, max_retries=0)
        if as_is:
            plainly.use_fast_path(client)
        try:
            create = client.chat.completions.create if "messages" in request else client.responses.create
            return await create(**request)
        finally:
            await client.close()

    came = asyncio.run(call())
    return arrived[0], came


@pytest.mark.parametrize("request_", [CHAT, RESPONSES], ids=["chat", "responses"])
def test_the_same_is_sent_and_the_same_comes_back(request_):
    as_is, usual = sent(request_, as_is=True), sent(request_, as_is=False)
    assert json.loads(as_is[0].content) == json.loads(usual[0].content)
    assert {"tools", "tool_choice", "stop", "extra_headers"}.isdisjoint(json.loads(as_is[0].content))
    assert as_is[0].url == usual[0].url
    assert dict(as_is[0].headers) == dict(usual[0].headers)
    assert as_is[0].headers["x-irid"] == "17"
    assert as_is[0].headers["authorization"] == "Bearer k"
    assert as_is[1] == usual[1]
    assert type(as_is[1]) is type(usual[1])


def test_a_refusal_is_the_same_error():
    with pytest.raises(openai.NotFoundError, match="no such model"):
        sent(CHAT, as_is=True, answer=404)


def test_what_is_streamed_goes_the_usual_way():
    _, came = sent(CHAT | {"stream": True}, as_is=True)
    assert isinstance(came, openai.AsyncStream)


@pytest.mark.parametrize("client", [None, object()])
def test_other_clients_are_left_alone(client):
    plainly.use_fast_path(client)
