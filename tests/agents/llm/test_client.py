"""The line to a provider: who is asked, how often, how many at once, and what is kept of it."""

import asyncio
import contextlib
import gzip
import json
import os
import socket
import threading
import warnings
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from provider_server import Manner, completion, here

from lockprobe.agents.llm import client as lines
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import ModelFault

MODEL = "openai-api/fake/model"
SCHEMA = {"type": "object", "properties": {"joint": {"type": "string"}}, "required": ["joint"]}


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    for provider in ("FAKE", "OPENAI"):
        monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")


def reached(monkeypatch, url):
    for provider in ("FAKE", "OPENAI"):
        monkeypatch.setenv(f"{provider}_BASE_URL", url)


def asked(name=MODEL, times=1, **access):
    """Answers to so many conversations, asked for side by side."""

    async def all_of_them():
        line = lines.ModelClient(name, ModelSettings(), Access(**({"pause": 0.01} | access)))

        async def one(number):
            async with line.slots:
                return await line.ask([Message(role="user", text=f"joints: A, B; trial {number}")], SCHEMA)

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


@pytest.mark.parametrize("model", [MODEL, "openai/gpt-4o"])
def test_an_answer_says_who_gave_it_and_what_it_cost(monkeypatch, model):
    with here(reply) as server:
        reached(monkeypatch, server.url)
        answer = asked(model)
    assert (answer.text, answer.stop, answer.served, answer.retries) == ("a reply", "stop", "fake", 0)
    assert (answer.usage.calls, answer.usage.input_tokens, answer.usage.output_tokens) == (1, 11, 5)
    assert answer.seconds > 0


@pytest.mark.parametrize("model", [MODEL, "openai/gpt-4o"])
@pytest.mark.parametrize("fault", ["429 with Retry-After", "429", "500", "dropped", "dropped midway", "truncated",
                                   "malformed", "a string"])  # fmt: skip
def test_every_failure_that_passes_is_asked_again_and_counted_and_nobody_else_asks_again(monkeypatch, model, fault):
    class Once(Manner):
        def fault(self, conversation, time):
            return fault if time <= 2 else ""

    with here(reply, Once()) as server:
        reached(monkeypatch, server.url)
        answer = asked(model)
        assert not isinstance(answer, ModelFault), answer
        assert (answer.text, answer.retries) == ("a reply", 2)
        assert server.arrived.total() == 3
        server.arrived.clear()
        assert isinstance(asked(model, retries=1), ModelFault)
        assert server.arrived.total() == 2


def test_a_request_that_hangs_is_made_again(monkeypatch):
    class Once(Manner):
        def fault(self, conversation, time):
            return "stalled" if time == 1 else ""

    with here(reply, Once()) as server:
        reached(monkeypatch, server.url)
        answer = asked(timeout=0.5)
        assert answer.text == "a reply"
        assert (
            answer.retries == server.arrived.total() - 1 >= 1
        )  # where the machine is busy, other attempts may be late
        assert answer.seconds >= 0.5


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_server_that_is_down_is_reported_in_one_line(monkeypatch, host):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    reached(monkeypatch, f"http://{host}:{port}/v1")
    fault = asked(retries=1)
    assert str(fault).startswith("no connection to the provider: ")
    assert str(fault).endswith(" (tried 2 times)")
    assert "refused" in str(fault) or "Connect call failed" in str(fault)


def test_no_more_requests_are_on_their_way_than_there_are_connections(monkeypatch):
    with here(reply, Manner(median=0.02)) as server:
        reached(monkeypatch, server.url)
        answers = asked(times=12, connections=3)
    assert [answer.text for answer in answers] == ["a reply"] * 12
    assert server.peak == 3


def test_nothing_of_an_odd_body_is_printed(monkeypatch, capfd):
    odd = completion("a reply")[1] | {"usage": {"prompt_tokens": "private", "completion_tokens": 1, "total_tokens": 1}}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with here(lambda request: (200, odd)) as server:
            reached(monkeypatch, server.url)
            answer = asked(retries=1)
    assert answer.text == "a reply"  # its count is none
    assert [str(warning.message) for warning in caught if "private" in str(warning.message)] == []
    assert "private" not in "".join(capfd.readouterr())


def test_attempts_that_may_have_been_charged_are_counted(monkeypatch):
    class Twice(Manner):
        def fault(self, conversation, time):
            return {1: "truncated", 2: "500", 3: "stalled", 4: "dropped"}.get(time, "")

    with here(reply, Twice()) as server:
        reached(monkeypatch, server.url)
        answer = asked(timeout=0.5)
    assert answer.text == "a reply"
    assert (
        answer.unanswered == answer.retries - 1 >= 3
    )  # all but the 500; where the machine is busy, others may be late


class Raw(BaseHTTPRequestHandler):
    """Answers every request as its class says, and counts."""

    asked = 0

    def do_POST(self):
        type(self).asked += 1
        self.rfile.read(int(self.headers["content-length"]))
        self.respond()

    def do_GET(self):
        self.do_POST()

    def log_message(self, *_):
        pass


@contextlib.contextmanager
def raw(respond):
    handler = type("Answering", (Raw,), {"respond": respond})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/v1", handler
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@pytest.mark.parametrize("status", [301, 302, 307, 308])
def test_a_redirect_to_another_origin_is_refused_and_nothing_is_sent_there(monkeypatch, status):
    with here(lambda request: completion("said"), keep=True) as elsewhere:

        def respond(handler):
            handler.send_response(status)
            handler.send_header("location", f"{elsewhere.url}/chat/completions")
            handler.send_header("content-length", "0")
            handler.end_headers()

        with raw(respond) as (url, handler):
            reached(monkeypatch, url)
            with pytest.raises(ModelFault) as fault:
                raise asked(retries=3)
    there = elsewhere.url.removesuffix("/v1")
    expected = f"a redirect from {url.removesuffix('/v1')} to {there}, which must not get the conversation"
    assert str(fault.value) == f"the provider answered with {expected}"
    assert (elsewhere.requests, handler.asked, fault.value.unanswered) == ([], 1, 0)


def test_a_redirect_at_the_same_origin_is_followed(monkeypatch):
    def respond(handler):
        if handler.path == "/v1/chat/completions":
            handler.send_response(307)
            handler.send_header("location", "/v2/chat/completions")
            body = b""
        else:
            handler.send_response(200)
            handler.send_header("content-type", "application/json")
            body = json.dumps(completion("said")[1]).encode()
        handler.send_header("content-length", str(len(body)))
        handler.end_headers()
        handler.wfile.write(body)

    with raw(respond) as (url, _):
        reached(monkeypatch, url)
        assert asked().text == "said"


@pytest.mark.parametrize("packed", [False, True])
def test_an_answer_without_end_is_refused(monkeypatch, packed):
    monkeypatch.setattr("lockprobe.agents.llm.client.LARGEST_ANSWER", 100_000)
    body = b" " * 200_000
    content = gzip.compress(body) if packed else body

    def respond(handler):
        handler.send_response(200)
        handler.send_header("content-type", "application/json")
        if packed:
            handler.send_header("content-encoding", "gzip")
        handler.send_header("content-length", str(len(content)))
        handler.end_headers()
        with contextlib.suppress(ConnectionError):
            handler.wfile.write(content)

    with raw(respond) as (url, handler):
        reached(monkeypatch, url)
        with pytest.raises(ModelFault, match="answered with an answer of more than 100000 bytes$") as fault:
            raise asked(retries=3)
    assert (handler.asked, fault.value.unanswered) == (1, 1)


def test_an_answer_packed_as_nobody_asked_is_refused(monkeypatch):
    def respond(handler):
        handler.send_response(200)
        handler.send_header("content-encoding", "br")
        handler.send_header("content-length", "1")
        handler.end_headers()
        handler.wfile.write(b"x")

    with raw(respond) as (url, _):
        reached(monkeypatch, url)
        assert "an answer compressed with br, which was not requested" in str(asked(retries=0))
