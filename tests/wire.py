"""HTTP as bytes: one connection, kept, with cookies. As small as it can be, so that hundreds of them take little time."""

import asyncio
import contextlib
import json
from dataclasses import dataclass
from http.cookies import SimpleCookie
from urllib.parse import urlsplit


class Gone(Exception):
    """Nobody answers, or the connection broke before the answer was whole."""


@dataclass(frozen=True)
class Answer:
    """What came back."""

    status_code: int
    headers: dict
    content: bytes

    @property
    def text(self):
        return self.content.decode()

    def json(self):
        return json.loads(self.content)


class Wire:
    """What a browser has of a server.

    Attributes:
        cookies: By name.
        headers: Sent with every request.
        sent: All bytes that went out.
        received: All bytes that came in.
    """

    def __init__(self, url):
        parts = urlsplit(url)
        self.host, self.port, self.name = parts.hostname, parts.port, parts.netloc
        self.cookies, self.headers = {}, {}
        self.sent, self.received = [], []
        self._streams = None
        self._lock = asyncio.Lock()

    async def get(self, path, headers=None):
        return await self.request("GET", path, headers=headers)

    async def post(self, path, body=None, *, content=None, headers=None):
        content = json.dumps(body) if content is None else content
        headers = {"content-type": "application/json"} | (headers or {})
        return await self.request("POST", path, content.encode() if isinstance(content, str) else content, headers)

    async def request(self, method, path, content=b"", headers=None):
        """One request and its answer."""
        cookie = "; ".join(f"{name}={value}" for name, value in self.cookies.items())
        fields = {"host": self.name} | ({"cookie": cookie} if cookie else {}) | self.headers | (headers or {})
        if content or method == "POST":
            fields["content-length"] = str(len(content))
        head = "".join(f"{name}: {value}\r\n" for name, value in fields.items())
        async with self._lock:
            try:
                return await self._exchange(f"{method} {path} HTTP/1.1\r\n{head}\r\n".encode("latin-1") + content)
            except (OSError, asyncio.IncompleteReadError) as error:
                await self.close()
                raise Gone from error

    async def _exchange(self, request):
        if self._streams is None:
            self._streams = await asyncio.open_connection(self.host, self.port)
        reader, writer = self._streams
        self.sent.append(request)
        writer.write(request)
        await writer.drain()
        head = await reader.readuntil(b"\r\n\r\n")
        first, *lines = head.decode("latin-1").split("\r\n")
        headers = {}
        for line in filter(None, lines):
            name, _, value = line.partition(":")
            headers[name.lower()] = value.strip()
        content = await reader.readexactly(int(headers.get("content-length", 0)))
        self.received.append(head + content)
        for name, morsel in SimpleCookie(headers.get("set-cookie", "")).items():
            self.cookies[name] = morsel.value
            if morsel["max-age"] == "0":
                del self.cookies[name]
        if headers.get("connection") == "close":
            await self.close()
        return Answer(int(first.split()[1]), headers, content)

    async def close(self):
        streams, self._streams = self._streams, None
        if streams is not None:
            streams[1].close()
            with contextlib.suppress(OSError):
                await streams[1].wait_closed()
