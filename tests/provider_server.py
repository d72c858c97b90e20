"""The scripted provider that ships, with latency, faults, and an account of both.

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
import subprocess
import sys
import urllib.request
from collections import Counter
from dataclasses import asdict, dataclass, field

from lockprobe.testing.provider import (
    ScriptedProvider,
    completion,
    failure,
    in_turn,
    joints,
    replying,
    send,
    words,
)

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
    "upstream",
    "no content",
)
"""Faults of a provider: there is no reply."""

REPLY_FAULTS = ("wrong schema", "empty")
"""Faults of a model: there is a reply, and it cannot be used."""

ENDS = ("refusal", "filtered", "cut")
"""What ends a trial: there is no other reply to be had; the second one that is cut off ends it."""

FAULTS = (*HTTP_FAULTS, *REPLY_FAULTS, *ENDS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner:
    """How a provider behaves.

    Attributes:
        answer: ``truthful``, ``blind`` or ``counted``, where no function is given.
        median: Median latency in seconds; 0 answers at once.
        sigma: Spread of the logarithm of the latency.
        faults: Share of requests that fare so, by kind, as listed in ``FAULTS``.
        retry_after: Seconds that ``429 with Retry-After`` asks for.
        seed: Of latencies and faults.
        keeps: Whether connections live on after an answer.
        more: Header lines of every answer, beside the usual ones.
    """

    answer: str = "truthful"
    median: float = 0.0
    sigma: float = 0.5
    faults: dict[str, float] = field(default_factory=dict)
    retry_after: float = 0.02
    seed: int = 1
    keeps: bool = True
    more: tuple[str, ...] = ()

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


class Script:
    """Faults in the order in which requests come."""

    answer, retry_after, keeps, more = "truthful", 0.01, True, ()

    def __init__(self, *kinds, then=""):
        self._kinds, self._then = iter(kinds), then

    def latency(self, conversation):
        return 0.0

    def fault(self, conversation, time):
        return next(self._kinds, self._then)


def mixed(share, *, http=2 / 3):
    """Faults of all kinds: so large a share of requests, so much of it of the provider and the rest of the model."""
    return {
        **dict.fromkeys(HTTP_FAULTS, share * http / len(HTTP_FAULTS)),
        **dict.fromkeys(REPLY_FAULTS, share * (1 - http) / len(REPLY_FAULTS)),
    }


ASKED = ("ANTHROPIC", "FAKE", "OPENAI", "OPENROUTER")
"""How the variables of those begin that are asked at a server here."""


class Server(ScriptedProvider):
    """Answers chat completions with latency and faults, and counts.

    Attributes:
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
        super().__init__(answer or ANSWERS[self.manner.answer], name="unused", keep=keep)
        self.arrived, self.replied, self.faults = Counter(), Counter(), Counter()
        self.left = self.peak = self._on_their_way = 0
        self.latency = 0.0
        self.chain = {}

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

    told = account

    async def answered(self, request, reader, writer):
        self._on_their_way += 1
        self.peak = max(self.peak, self._on_their_way)
        try:
            return await self._late(request, reader, writer)
        finally:
            self._on_their_way -= 1

    async def _late(self, request, reader, writer):
        before, name = names(request["input"] if "input" in request else request["messages"])
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
        more = [*more, *self.manner.more]
        if not self.manner.keeps:
            more = [*more, "connection: close"]
        send(writer, status, content, more, midway=fault == "dropped midway")
        if fault == "dropped midway":
            await writer.drain()
            return False
        self.replied[name] += fault not in HTTP_FAULTS
        return self.manner.keeps

    def _content(self, request, fault):
        """What is sent: status, body, more header lines."""
        if fault.startswith("429"):
            after = [f"retry-after: {self.manner.retry_after}"] if fault != "429" else []
            return *failure(429, "Rate limit reached"), after
        if fault == "500":
            return *failure(500, "The server had an error"), []
        if fault == "a string":
            return 200, "service unavailable", []
        status, content = self.answer(request)
        if fault in SPOILT:
            content = SPOILT[fault](content)
        if fault in ("truncated", "malformed"):
            whole = json.dumps(content).encode()
            content = whole[: len(whole) // 2] if fault == "truncated" else whole.replace(b":", b";", 3)
        return status, content, []


def here(answer=None, manner=None, *, keep=False):
    """A server in a thread of this process."""
    return Server(answer, manner, keep=keep)


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


def pictures(message):
    """The pictures of a message: file, media type and detail of each."""
    if isinstance(message["content"], str):
        return []
    found = []
    for part in message["content"]:
        if part["type"] == "image_url":
            media, _, data = part["image_url"]["url"].partition(";base64,")
            found.append((base64.b64decode(data, validate=True), media, part["image_url"]["detail"]))
    return found


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


truthful = in_turn
"""A well-formed reply: it repeats what it was told and goes through the joints in the order listed."""


def stubborn(request):
    """Always the first joint of the list."""
    return replying(request, joints(request)[0])


def counted(request, times=1, answer=truthful):
    """An answer with about as many tokens as a provider would count, or so many times as many."""
    status, body = answer(request)
    read = times * sum(len(words(message)) for message in request["messages"]) // 3
    written = times * len(body["choices"][0]["message"]["content"]) // 3
    body["usage"] = {"prompt_tokens": read, "completion_tokens": written, "total_tokens": read + written}
    return status, body


ANSWERS = {"truthful": truthful, "blind": blind, "counted": counted}


def main():
    """Serve in this process until its input ends."""
    server = Server(manner=Manner(**json.loads(sys.argv[1] if len(sys.argv) > 1 else "{}")))

    async def serve():
        end = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
        await server.serve(lambda url: print(url, flush=True), end)

    asyncio.run(serve())


if __name__ == "__main__":
    main()
