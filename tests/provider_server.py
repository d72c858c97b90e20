"""A scripted provider on loopback that answers chat completions, with latency, faults, and an account of both.

``here`` serves from a thread, ``elsewhere`` from a process of its own, and so does
``python tests/provider_server.py '{"median": 0.5}'``, which prints its URL and serves until its input ends.

Latency and faults are drawn by hash of the conversation, so that the same step of the same trial fares the same
whoever asks and in whatever order. A fault is drawn anew every time that the same request comes.
"""

import asyncio
import contextlib
import hashlib
import json
import math
import random
import re
import subprocess
import sys
import threading
import urllib.request
from collections import Counter
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field

import pytest

HTTP_FAULTS = (
    "429 with Retry-After", "429", "500", "dropped", "dropped midway", "stalled", "truncated", "malformed", "a string",
    "upstream", "no content",
)  # fmt: skip
"""Faults of a provider: there is no reply."""

REPLY_FAULTS = ("wrong schema", "empty")
"""Faults of a model: there is a reply, and it cannot be used."""

ENDS = ("refusal", "filtered", "cut")
"""What ends a trial: there is no other reply to be had; the second one that is cut off ends it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner:
    """How a provider behaves.

    Attributes:
        answer: ``truthful`` or ``blind``, where no function is given.
        median: Median latency in seconds; 0 answers at once. ``sigma`` is the spread of its logarithm.
        faults: Share of requests that fare so, by kind; or an iterator of kinds in the order in which requests come.
        keeps: Whether connections live on after an answer.
        more: Header lines of every answer, beside the usual ones.
    """

    answer: str = "truthful"
    median: float = 0.0
    sigma: float = 0.5
    faults: dict[str, float] = field(default_factory=dict)
    seed: int = 1
    keeps: bool = True
    more: tuple[str, ...] = ()

    def latency(self, conversation):
        """Seconds that this conversation takes to be answered."""
        return self.median and random.Random(f"{self.seed} latency {conversation}").lognormvariate(
            math.log(self.median), self.sigma
        )

    def fault(self, conversation, time):
        """What goes wrong when this conversation comes for the so-manieth time, from 1; empty where nothing does."""
        if not isinstance(self.faults, dict):
            return next(self.faults, "")
        luck = random.Random(f"{self.seed} fault {conversation} {time}").random()
        for kind, share in self.faults.items():
            luck -= share
            if luck < 0:
                return kind
        return ""


def mixed(share):
    """Faults of all kinds: so large a share of requests, two thirds of it of the provider and the rest of the model."""
    of_model = dict.fromkeys(REPLY_FAULTS, share / 3 / len(REPLY_FAULTS))
    return dict.fromkeys(HTTP_FAULTS, share * 2 / 3 / len(HTTP_FAULTS)) | of_model


ASKED = ("ANTHROPIC", "FAKE", "OPENAI", "OPENROUTER")
"""How the variables of those begin that are asked at a server here."""


class Server:
    """Answers chat completions by a function, with latency and faults, and counts.

    It serves from a thread while its ``with`` block runs, because the caller's thread may run an event loop, and is
    the provider of ``llm:openai-api/fake/…`` meanwhile. What the function raises is answered with status 400 and raised
    again at the end of the block.

    Attributes:
        url: Base URL, once it runs.
        requests: The body of every request, in order.
        headers: Every header line received, each once.
        arrived: How often each conversation came.
        replied: How often each got a whole reply, good or bad, onto the wire.
        faults: How often each kind of fault was given.
        peak: Most requests on their way at once.
        latency: Seconds that all replies took together.
        chain: For each conversation, the seconds of it and of all that led up to it.
    """

    def __init__(self, answer=None, manner=None):
        self.manner = manner or Manner()
        self.answers = answer or ANSWERS[self.manner.answer]
        self.url, self.requests, self.headers = "", [], set()
        self._open, self._raised = set(), None
        self.arrived, self.replied, self.faults = Counter(), Counter(), Counter()
        self.peak = self._on_their_way = 0
        self.latency = 0.0
        self.chain = {}

    def __enter__(self):
        self._loop = asyncio.new_event_loop()
        ready, self._end = threading.Event(), self._loop.create_future()
        serving = self.serve(lambda url: ready.set(), self._end)
        self._thread = threading.Thread(target=self._run, args=(serving,), daemon=True)
        self._thread.start()
        ready.wait()
        self._named = ExitStack()
        self._named.enter_context(named(self.url))
        return self

    def __exit__(self, kind, error, trace):
        self._named.close()
        self._loop.call_soon_threadsafe(self._end.set_result, None)
        self._thread.join()
        if self._raised is not None and error is None:
            raise self._raised

    def _run(self, serving):
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(serving)

    async def serve(self, started, until):
        """Serve on a free port until ``until`` is done; ``started`` is called with the base URL."""
        server = await asyncio.start_server(self._connection, "127.0.0.1", 0, limit=2**26, backlog=1024)
        self.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/v1"
        started(self.url)
        await until
        server.close()
        for writer in list(self._open):
            writer.transport.abort()
        await asyncio.sleep(0.01)

    async def _connection(self, reader, writer):
        self._open.add(writer)
        try:
            with contextlib.suppress(ConnectionError, asyncio.IncompleteReadError):
                while await self._exchange(reader, writer):
                    pass
        finally:
            self._open.discard(writer)
            writer.close()

    async def _exchange(self, reader, writer):
        """One request and its answer; whether the connection stays open."""
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1")
        first, *lines = head.strip().split("\r\n")
        self.headers.update(lines)
        headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines)}
        body = await reader.readexactly(int(headers.get("content-length", 0)))
        if first.startswith("GET"):
            send(writer, 200, self.account())
            return True
        request = json.loads(body)
        self.requests.append(request)
        self._on_their_way += 1
        self.peak = max(self.peak, self._on_their_way)
        try:
            return await self._late(request, reader, writer)
        finally:
            self._on_their_way -= 1

    def account(self):
        """All counts as one JSON object; conversations by their hash."""
        return {
            "arrived": self.arrived.total(),
            "replied": self.replied.total(),
            "faults": dict(self.faults),
            "peak": self.peak,
            "on_their_way": self._on_their_way,
            "latency": self.latency,
            "longest_chain": max(self.chain.values(), default=0.0),
            "conversations": {key: [times, self.replied[key]] for key, times in self.arrived.items()},
        }

    async def _late(self, request, reader, writer):
        before, name = names(request["messages"])
        self.arrived[name] += 1
        latency = self.manner.latency(name)
        self.chain[name] = self.chain.get(before, 0.0) + latency
        fault = self.manner.fault(name, self.arrived[name])
        if fault:
            self.faults[fault] += 1
        if fault == "stalled":
            while await reader.read(1024):
                pass
        elif latency:
            await asyncio.sleep(latency)
        if reader.at_eof():  # the client has left
            return False
        self.latency += latency
        if fault == "dropped":
            return False
        status, content = self._content(request, fault)
        more = [*self.manner.more, *["retry-after: 0.01"] * ("Retry-After" in fault)]
        more += [] if self.manner.keeps else ["connection: close"]
        send(writer, status, content, more, midway=fault == "dropped midway")
        if fault == "dropped midway":
            await writer.drain()
            return False
        self.replied[name] += fault not in HTTP_FAULTS
        return self.manner.keeps

    def _content(self, request, fault):
        """What is sent: status and body."""
        if fault.startswith("429"):
            return failure(429, "Rate limit reached")
        if fault == "500":
            return failure(500, "The server had an error")
        if fault == "a string":
            return 200, "service unavailable"
        try:
            status, content = self.answers(request)
        except (AssertionError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            self._raised = self._raised or error
            return failure(400, f"{type(error).__name__}: {error}")
        content = SPOILT.get(fault, lambda content: content)(content)
        whole = json.dumps(content).encode() if fault in ("truncated", "malformed") else b""
        if fault == "truncated":
            return status, whole[: len(whole) // 2]
        return status, whole.replace(b":", b";", 3) or content


@contextlib.contextmanager
def named(url):
    """The environment says that the fake provider is there, and has a key for it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAKE_BASE_URL", url)
        patch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        yield


here = Server
"""A server in a thread of this process."""


@contextlib.contextmanager
def elsewhere(manner=None):
    """The base URL of a server in a process of its own, which is the fake provider meanwhile; it dies with this one."""
    command = [sys.executable, __file__, json.dumps(asdict(manner or Manner()))]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        with named(url := process.stdout.readline().strip()):
            yield url
        process.stdin.close()
        process.stdout.close()


def account(url):
    """What the server at a base URL has counted."""
    with urllib.request.urlopen(url.removesuffix("/v1") + "/account", timeout=60) as answer:
        return json.loads(answer.read())


def send(writer, status, body, more=(), *, midway=False):
    """Write an answer: bytes as they are, everything else as JSON. ``midway`` leaves out half of it."""
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    lines = [f"HTTP/1.1 {status} x", "content-type: application/json", f"content-length: {len(content)}", *more]
    writer.write("\r\n".join([*lines, "", ""]).encode() + (content[: len(content) // 2] if midway else content))


def completion(text, *, stop="stop", refusal=None):
    """A successful answer with this text, or with that of a model that refuses."""
    message = {"role": "assistant", "content": text} | ({} if refusal is None else {"refusal": refusal})
    return 200, {
        "id": "x",
        "object": "chat.completion",
        "created": 1,
        "model": "fake",
        "choices": [{"index": 0, "message": message, "finish_reason": stop}],
        "usage": {"prompt_tokens": 11, "completion_tokens": 5, "total_tokens": 16},
    }


def failure(status, message):
    """An error of the provider. Lockprobe asks again after 429 and those from 500 on; others end a trial."""
    return status, {"error": {"message": message, "type": "error", "code": status}}


def words(message):
    """The text of a message, with or without pictures."""
    content = message["content"] or ""
    return content if isinstance(content, str) else " ".join(part["text"] for part in content if part["type"] == "text")


def joints(request):
    """The joints in listed order, from the reply form or else from the text."""
    with contextlib.suppress(KeyError):
        return list(form(request)["joint"]["enum"])
    return re.search(r"joints?: (\w+(?:, \w+)+)", words(request["messages"][0]))[1].split(", ")


def form(request):
    """The parts of the reply that is asked for."""
    return request["response_format"]["json_schema"]["schema"]["properties"]


def replying(request, joint, hypothesis="in turn"):
    """A reply in the requested form that names a joint and repeats the last report."""
    turn, told = turns(request)
    last = "none" if turn == 0 else "did not move" if "did not move" in told else "moved"
    all_said = {"last_action": last, "hypothesis": hypothesis, "joint": joint}
    asked = ["last_action", "hypothesis", "joint"]
    with contextlib.suppress(KeyError):
        asked = list(form(request))
    return completion(json.dumps({key: all_said[key] for key in asked}))


def turns(request):
    """The number of steps played and the last report; replies that could not be used do not count."""
    turn, told = 0, request["messages"][0]
    for reply, after in zip(request["messages"], request["messages"][1:], strict=False):
        if reply["role"] == "assistant" and "could not be used" not in words(after):
            turn, told = turn + 1, after
    return turn, words(told)


def truthful(request):
    """A well-formed reply: it repeats what it was told and goes through the joints in the order listed."""
    listing, (turn, _) = joints(request), turns(request)
    return replying(request, listing[turn % len(listing)])


def text_of(content):
    """The reply in an answer."""
    return content["choices"][0]["message"]["content"]


def upstream(content):
    """The answer of a router whose own provider broke: status 200, and the error in the choice."""
    (choice,) = content["choices"]
    error = {"code": 502, "message": "Upstream error"}
    broken = choice | {"message": {"role": "assistant", "content": ""}, "finish_reason": "error", "error": error}
    return content | {"choices": [broken], "usage": None}


SPOILT = {
    "upstream": upstream,
    "no content": lambda content: completion(None)[1] | {"usage": None},
    "wrong schema": lambda content: completion(json.dumps({"move": json.loads(text_of(content))["joint"]}))[1],
    "refusal": lambda content: completion(None, refusal="I cannot help with opening locks.")[1],
    "filtered": lambda content: completion("", stop="content_filter")[1],
    "empty": lambda content: completion("")[1],
    "cut": lambda content: completion(text_of(content)[: len(text_of(content)) // 2], stop="length")[1],
}
"""By fault, the same answer with something else in the place of its reply."""


def names(messages):
    """The hashes of a conversation before its last two messages, and of all of it."""
    so_far, before = hashlib.sha256(), ""
    for number, message in enumerate(messages):
        if number == len(messages) - 2:
            before = so_far.hexdigest()[:16]
        content = message["content"]
        if isinstance(content, list) and all(part["type"] == "text" for part in content):
            content = words(message)
        so_far.update(json.dumps([message["role"], content]).encode())
    return before, so_far.hexdigest()[:16]


def blind(request):
    """A well-formed reply of one who keeps to two joints, which open no box of a chain: every trial takes its budget."""
    luck = int(names(request["messages"])[1], 16)
    return replying(request, joints(request)[luck % 2])


def counted(request):
    """An answer with about as many tokens as a provider would count."""
    status, body = truthful(request)
    read, written = sum(len(words(message)) for message in request["messages"]) // 3, len(text_of(body)) // 3
    return status, body | {
        "usage": {"prompt_tokens": read, "completion_tokens": written, "total_tokens": read + written}
    }


ANSWERS = {"truthful": truthful, "blind": blind}


def main():
    """Serve in this process until its input ends."""
    server = Server(manner=Manner(**json.loads(sys.argv[1] if len(sys.argv) > 1 else "{}")))

    async def serve():
        end = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
        await server.serve(lambda url: print(url, flush=True), end)

    asyncio.run(serve())


if __name__ == "__main__":
    main()
