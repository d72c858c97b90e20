"""Checks on every request (host, origin, size, JSON), and the security headers of every answer.

The Host header has to be a name of this server with its port. (Starlette's ``TrustedHostMiddleware`` ignores the port,
accepts a second Host header, and neither logs nor answers in JSON.) A POST has to come from a page of this server, be
JSON, and be small. Proxy headers are not trusted, since any client can set them.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import TypeVar

from pydantic import BaseModel, ValidationError
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lockprobe.people.web.address import Address
from lockprobe.people.web.log import ServerLog
from lockprobe.people.web.refusals import STATUS, RequestRefused, refused

Body = TypeVar("Body", bound=BaseModel)

LARGEST_BODY = 16 * 1024
"""Bytes of the largest body that is read."""

LARGEST_HEAD = 16 * 1024
"""Bytes of the largest head of a request, its path and headers."""

AT_ONCE = 1024
"""Bodies that are read at once."""

SECONDS_FOR_A_BODY = 20.0
"""The time for a body to arrive."""

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


async def body_of(request: Request, kind: type[Body]) -> Body:
    """The JSON body of a request as a model.

    Raises:
        RequestRefused: As ``malformed``, if it is no such object.
    """
    try:
        return kind.model_validate_json(await request.body())
    except ValidationError:
        raise RequestRefused("malformed", "the body is no such JSON object") from None


class Guard:
    """Checks requests before the application sees them, and logs those that it refuses."""

    def __init__(self, app: ASGIApp, address: Address, log: ServerLog) -> None:
        self._app, self._log = app, log
        self._hosts, self._origins = address.hosts, address.origins
        self._reading = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            return
        answer = _with_headers(send)
        try:
            _check_head(scope)
            self._check(scope["method"], scope["path"], Headers(scope=scope))
            body = await self._body(Headers(scope=scope), receive)
        except RequestRefused as error:
            self._log.refused(scope, STATUS[error.code], error.code)
            await refused(error)(scope, receive, answer)
            return
        except ConnectionError:
            return  # nobody is there to be answered
        await self._app(scope, _once(body, receive), answer)

    def _check(self, method: str, path: str, headers: Headers) -> None:
        if len(headers.getlist("host")) != 1 or headers["host"].lower() not in self._hosts:
            raise RequestRefused(
                "cross-site", "this server does not accept that host name; see --public-url and --allow-host"
            )
        if method not in ("GET", "HEAD", "OPTIONS") or path.startswith("/api/"):
            self._check_page(headers)
        if method == "POST":
            _check_body(headers)

    def _check_page(self, headers: Headers) -> None:
        """Check which page sent the request. Browsers always say so, and no page can forge it; others need not."""
        origins, sites = headers.getlist("origin"), headers.getlist("sec-fetch-site")
        if not (set(origins) <= self._origins and set(sites) <= {"same-origin"}):
            raise RequestRefused("cross-site", "only the study's own page can do that")

    async def _body(self, headers: Headers, receive: Receive) -> bytes:
        """The body of a request.

        Raises:
            RequestRefused: If it is large or slow, or too many are being read.
            ConnectionError: If the client has gone.
        """
        stated = headers.get("content-length", "0")
        if stated.isdecimal() and int(stated[:9]) > LARGEST_BODY:
            raise RequestRefused("too-large", f"a body has at most {LARGEST_BODY} bytes")
        if self._reading >= AT_ONCE:
            raise RequestRefused("busy", "too many requests at once; try again")
        self._reading += 1
        try:
            async with asyncio.timeout(SECONDS_FOR_A_BODY):
                return await _read(receive)
        except TimeoutError:
            raise RequestRefused("malformed", "the body did not arrive") from None
        finally:
            self._reading -= 1


def _check_head(scope: Scope) -> None:
    lengths = (len(name) + len(value) for name, value in scope["headers"])
    if len(scope["raw_path"]) + len(scope.get("query_string", b"")) + sum(lengths) > LARGEST_HEAD:
        raise RequestRefused("too-large", f"the head of a request has at most {LARGEST_HEAD} bytes")


def _check_body(headers: Headers) -> None:
    kind, _, parameters = headers.get("content-type", "").lower().partition(";")
    if kind.strip() != "application/json" or parameters.strip() not in ("", "charset=utf-8"):
        raise RequestRefused("not-json", "the body must be JSON")
    if "transfer-encoding" in headers and "content-length" in headers:
        raise RequestRefused("malformed", "a body of two lengths")  # where a proxy could read another than this server
    if headers.get("content-encoding", "identity").lower() != "identity":
        raise RequestRefused("not-json", "a body must not be compressed")


async def _read(receive: Receive) -> bytes:
    body, more = b"", True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ConnectionError
        body += message.get("body", b"")
        more = message.get("more_body", False)
        if len(body) > LARGEST_BODY:
            raise RequestRefused("too-large", f"a body has at most {LARGEST_BODY} bytes")
    return body


def _once(body: bytes, receive: Receive) -> Receive:
    """The body in one message, then whatever else arrives."""
    given = False

    async def next_message() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return next_message


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.update(SECURITY_HEADERS)
            headers.setdefault("cache-control", "no-store")
        await send(message)

    return sent
