"""The participants' server: requests become calls of lockprobe.people.server_state.

``GET /`` is the page. ``POST /api/open`` and ``/api/act`` take a JSON object, ``/api/withdraw`` takes nothing; all
answer with the scene to show. A refused request is answered with a status, a code and a message, is logged, and changes
nothing. A cookie that scripts cannot read holds the token that identifies a participant.

The server is uvicorn, with its own limits. A proxy in front adds what a server in the open needs: TLS, and time limits
for whoever says nothing.
"""

from __future__ import annotations

import asyncio
import errno
import json
import logging
import mimetypes
import os
import signal
import socket
import time
import traceback
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, closing, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

import uvicorn
from pydantic import Field, ValidationError
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.diary import Act, StrictModel
from lockprobe.people.experiment import Experiment, Words
from lockprobe.people.scenes import ActRefused
from lockprobe.people.server_state import Reply, ServerState
from lockprobe.people.web.address import Address
from lockprobe.studies.study import Study

STATIC = Path(__file__).with_name("static")

STATUS: Mapping[str, int] = {
    "malformed": 400,  # the body is no such JSON object, or there is no cookie
    "incomplete": 400,  # a parameter of the URL is missing, wrong, or not filled in by the recruitment platform
    "cross-site": 403,  # sent by a page of another site
    "stale": 409,  # the act is for another scene than the one shown; the page has to ask for that one
    "too-large": 413,  # the body has too many bytes
    "impossible": 422,  # the act has the right form, but this scene does not allow it
}
"""The HTTP status for each code of a refusal."""

COOKIE, SECONDS_REMEMBERED = "lockprobe", 60 * 24 * 3600
"""The cookie, and how long a browser keeps it, so that one can come back later."""

LARGEST_BODY, SECONDS_FOR_A_BODY = 16 * 1024, 20.0
"""Bytes of the largest body that is read, and the time for one to arrive."""

SECONDS_TO_FINISH, _SECONDS_IDLE = 10, 30
"""Time for requests that are under way when the server stops, and how long a connection stays open after an answer."""

_QUEUE = 2048
"""Connections that wait to be accepted; the operating system may allow fewer."""

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

_log = logging.getLogger(__name__)
"""What is refused or fails, a line each, on standard error."""

Word = Annotated[str, Field(max_length=200)]


class _Open(StrictModel):
    """``platform`` are the parameters of the URL of the page. The experimenter chooses which of them are kept."""

    platform: Annotated[dict[Word, Word], Field(max_length=40)] = Field(default_factory=dict)


class _Done(_Open):
    turn: Annotated[int, Field(ge=0, le=10**9)]
    act: Act


Body = TypeVar("Body", bound=StrictModel)


async def _body(request: Request, kind: type[Body]) -> Body:
    """What a page sent.

    Raises:
        ActRefused: If it is large or slow, or no such JSON object.
    """
    body = b""
    try:
        async with asyncio.timeout(SECONDS_FOR_A_BODY):
            async for part in request.stream():
                body += part
                if len(body) > LARGEST_BODY:
                    raise ActRefused("too-large", f"a body has at most {LARGEST_BODY} bytes")
        return kind.model_validate_json(body)
    except (ValidationError, TimeoutError, ClientDisconnect):
        raise ActRefused("malformed", "the body is no such JSON object, or did not arrive") from None


def _refusal(scope: Scope, error: Exception, texts: Mapping[str, Any]) -> Response:
    """The answer to a request that is refused or failed. What was sent is not logged."""
    match error:
        case ActRefused(code=code):
            status, said = STATUS[code], str(error)
            more = said if code == "incomplete" else ""  # which parameter was wrong, and not what it held
        case HTTPException():
            status, code, said, more = error.status_code, "unknown", error.detail, ""
        case _:
            last = traceback.extract_tb(error.__traceback__)[-1]
            more = f"{type(error).__name__} at {'/'.join(last.filename.split('/')[-2:])}:{last.lineno}"
            status, code, said = 500, "broken", "something went wrong here; please try again"
    path = scope.get("raw_path", b"").decode("ascii", "replace")[:100]
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    _log.error("%s", printable(f"{now} {status} {code} {scope['method'][:10]} {path} {more}".rstrip()))
    words = {"words": texts} if scope["path"] == "/api/open" else {}  # a page that is refused has none yet
    return JSONResponse({"error": code, "message": said, **words}, status)


def _check_sender(scope: Scope, address: Address) -> None:
    """Refuse a request to another host, or one that changes something and is sent by another page.

    The Host header has to be a name of this server with its port, which Starlette's ``TrustedHostMiddleware`` ignores.
    Proxy headers are not trusted, since any client can set them.
    """
    headers = Headers(scope=scope)
    if len(headers.getlist("host")) != 1 or headers["host"].lower() not in address.hosts:
        raise ActRefused("cross-site", "this server does not accept that host name; see --public-url and --allow-host")
    if scope["method"] not in ("GET", "HEAD", "OPTIONS") or scope["path"].startswith("/api/"):
        # browsers say which page sent a request, and no page can forge it; others need not
        origins, sites = headers.getlist("origin"), headers.getlist("sec-fetch-site")
        if not (set(origins) <= address.origins and set(sites) <= {"same-origin"}):
            raise ActRefused("cross-site", "only the study's own page can do that")
    if "transfer-encoding" in headers and "content-length" in headers:
        raise ActRefused("malformed", "a body of two lengths")  # where a proxy could read another one


def _guarded(app: ASGIApp, address: Address, texts: Mapping[str, Any]) -> ASGIApp:
    """An application that looks at who sends each request, and puts the security headers on each answer."""

    async def guard(scope: Scope, receive: Receive, send: Send) -> None:
        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(SECURITY_HEADERS)
                # browsers keep the files of the page and ask for them again, so that a new release is seen at once
                headers.setdefault("cache-control", "no-store" if scope["path"].startswith("/api/") else "no-cache")
            await send(message)

        if scope["type"] == "http":
            try:
                _check_sender(scope, address)
            except ActRefused as error:
                await _refusal(scope, error, texts)(scope, receive, sent)
            else:
                await app(scope, receive, sent)

    return guard


def application(state: ServerState, words: Words, address: Address) -> ASGIApp:
    """The application of the page, with its guard."""
    texts = words.model_dump(include={"language", "direction", "title", "page"})  # all others come with their scenes
    mimetypes.add_type("text/javascript", ".js")  # whatever a system says

    def shown(reply: Reply, **more: object) -> Response:
        scene, known = reply.scene, reply._asdict() | more
        token = known.pop("token")
        answer = JSONResponse(known)
        if scene["kind"] == "closed" and scene["why"] in ("declined", "withdrawn"):
            answer.delete_cookie(COOKIE, httponly=True, samesite="strict")  # nothing is kept of them, here or there
            return answer
        answer.set_cookie(COOKIE, token, SECONDS_REMEMBERED, secure=address.secure, httponly=True, samesite="strict")
        return answer

    async def entered(request: Request) -> Response:
        asked = await _body(request, _Open)
        return shown(await state.enter(request.cookies.get(COOKIE), asked.platform), words=texts)

    async def act(request: Request) -> Response:
        asked, token = await _body(request, _Done), request.cookies.get(COOKIE)
        return shown(await state.act(token, asked.turn, asked.act, asked.platform))

    async def withdraw(request: Request) -> Response:
        return shown(await state.withdraw(request.cookies.get(COOKIE)))

    async def refused(request: Request, error: Exception) -> Response:
        return _refusal(request.scope, error, texts)

    inner = Starlette(
        routes=[
            Route("/api/open", entered, methods=["POST"]),
            Route("/api/act", act, methods=["POST"]),
            Route("/api/withdraw", withdraw, methods=["POST"]),
            Mount("/", StaticFiles(directory=STATIC, html=True)),
        ],
        exception_handlers=dict.fromkeys((ActRefused, HTTPException, Exception), refused),
    )
    return _guarded(GZipMiddleware(inner, minimum_size=1000), address, texts)


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 takes any free port."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        found = socket.create_server(address, family=family, backlog=_QUEUE)
    except (OSError, UnicodeError) as error:
        if isinstance(error, socket.gaierror | UnicodeError) or error.errno == errno.EADDRNOTAVAIL:
            raise BadValue("host", host, "a name or IP address of this machine") from None
        raise BadValue("port", port, f"a free port of {host} ({os.strerror(error.errno or 0)})") from None
    found.setblocking(False)
    return found


@asynccontextmanager
async def running(app: ASGIApp, listening: socket.socket, *, seconds_to_finish: int) -> AsyncIterator[None]:
    """An application that answers requests on a socket; those under way at the end have ``seconds_to_finish``."""
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            http="h11",
            ws="none",
            lifespan="off",
            log_config=None,
            log_level="critical",  # what it says of an error could repeat what was sent
            access_log=False,
            proxy_headers=False,
            server_header=False,
            date_header=False,
            timeout_keep_alive=_SECONDS_IDLE,
            backlog=_QUEUE,
            timeout_graceful_shutdown=seconds_to_finish,
        )
    )
    server.capture_signals = nullcontext  # type: ignore[method-assign,assignment] # its caller handles them
    task = asyncio.create_task(server.serve(sockets=[listening]))
    try:
        yield
    finally:
        server.should_exit = True
        await task


@contextmanager
def stop_signals() -> Iterator[asyncio.Event]:
    """An event that Ctrl-C and SIGTERM set."""
    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    for name in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(name, stopped.set)
    try:
        yield stopped
    finally:
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.remove_signal_handler(name)


@asynccontextmanager
async def opened(
    directory: Path, study: Study, experiment: Experiment, words: Words, address: Address
) -> AsyncIterator[tuple[Address, ServerState]]:
    """A server that participants can use: its address and state. On exit it finishes the requests under way."""
    page = str(json.loads((STATIC / "page.json").read_bytes())["version"])
    with closing(listen(address.host, address.port)) as listening:
        address = replace(address, port=listening.getsockname()[1])
        async with (
            ServerState.open(directory, study, experiment, words, page=page) as state,
            running(application(state, words, address), listening, seconds_to_finish=SECONDS_TO_FINISH),
        ):
            yield address, state
