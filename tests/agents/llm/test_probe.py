"""What one request shows of a model and its server."""

import json
import socket
import time

import pytest
from provider_server import completion, failure
from typed import in_process

MODEL = "llm:openai-api/fake/model"
GOOD = {"joint": "A", "colour": "red"}


@pytest.fixture
def found(served):
    """What the command says, by what it is about, and the requests that it made."""

    def ask(answer, model=MODEL):
        with served(answer) as server:
            said = [json.loads(line) for line in in_process("doctor", model, "--json").stdout.splitlines()]
        assert "private" not in repr(said)
        return {one["what"]: (one["ok"], one["detail"]) for one in said}, server.requests

    return ask


def pictures(request):
    """The files in a request."""
    parts = [part for part in request["messages"][0]["content"] if isinstance(part, dict)]
    return [part["image_url"]["url"] for part in parts if part["type"] == "image_url"]


def test_a_model_that_does_all_is_asked_once(found):
    shown, requests = found(lambda request: completion(json.dumps(GOOD)))
    assert len(requests) == len(pictures(requests[0])) == 1
    assert shown["server"][1].endswith(" s, fake")
    assert {what: detail for what, (_, detail) in shown.items() if what != "server"} == {
        "key": "accepted",
        "tokens": "11 in, 5 out",
        "form of the reply": "strict, kept",
        "pictures": "read",
        "reasoning": "none",
    }
    assert all(ok for ok, _ in shown.values())


def blind(request):
    return failure(400, "No images") if pictures(request) else completion(json.dumps(GOOD))


def bare(request):
    status, body = completion("Sure: A, red")
    return status, body | {"usage": None}


def thinking(request):
    status, body = completion("")
    body["choices"][0]["message"]["reasoning_content"] = json.dumps(GOOD)
    return status, body


@pytest.mark.parametrize(
    ("answer", "model", "what", "ok", "detail", "times"),
    [
        (blind, MODEL, "pictures", False, "refused: the provider answered 400: No images", 2),
        (blind, "llm:openai/o3-mini", "pictures", True, "not sent: it reads none", 1),
        (lambda request: completion('{"joint": "A", "colour": "none"}'), MODEL, "pictures", False, "sent; of a red one it said 'none'", 1),
        (lambda request: completion(f"```{json.dumps(GOOD)}```"), MODEL, "form of the reply", True, "strict, not kept, but it can", 1),
        (bare, MODEL, "form of the reply", False, "not one JSON object; schema=none asks for it in words", 1),
        (lambda request: completion('{"joi', stop="length"), MODEL, "form of the reply", False, "the reply was cut at 5 tokens: raise max_tokens", 1),
        (lambda request: failure(429, "later"), MODEL, "server", False, "http://", 1),
        (bare, MODEL, "tokens", False, "not counted: a budget takes the most for every call", 1),
        (thinking, MODEL, "form of the reply", False, "the object stands in the reasoning and not in the reply; schema=none", 1),
        (thinking, MODEL, "reasoning", True, "shown", 1),
        (lambda request: failure(401, "Incorrect key"), MODEL, "key", False, "the provider answered 401: Incorrect key", 1),
        (lambda request: failure(500, "broken"), MODEL, "request", False, "the provider answered 500: broken", 1),
        (lambda request: completion(None, refusal="No."), MODEL, "form of the reply", False, "refused: No.", 1),
    ],
)  # fmt: skip
def test_what_does_not_work_is_said_with_what_helps(found, answer, model, what, ok, detail, times):
    shown, requests = found(answer, model)
    assert shown[what][0] is ok
    assert shown[what][1].startswith(detail)
    assert len(requests) == times


def test_a_dead_server_is_said_to_be_within_seconds(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    monkeypatch.setenv("FAKE_BASE_URL", f"http://127.0.0.1:{port}/v1")
    began = time.monotonic()
    done = in_process("doctor", MODEL)
    said = f"wrong    server: http://127.0.0.1:{port}/v1/chat/completions: no connection to the provider"
    assert (done.exit_code, done.stdout.count("\n"), done.stdout.startswith(said)) == (1, 1, True)
    assert time.monotonic() - began < 5
