"""The client for language models: one request, one reply, by HTTP.

All waiting is here, and counted. A failed attempt is made again after a pause that doubles from
:attr:`lockprobe.agents.llm.settings.Access.pause` up to a minute, or as long as the server asks for. A provider may
charge for attempts to which no reply came, so every attempt is announced before it is made.
"""

from __future__ import annotations

import asyncio
import random
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any
from urllib.request import getproxies

import httpx2 as httpx

from lockprobe.agents.llm.answer import NoReply, read_answer
from lockprobe.agents.llm.servers import Server, request_body
from lockprobe.agents.llm.settings import Access, Model
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, ModelFault
from lockprobe.foundation.redaction import without_secrets
from lockprobe.trial.model_call import Call, Usage

LARGEST_ANSWER = 1 << 24
"""The most bytes of a decompressed answer: 16 MiB. Typical answers have a few thousand."""

LONGEST_OBEYED = 600.0
"""The longest wait in seconds at a server's request; a run does not wait for hours."""


class ModelClient:
    """An open client of one model.

    Attributes:
        model: What is asked.
        server: Where it is served.
        slots: Free slots for concurrent requests; each request holds one.
    """

    def __init__(self, model: Model, access: Access) -> None:
        self.model, self.server, self._access = model, Server.of(model.name), access
        self._idle: list[httpx.AsyncClient] = []
        self.slots = asyncio.Semaphore(access.connections)
        proxies = getproxies()
        try:
            self._url = httpx.URL(self.server.url)
            secure = any(url.startswith("https:") for url in (self.server.url, *proxies.values()))
            self._trust = httpx.create_ssl_context(secure)  # with certificates it takes a tenth of a second
            self._open()
        except (ImportError, OSError, ValueError, httpx.InvalidURL) as error:
            given = without_secrets(f"proxies {proxies}: {error}")
            raise BadValue("network", given, "proxies and certificates in the environment that can be used") from None

    def _open(self) -> None:
        timeout = httpx.Timeout(None, connect=self._access.connect)
        self._idle.append(httpx.AsyncClient(headers=self.server.headers, verify=self._trust, timeout=timeout))

    async def ask(
        self,
        asked: Call,
        messages: Sequence[Message],
        schema: dict[str, object],
        again: Callable[[Call], Awaitable[None]] | None = None,
    ) -> Call:
        """Send a conversation and wait for a reply of the form ``schema``. The caller holds one of :attr:`slots`.

        The call comes back with its reply, or with the provider's error if there is none after all retries. ``again``
        is called with the account so far before a request is made again; what it raises ends it.
        """
        content = request_body(self.server, self.model, messages, schema)
        names: Any = schema.get("required", ()) if self.model.settings.schema != "none" else ()
        began, failed = time.perf_counter(), asked
        while True:
            if again is not None and failed is not asked:
                await again(failed)
            try:
                came = await self._once(content)
                return read_answer(failed, time.perf_counter() - began, *came, names)
            except NoReply as none:
                failed = replace(
                    failed,
                    retries=failed.retries + 1,
                    unanswered=failed.unanswered + (none.charged and none.usage == Usage()),
                    usage=failed.usage + none.usage,
                )
                wait, tried = none.wait or 0.0, f" (tried {failed.retries} times)" if failed.retries > 1 else ""
                if wait > LONGEST_OBEYED or not none.again or failed.retries > self._access.retries:
                    tried = f"; it asks to be left alone for {wait:.0f} s" if wait > LONGEST_OBEYED else tried
                    error, seconds = str(ModelFault(f"{none}{tried}")), time.perf_counter() - began
                    return replace(failed, retries=failed.retries - 1, error=error, seconds=seconds)
                if none.wait is None:
                    await self.pause(failed.retries)
                await asyncio.sleep(wait * random.uniform(1, 1.25))  # noqa: S311 - no secret

    async def pause(self, times: int) -> None:
        """Wait before a request is made again that has failed, or had no usable reply, so many times."""
        if times:
            pause = min(60.0, self._access.pause * 2.0 ** min(times - 1, 30))
            await asyncio.sleep(pause * random.uniform(0.75, 1.25))  # noqa: S311 - no secret

    async def _once(self, content: bytes) -> tuple[int, Mapping[str, str], bytes]:
        """One attempt.

        A connection is taken by one request at a time, and each has a client of its own: a pool looks at all its
        connections whenever a request begins or ends, which with a hundred of them costs more than the request.
        """
        if not self._idle:
            self._open()
        http = self._idle.pop()
        try:
            async with (
                asyncio.timeout(self._access.timeout),
                http.stream("POST", self._url, content=content) as answer,
            ):
                packed = answer.headers.get("content-encoding", "identity").lower()
                if packed not in ("identity", "gzip", "deflate"):  # others unpack so much at once that no limit helps
                    said = f"an answer compressed with {packed[:40]}, which was not requested"
                    raise NoReply(f"the provider answered with {said}", again=False, charged=True)
                parts, size = [], 0
                async for part in answer.aiter_bytes():
                    parts.append(part)
                    if (size := size + len(part)) > LARGEST_ANSWER:
                        said = f"an answer of more than {LARGEST_ANSWER} bytes"
                        raise NoReply(f"the provider answered with {said}", again=False, charged=True)
                return answer.status_code, answer.headers, b"".join(parts)
        except TimeoutError:
            raise NoReply(f"no reply within {self._access.timeout:g} s", charged=True) from None
        except (httpx.HTTPError, OSError, OverflowError) as error:
            cause: BaseException = error
            while (behind := cause.__cause__ or cause.__context__) is not None:
                cause = behind
            said = " ".join(without_secrets(str(cause) or type(error).__name__).split())
            unsent = isinstance(error, httpx.ConnectError | httpx.ConnectTimeout | httpx.PoolTimeout | OverflowError)
            raise NoReply(f"no connection to the provider: {said}", charged=not unsent) from error
        finally:
            self._idle.append(http)

    async def aclose(self) -> None:
        """Close the connections, when no request is on its way."""
        for http in self._idle:
            await http.aclose()
