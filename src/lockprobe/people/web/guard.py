"""Checks on every request (host, origin, size, JSON), and the security headers of every answer.

The Host header has to be a name of this server with its port, which Starlette's ``TrustedHostMiddleware`` ignores. A
POST has to come from a page of this server, be JSON, and be small. Proxy headers are not trusted, since any client can
set them.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lockprobe.people.refusals import STATUS, ActRefused
from lockprobe.people.web.address import Address

LARGEST_BODY, AT_ONCE, SECONDS_FOR_A_BODY = 16 * 1024, 1024, 20.0
"""Bytes of the largest body that is read, how many are read at once, and the time for one to arrive."""

SECURITY_HEADERS: Mapping[str, str] = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=(), microphone=()",
    "x-robots-tag": "noindex",
}
"""On every answer. No script but the page's own runs, nothing is loaded from elsewhere, no other page frames it."""


class Guard:
    """Checks requests before the application sees them.

    Args:
        app: The application.
        address: The names of the server.
        refused: Called with each request that is refused, its status and its code.
    """

    def __init__(self, app: ASGIApp, address: Address, refused: Callable[[Scope, int, str], None]) -> None:
        self._app, self._refused = app, refused
        self._hosts, self._origins = address.hosts, address.origins
        self._reading = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(SECURITY_HEADERS)
                headers.setdefault("cache-control", "no-store")
            await send(message)

        if scope["type"] != "http":
            return
        try:
            headers = Headers(scope=scope)
            self._check(scope, headers)
            body = await self._body(headers, receive)
        except ActRefused as error:
            self._refused(scope, STATUS[error.code], error.code)
            answer = JSONResponse({"error": error.code, "message": str(error)}, STATUS[error.code])
            await answer(scope, receive, sent)
            return
        except ConnectionError:
            return  # nobody is there to be answered
        given: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

        async def next_message() -> Message:
            return given.pop() if given else await receive()

        await self._app(scope, next_message, sent)

    def _check(self, scope: Scope, headers: Headers) -> None:
        method = scope["method"]
        if len(scope["raw_path"]) + sum(len(name) + len(value) for name, value in scope["headers"]) > LARGEST_BODY:
            raise ActRefused("too-large", f"the head of a request has at most {LARGEST_BODY} bytes")
        if len(headers.getlist("host")) != 1 or headers["host"].lower() not in self._hosts:
            why = "this server does not accept that host name; see --public-url and --allow-host"
            raise ActRefused("cross-site", why)
        if method not in ("GET", "HEAD", "OPTIONS") or scope["path"].startswith("/api/"):
            # browsers say which page sent a request, and no page can forge it; others need not
            origins, sites = headers.getlist("origin"), headers.getlist("sec-fetch-site")
            if not (set(origins) <= self._origins and set(sites) <= {"same-origin"}):
                raise ActRefused("cross-site", "only the study's own page can do that")
        if method == "POST":
            kind, _, parameters = headers.get("content-type", "").lower().partition(";")
            if kind.strip() != "application/json" or parameters.strip() not in ("", "charset=utf-8"):
                raise ActRefused("not-json", "the body must be JSON")
            if headers.get("content-encoding", "identity").lower() != "identity":
                raise ActRefused("not-json", "a body must not be compressed")
            if "transfer-encoding" in headers and "content-length" in headers:
                raise ActRefused("malformed", "a body of two lengths")  # where a proxy could read another one

    async def _body(self, headers: Headers, receive: Receive) -> bytes:
        """The body of a request.

        Raises:
            ActRefused: If it is large or slow, or too many are being read.
            ConnectionError: If the client has gone.
        """
        if self._reading >= AT_ONCE:
            raise ActRefused("busy", "too many requests at once; try again")
        stated = headers.get("content-length", "0")
        body, more = b"", True
        self._reading += 1
        try:
            async with asyncio.timeout(SECONDS_FOR_A_BODY):
                while more:
                    if len(body) > LARGEST_BODY or (stated.isdecimal() and int(stated[:9]) > LARGEST_BODY):
                        raise ActRefused("too-large", f"a body has at most {LARGEST_BODY} bytes")
                    message = await receive()
                    if message["type"] == "http.disconnect":
                        raise ConnectionError
                    body, more = body + message.get("body", b""), message.get("more_body", False)
        except TimeoutError:
            raise ActRefused("malformed", "the body did not arrive") from None
        finally:
            self._reading -= 1
        if len(body) > LARGEST_BODY:
            raise ActRefused("too-large", f"a body has at most {LARGEST_BODY} bytes")
        return body
