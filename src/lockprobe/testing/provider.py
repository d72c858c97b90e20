"""A fake model provider on loopback: scripted chat completions, and a log of the requests.

::

    with ScriptedProvider(['{"last_action": "none", "hypothesis": "", "joint": "A"}']) as provider:
        trial = lockprobe.run_trial(agent=provider.agent, condition=[Mine()], max_steps=1)
    assert "my sentence" in words(provider.requests[0]["messages"][0])

It uses only the standard library.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import threading
from collections.abc import Callable, Coroutine, Iterable, Mapping
from types import TracebackType
from typing import Any, Self

Request = dict[str, Any]
"""The body of a request."""

Answer = str | Mapping[str, Any] | tuple[int, Any]
"""What a model says, as text or as the object that the text holds; or a status and a body, as they are sent."""

_LARGEST = 2**26
"""Bytes of a request, at most."""


class ScriptedProvider:
    """Answers chat completions from a list or by a function, and keeps the requests.

    It serves from a thread while the ``with`` block runs. Meanwhile the environment holds its address, so that
    :attr:`agent` finds it.

    Args:
        answers: One per request, in order; or a function of a request; or nothing, for :func:`in_turn`. An exception in
            the function ends the request and is raised again at the end of the block.
        name: The agent is ``llm:openai-api/NAME/model``; a word in lower case.
        keep: Whether requests are kept.

    Attributes:
        url: Base URL, once it runs.
        requests: The body of every request, in order, where they are kept.
        headers: Every header line received, each once.
    """

    def __init__(
        self,
        answers: Iterable[Answer] | Callable[[Request], Answer] | None = None,
        *,
        name: str = "scripted",
        keep: bool = True,
    ) -> None:
        self._answers = in_turn if answers is None else answers if callable(answers) else _listed(list(answers))
        self._name, self._keep = name, keep
        self.url = ""
        self.requests: list[Request] = []
        self.headers: set[str] = set()
        self._open: set[asyncio.StreamWriter] = set()
        self._raised: Exception | None = None
        self._before: dict[str, str | None] = {}

    @property
    def agent(self) -> str:
        """The spec of the agent that asks it."""
        return f"llm:openai-api/{self._name}/model"

    def __enter__(self) -> Self:
        self._loop = asyncio.new_event_loop()
        ready, self._end = threading.Event(), self._loop.create_future()
        serving = self.serve(lambda url: ready.set(), self._end)
        self._thread = threading.Thread(target=self._run, args=(serving,), daemon=True)
        self._thread.start()
        ready.wait()
        here = {f"{self._name.upper()}_BASE_URL": self.url, f"{self._name.upper()}_API_KEY": "nobody-asks-for-one"}
        self._before = {name: os.environ.get(name) for name in here}
        os.environ.update(here)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for name, value in self._before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
        self._loop.call_soon_threadsafe(self._end.set_result, None)
        self._thread.join()
        if self._raised is not None and error is None:
            raise self._raised

    def _run(self, serving: Coroutine[Any, Any, None]) -> None:
        """Serve in a thread, because the caller's thread may run an event loop, as a notebook's does."""
        self._loop.run_until_complete(serving)
        self._loop.run_until_complete(_tidy())
        self._loop.close()

    async def serve(self, started: Callable[[str], None], until: asyncio.Future[Any]) -> None:
        """Serve on a free port until ``until`` is done; ``started`` is called with the base URL."""
        server = await asyncio.start_server(self._connection, "127.0.0.1", 0, limit=_LARGEST, backlog=1024)
        self.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/v1"
        started(self.url)
        await until
        server.close()
        for writer in list(self._open):
            writer.transport.abort()
        await asyncio.sleep(0.01)

    def answer(self, request: Request) -> tuple[int, Any]:
        """Status and body for a request."""
        try:
            answer = self._answers(request)
        except (AssertionError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            self._raised = self._raised or error
            return failure(400, f"{type(error).__name__}: {error}")
        if isinstance(answer, tuple):
            return answer
        return completion(answer if isinstance(answer, str) else json.dumps(answer))

    def told(self) -> dict[str, Any]:
        """The answer to a request that asks for no completion."""
        return {"requests": len(self.requests)}

    async def answered(self, request: Request, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bool:
        """Answer one request; whether the connection stays open."""
        status, body = self.answer(request)
        send(writer, status, body)
        return True

    async def _connection(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open.add(writer)
        try:
            with contextlib.suppress(ConnectionError, asyncio.IncompleteReadError):
                while await self._exchange(reader, writer):
                    pass
        finally:
            self._open.discard(writer)
            writer.close()

    async def _exchange(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bool:
        """One request and its answer; whether the connection stays open."""
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1")
        first, *lines = head.strip().split("\r\n")
        self.headers.update(lines)
        headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines)}
        body = await reader.readexactly(int(headers.get("content-length", 0)))
        if first.startswith("GET"):
            send(writer, 200, self.told())
            return True
        request: Request = json.loads(body)
        if self._keep:
            self.requests.append(request)
        return await self.answered(request, reader, writer)


def send(
    writer: asyncio.StreamWriter, status: int, body: Any, more: Iterable[str] = (), *, midway: bool = False
) -> None:
    """Write an answer: bytes as they are, everything else as JSON.

    ``more`` are header lines. With ``midway`` half of the body is left out.
    """
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    lines = [f"HTTP/1.1 {status} x", "content-type: application/json", f"content-length: {len(content)}", *more]
    writer.write("\r\n".join([*lines, "", ""]).encode() + (content[: len(content) // 2] if midway else content))


def _listed(answers: list[Answer]) -> Callable[[Request], Answer]:
    given = iter(enumerate(answers, 1))

    def following(request: Request) -> Answer:
        number, answer = next(given, (None, ""))
        if number is None:
            raise LookupError(f"a request came after the last of {len(answers)} answers")
        return answer

    return following


async def _tidy() -> None:
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)


def completion(text: str | None, *, stop: str = "stop", refusal: str | None = None) -> tuple[int, dict[str, Any]]:
    """A successful answer with this text.

    ``stop`` is ``stop``, ``length`` or ``content_filter``; ``refusal`` is the text of a model that refuses.
    """
    message = {"role": "assistant", "content": text} | ({} if refusal is None else {"refusal": refusal})
    return 200, {
        "id": "x",
        "object": "chat.completion",
        "created": 1,
        "model": "fake",
        "choices": [{"index": 0, "message": message, "finish_reason": stop}],
        "usage": {"prompt_tokens": 11, "completion_tokens": 5, "total_tokens": 16},
    }


def failure(status: int, message: str) -> tuple[int, dict[str, Any]]:
    """An error of the provider. Lockprobe retries 429 and those from 500 on; others end a trial."""
    return status, {"error": {"message": message, "type": "error", "code": status}}


def words(message: Mapping[str, Any]) -> str:
    """The text of a message, with or without pictures."""
    content = message["content"] or ""
    return content if isinstance(content, str) else " ".join(part["text"] for part in content if part["type"] == "text")


def joints(request: Request) -> list[str]:
    """The joints in listed order, from the reply form or else from the text.

    Raises:
        ValueError: If neither names them.
    """
    with contextlib.suppress(KeyError):
        return list(_form(request)["joint"]["enum"])
    found = re.search(r"joints?: (\w+(?:, \w+)+)", words(request["messages"][0]))
    if found is None:
        raise ValueError("the request lists no joints")
    return found[1].split(", ")


def _form(request: Request) -> dict[str, Any]:
    form: dict[str, Any] = request["response_format"]["json_schema"]["schema"]["properties"]
    return form


def replying(request: Request, joint: str, hypothesis: str = "in turn") -> tuple[int, dict[str, Any]]:
    """A reply in the requested form that names a joint and repeats the last report.

    ``hypothesis`` is its statement about the box, if the form asks for one.
    """
    turn, told = _turns(request)
    last = "none" if turn == 0 else "did not move" if "did not move" in told else "moved"
    all_said = {"last_action": last, "hypothesis": hypothesis, "joint": joint}
    asked = ["last_action", "hypothesis", "joint"]
    with contextlib.suppress(KeyError):
        asked = list(_form(request))
    return completion(json.dumps({key: all_said[key] for key in asked}))


def in_turn(request: Request) -> tuple[int, dict[str, Any]]:
    """A well-formed reply that repeats the last report and names the joints in listed order."""
    listing, (turn, _) = joints(request), _turns(request)
    return replying(request, listing[turn % len(listing)])


def _turns(request: Request) -> tuple[int, str]:
    """The number of steps played and the last report; replies that could not be used do not count."""
    turn, told = 0, request["messages"][0]
    for reply, after in zip(request["messages"], request["messages"][1:], strict=False):
        if reply["role"] == "assistant" and "could not be used" not in words(after):
            turn, told = turn + 1, after
    return turn, words(told)
