"""A provider on loopback: OpenAI's chat completions, with latency, faults, and an account of both.

``here`` serves from a thread, ``elsewhere`` from a process of its own, and so does
``python tests/provider_server.py '{"median": 0.5}'``, which prints its URL and serves until its input ends.

Latency and faults are drawn by hash of the conversation, so that the same step of the same trial fares the same
whoever asks and in whatever order. A fault is drawn anew every time that the same request comes.
"""

import asyncio
import base64
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
from dataclasses import asdict, dataclass, field

HTTP_FAULTS = (
    "429 with Retry-After",
    "429",
    "500",
    "dropped",
    "dropped midway",
    "stalled",
    "truncated",
    "malformed",
    "a string",
)
"""Faults of a provider: there is no reply."""

REPLY_FAULTS = ("wrong schema", "refusal", "filtered", "empty", "cut")
"""Faults of a model: there is a reply, and it cannot be used."""

FAULTS = (*HTTP_FAULTS, *REPLY_FAULTS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner:
    """How a provider behaves.

    Attributes:
        answer: ``truthful`` or ``blind``, where no function is given.
        median: Median latency in seconds; 0 answers at once.
        sigma: Spread of the logarithm of the latency.
        faults: Share of requests that fare so, by kind, as listed in ``FAULTS``.
        retry_after: Seconds that ``429 with Retry-After`` asks for.
        seed: Of latencies and faults.
        keeps: Whether connections live on after an answer.
    """

    answer: str = "truthful"
    median: float = 0.0
    sigma: float = 0.5
    faults: dict[str, float] = field(default_factory=dict)
    retry_after: float = 0.02
    seed: int = 1
    keeps: bool = True

    def __post_init__(self):
        assert set(self.faults) <= set(FAULTS), f"no such fault: {set(self.faults) - set(FAULTS)}"
        assert sum(self.faults.values()) <= 1 + 1e-9

    def latency(self, conversation):
        """Seconds that this conversation takes to be answered."""
        if not self.median:
            return 0.0
        return random.Random(f"{self.seed} latency {conversation}").lognormvariate(math.log(self.median), self.sigma)

    def fault(self, conversation, time):
        """What goes wrong when this conversation comes for the so-manieth time, from 1; empty where nothing does."""
        if not self.faults:
            return ""
        luck = random.Random(f"{self.seed} fault {conversation} {time}").random()
        for kind, share in self.faults.items():
            luck -= share
            if luck < 0:
                return kind
        return ""


def mixed(share, *, http=2 / 3):
    """Faults of all kinds: so large a share of requests, so much of it of the provider and the rest of the model."""
    return {
        **dict.fromkeys(HTTP_FAULTS, share * http / len(HTTP_FAULTS)),
        **dict.fromkeys(REPLY_FAULTS, share * (1 - http) / len(REPLY_FAULTS)),
    }


class Server:
    """Answers chat completions, and counts.

    Attributes:
        url: Base URL, once it runs.
        requests: Every request that came, in order, where they are kept.
        headers: Every header line that came, each once.
        arrived: How often each conversation came.
        replied: How often each got a whole reply, good or bad, onto the wire.
        left: Requests whose client had left before there was a reply.
        faults: How often each kind of fault was given.
        peak: Most requests on their way at once.
        latency: Seconds that all replies took together.
        chain: For each conversation, the seconds of it and of all that led up to it.
    """

    def __init__(self, answer=None, manner=None, *, keep=False):
        self.manner = manner or Manner()
        self._answer = answer or ANSWERS[self.manner.answer]
        self._keep = keep
        self.url = ""
        self.requests = []
        self.headers = set()
        self.arrived, self.replied, self.faults = Counter(), Counter(), Counter()
        self.left = self.peak = self._on_their_way = 0
        self.latency = 0.0
        self.chain = {}
        self._open = set()

    def account(self):
        """All counts as one JSON object; conversations by their hash."""
        return {
            "arrived": self.arrived.total(),
            "replied": self.replied.total(),
            "left": self.left,
            "faults": dict(self.faults),
            "peak": self.peak,
            "on_their_way": self._on_their_way,
            "latency": self.latency,
            "longest_chain": max(self.chain.values(), default=0.0),
            "conversations": {key: [times, self.replied[key]] for key, times in self.arrived.items()},
        }

    async def serve(self, started, until):
        """Serve on a free port until told to stop.

        Args:
            started: Called with the base URL.
            until: Awaited.
        """
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
        """One request and its answer; whether the connection lives on."""
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1")
        first, *lines = head.strip().split("\r\n")
        self.headers.update(lines)
        headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines)}
        body = await reader.readexactly(int(headers.get("content-length", 0)))
        if first.startswith("GET"):
            _send(writer, 200, json.dumps(self.account()).encode())
            return True
        request = json.loads(body)
        if self._keep:
            self.requests.append(request)
        self._on_their_way += 1
        self.peak = max(self.peak, self._on_their_way)
        try:
            return await self._answered(request, reader, writer)
        finally:
            self._on_their_way -= 1

    async def _answered(self, request, reader, writer):
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
        if reader.at_eof():
            self.left += 1
            return False
        self.latency += latency
        if fault == "dropped":
            return False
        status, content, more = self._content(request, fault)
        if not self.manner.keeps:
            more = [*more, "connection: close"]
        _send(writer, status, content, more, cut=fault == "dropped midway")
        if fault == "dropped midway":
            await writer.drain()
            return False
        self.replied[name] += fault not in HTTP_FAULTS
        return self.manner.keeps

    def _content(self, request, fault):
        """What is sent: status, body, more header lines."""
        if fault.startswith("429"):
            after = [f"retry-after: {self.manner.retry_after}"] if fault != "429" else []
            return *_encoded(*failure(429, "Rate limit reached")), after
        if fault == "500":
            return *_encoded(*failure(500, "The server had an error")), []
        if fault == "a string":
            return *_encoded(200, "service unavailable"), []
        status, content = self._answer(request)
        if fault in REPLY_FAULTS:
            content = spoilt(content, fault)
        status, whole = _encoded(status, content)
        if fault == "truncated":
            whole = whole[: len(whole) // 2]
        elif fault == "malformed":
            whole = whole.replace(b":", b";", 3)
        return status, whole, []


def _encoded(status, content):
    return status, content if isinstance(content, bytes) else json.dumps(content).encode()


def _send(writer, status, content, more=(), *, cut=False):
    lines = [f"HTTP/1.1 {status} x", "content-type: application/json", f"content-length: {len(content)}", *more]
    writer.write("\r\n".join([*lines, "", ""]).encode() + (content[: len(content) // 2] if cut else content))


@contextlib.contextmanager
def here(answer=None, manner=None, *, keep=False):
    """A server in a thread of this process."""
    server = Server(answer, manner, keep=keep)
    loop = asyncio.new_event_loop()
    ready, end = threading.Event(), loop.create_future()
    thread = threading.Thread(
        target=lambda: loop.run_until_complete(server.serve(lambda url: ready.set(), end)), daemon=True
    )
    thread.start()
    ready.wait()
    try:
        yield server
    finally:
        loop.call_soon_threadsafe(end.set_result, None)
        thread.join()
        loop.run_until_complete(_tidy())
        loop.close()


async def _tidy():
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)


@contextlib.contextmanager
def elsewhere(manner=None):
    """The base URL of a server in a process of its own; it dies with this one."""
    command = [sys.executable, __file__, json.dumps(asdict(manner or Manner()))]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        yield process.stdout.readline().strip()
        process.stdin.close()
        process.stdout.close()


def account(url):
    """What the server at a base URL has counted."""
    with urllib.request.urlopen(url.removesuffix("/v1") + "/account", timeout=60) as answer:
        return json.loads(answer.read())


def completion(text, *, stop="stop", refusal=None):
    """A successful answer that says this."""
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
    """An error of the provider."""
    return status, {"error": {"message": message, "type": "error", "code": status}}


def spoilt(content, fault):
    """The same answer with a reply that cannot be used."""
    text = content["choices"][0]["message"]["content"]
    return {
        "wrong schema": lambda: completion(json.dumps({"move": json.loads(text)["joint"]})),
        "refusal": lambda: completion(None, refusal="I cannot help with opening locks."),
        "filtered": lambda: completion("", stop="content_filter"),
        "empty": lambda: completion(""),
        "cut": lambda: completion(text[: len(text) // 2], stop="length"),
    }[fault]()[1]


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


def words(message):
    """The text of a message, whether pictures come with it or not."""
    content = message["content"] or ""
    return content if isinstance(content, str) else " ".join(part["text"] for part in content if part["type"] == "text")


def pictures(message):
    """The pictures of a message: (file, media type, detail) of each."""
    if isinstance(message["content"], str):
        return []
    found = []
    for part in message["content"]:
        if part["type"] == "image_url":
            media, _, data = part["image_url"]["url"].partition(";base64,")
            found.append((base64.b64decode(data, validate=True), media, part["image_url"]["detail"]))
    return found


def joints(request):
    """The joints in the order listed: of the form of the reply, or else of the text."""
    with contextlib.suppress(KeyError):
        return request["response_format"]["json_schema"]["schema"]["properties"]["joint"]["enum"]
    return re.search(r"joints?: (\w+(?:, \w+)+)", words(request["messages"][0]))[1].split(", ")


def _played(request, listing):
    """How many steps were played, and what was told last; replies that could not be used and their repairs aside."""
    turn, told = 0, request["messages"][0]
    for reply, after in zip(request["messages"], request["messages"][1:], strict=False):
        with contextlib.suppress(ValueError, KeyError, TypeError):
            if reply["role"] == "assistant" and json.loads(words(reply).strip("`json \n"))["joint"] in listing:
                turn, told = turn + 1, after
    return turn, words(told)


def _reply(request, choose):
    listing = joints(request)
    turn, told = _played(request, listing)
    said = "none" if turn == 0 else "did not move" if "did not move" in told else "moved"
    return completion(json.dumps({"last_action": said, "hypothesis": "in turn", "joint": choose(listing, turn)}))


def truthful(request):
    """A well-formed reply: it repeats what it was told and goes through the joints in the order listed."""
    return _reply(request, lambda listing, turn: listing[turn % len(listing)])


def blind(request):
    """A well-formed reply of one who keeps to two joints, which open no box of a chain: every trial takes its budget."""
    luck = int(names(request["messages"])[1], 16)
    return _reply(request, lambda listing, turn: listing[luck % 2])


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
