"""The HTTP API of the participants' page: requests become calls of lockprobe.people.server_state.

``GET /`` is the page. ``POST /api/open``, ``/api/act`` and ``/api/withdraw`` take a JSON object and answer with the
scene to show. A refused request is answered with a status, a code and a message, and changes nothing. A cookie that
scripts cannot read holds the token that identifies a participant.
"""

from __future__ import annotations

import json
import mimetypes
import traceback
from collections.abc import Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import Field, ValidationError
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, ExceptionHandler, Scope

from lockprobe.foundation.errors import BadFile
from lockprobe.people.refusals import STATUS, ActRefused
from lockprobe.people.responses import Act
from lockprobe.people.scenes import StrictModel
from lockprobe.people.server_state import PageReply, ServerState
from lockprobe.people.texts import Words
from lockprobe.people.web.address import Address
from lockprobe.people.web.guard import Guard
from lockprobe.people.web.log import LOGGED, ServerLog

STATIC = Path(__file__).with_name("static")

COOKIE = "lockprobe"

SECONDS_REMEMBERED = 60 * 24 * 3600
"""How long a browser keeps its cookie, so that one can come back later."""

Word = Annotated[str, Field(max_length=200)]
Platform = Annotated[dict[Word, Word], Field(max_length=40)]
"""The parameters of the URL under which the page was opened. The experimenter chooses which of them are kept."""


class _Open(StrictModel):
    platform: Platform = Field(default_factory=dict)


class _Withdraw(StrictModel):
    lease: Word


class _Done(_Withdraw):
    turn: Annotated[int, Field(ge=0, le=10**9)]
    act: Act
    platform: Platform = Field(default_factory=dict)


Body = TypeVar("Body", bound=StrictModel)


async def _body(request: Request, kind: type[Body]) -> Body:
    try:
        return kind.model_validate_json(await request.body())
    except ValidationError:
        raise ActRefused("malformed", "the body is no such JSON object") from None


def page_version() -> str:
    """The version of the participants' page, for the record.

    Raises:
        BadFile: If the page was not built.
    """
    path = STATIC / "page.json"
    try:
        return str(json.loads(path.read_bytes())["version"])
    except (OSError, ValueError, KeyError, TypeError):
        raise BadFile(path, "names no version of the page; was it built?") from None


class _Files(StaticFiles):
    """The files of the page. They are kept by browsers and asked for again, so that a new release is seen at once."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        if scope["path"].endswith("/") and scope["path"] != "/":
            raise HTTPException(HTTPStatus.NOT_FOUND)
        answer = await super().get_response("index.html" if scope["path"] == "/" else path, scope)
        answer.headers["cache-control"] = "no-cache"
        return answer


def _forget(answer: Response) -> Response:
    answer.delete_cookie(COOKIE, httponly=True, samesite="strict")
    return answer


def application(state: ServerState, words: Words, address: Address, log: ServerLog) -> ASGIApp:
    """The application of the page, with its guard."""
    texts = {
        **words.model_dump(include={"language", "direction", "title", "page"}),
        "consent": words.consent.model_dump(include={"agree", "decline"}),
        "debrief": words.debrief.model_dump(include={"completion", "code"}),
    }  # all others come with their scenes
    mimetypes.add_type("text/javascript", ".js")  # whatever a system says

    def shown(reply: PageReply, **more: object) -> Response:
        scene = reply.scene.model_dump(mode="json")
        answer = JSONResponse(
            {
                "lease": reply.lease,
                "turn": reply.turn,
                "scene": scene,
                "withdraw": reply.identity is not None,
                "participant": reply.identity,
                "progress": reply.progress,
                **more,
            }
        )
        if scene["kind"] == "closed" and scene["why"] in ("declined", "withdrawn"):
            return _forget(answer)  # nothing is kept of them, here or there
        answer.set_cookie(
            COOKIE, reply.token, SECONDS_REMEMBERED, secure=address.secure, httponly=True, samesite="strict"
        )
        return answer

    async def opened(request: Request) -> Response:
        asked = await _body(request, _Open)
        return shown(await state.enter(request.cookies.get(COOKIE), asked.platform), words=texts)

    async def act(request: Request) -> Response:
        asked, token = await _body(request, _Done), request.cookies.get(COOKIE)
        return shown(await state.act(token, asked.lease, asked.turn, asked.act, asked.platform))

    async def withdraw(request: Request) -> Response:
        asked = await _body(request, _Withdraw)
        return shown(await state.withdraw(request.cookies.get(COOKIE), asked.lease))

    async def alive(request: Request) -> Response:
        return PlainTextResponse("ok")

    files = _Files(directory=STATIC)
    inner = Starlette(
        routes=[
            Route("/healthz", alive),
            Route("/api/open", opened, methods=["POST"]),
            Route("/api/act", act, methods=["POST"]),
            Route("/api/withdraw", withdraw, methods=["POST"]),
            Mount("/static", files),
            Route("/", files),
        ],
        exception_handlers=_refusals(log, texts),
    )
    inner.router.redirect_slashes = False
    return Guard(GZipMiddleware(inner, minimum_size=1000, compresslevel=6), address, log.refused)


def _refusals(log: ServerLog, texts: Mapping[str, object]) -> Mapping[Any, ExceptionHandler]:
    """What answers and logs requests that are refused or fail."""

    async def refused(request: Request, error: Exception) -> Response:
        assert isinstance(error, ActRefused)
        why = str(error) if error.code == "incomplete" else ""  # which parameter, and not what it held
        log.refused(request.scope, STATUS[error.code], error.code, why)
        more = {"words": texts} if request.url.path == "/api/open" else {}  # the page has none yet
        answer = JSONResponse({"error": error.code, "message": str(error), **more}, STATUS[error.code])
        return _forget(answer) if error.code == "forged" else answer  # a cookie of another study; the page starts again

    async def no_route(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        log.refused(request.scope, error.status_code, "unknown")
        phrase = {"error": "unknown", "message": HTTPStatus(error.status_code).phrase}
        return JSONResponse(phrase, error.status_code, dict(error.headers or {}))

    async def broken(request: Request, error: Exception) -> Response:
        """The act is on disk or has not been done; the page asks again."""
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{type(error).__name__} at {'/'.join(last.filename.split('/')[-2:])}:{last.lineno}"
        log.refused(request.scope, HTTPStatus.INTERNAL_SERVER_ERROR, "broken", where)
        error.add_note(LOGGED)
        return JSONResponse({"error": "broken", "message": "something went wrong here; please try again"}, 500)

    return {ActRefused: refused, HTTPException: no_route, Exception: broken}
