"""The participants' page over HTTP: requests become calls of :class:`lockprobe.people.server_state.ServerState`.

``GET /`` is the page. ``POST /api/open``, ``/api/act`` and ``/api/withdraw`` take a JSON object and answer with the
scene that is to be shown; what cannot be done is answered with a status, a code and a message, and changes nothing.
The token that says which participant a browser is stands in a cookie that no script can read.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from http import HTTPStatus
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Act, Agree
from lockprobe.people.server_state import Reply, ServerState
from lockprobe.people.texts import Words, page_texts
from lockprobe.web.address import Address
from lockprobe.web.admin import AdminApi
from lockprobe.web.files import Files
from lockprobe.web.guard import Guard, body_of
from lockprobe.web.log import LOGGED, ServerLog
from lockprobe.web.rate_limit import JoinLimit, whence
from lockprobe.web.refusals import STATUS, RequestRefused, refusal, refused

__all__ = ["COOKIE", "application"]

COOKIE = "lockprobe"

SECONDS_REMEMBERED = 60 * 24 * 3600
"""How long a browser keeps its cookie, so that one can come back later."""

_LONGEST_LEASE = 200

Word = Annotated[str, Field(max_length=200)]
Platform = Annotated[dict[Word, Word], Field(max_length=40)]
"""The parameters of the URL under which the page was opened. Which are kept is the experimenter's choice."""


class _Body(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class _Open(_Body):
    platform: Platform = {}


class _Done(_Body):
    lease: Annotated[str, Field(max_length=_LONGEST_LEASE)]
    turn: Annotated[int, Field(ge=0, le=10**9)]
    act: Act
    platform: Platform = {}


class _Withdraw(_Body):
    lease: Annotated[str, Field(max_length=_LONGEST_LEASE)]


def application(state: ServerState, words: Words, address: Address, log: ServerLog, *, admin: AdminApi) -> ASGIApp:
    """The whole as an ASGI application.

    Args:
        state: Who is there, and what they do.
        words: What they read.
        address: How browsers get here.
        log: Where refusals are written down.
        admin: The experimenter's page.
    """
    texts = _of_the_page(words)
    desk = _ParticipantApi(state, texts, address)
    files = Files()

    def page(name: str) -> Callable[[Request], Response]:
        return lambda request: files.answer(name, request)

    routes = [
        Route("/", _answering(page("index.html"))),
        Route("/static/{name}", _answering(lambda request: files.answer(request.path_params["name"], request))),
        Route("/api/open", desk.open, methods=["POST"]),
        Route("/api/act", desk.act, methods=["POST"]),
        Route("/api/withdraw", desk.withdraw, methods=["POST"]),
        Route("/admin", _answering(page("admin.html"))),
        Route("/api/admin/progress", admin.progress),
        Route("/api/admin/find", admin.find, methods=["POST"]),
        Route("/api/admin/data", admin.data),
        Route("/api/admin/data/{name}", admin.data),
        Route("/api/admin/withdraw", admin.withdraw, methods=["POST"]),
        Route("/healthz", _answering(lambda request: PlainTextResponse("ok"))),
        Route("/robots.txt", _answering(lambda request: PlainTextResponse("User-agent: *\nDisallow: /\n"))),
        Route("/favicon.ico", _answering(lambda request: Response(status_code=HTTPStatus.NO_CONTENT))),
    ]
    told = _Refusals(log, texts)
    inner = Starlette(
        routes=routes,
        exception_handlers={
            RequestRefused: told.refused,
            ActRefused: told.refused,
            HTTPException: told.no_route,
            Exception: told.broken,
        },
    )
    inner.router.redirect_slashes = False
    return Guard(GZipMiddleware(inner, minimum_size=1000, compresslevel=6), address, log)


def _answering(answer: Callable[[Request], Response]) -> Callable[[Request], object]:
    """Answered in the event loop: nothing here waits for a disk, and a thread would cost more."""

    async def answered(request: Request) -> Response:
        return answer(request)

    return answered


def _of_the_page(words: Words) -> Mapping[str, object]:
    """The texts that the page needs from the beginning; others come with their scenes."""
    return {
        "language": words.language,
        "direction": words.direction,
        "title": words.title,
        "consent": words.consent.model_dump(include={"agree", "decline"}),
        "debrief": words.debrief.model_dump(include={"completion", "code"}),
        "page": page_texts(words),
    }


class _ParticipantApi:
    """What participants can ask for."""

    def __init__(self, state: ServerState, words: Mapping[str, object], address: Address) -> None:
        self._state, self._words = state, words
        self._secure, self._proxied = address.secure, bool(address.public)
        self._joins = JoinLimit(state.experiment.joins_per_minute)

    async def open(self, request: Request) -> Response:
        """A page was loaded."""
        asked = await body_of(request, _Open)
        shown = await self._state.enter(request.cookies.get(COOKIE), asked.platform)
        return self._answer(shown, words=self._words)

    async def act(self, request: Request) -> Response:
        """Something was done in a scene."""
        asked = await body_of(request, _Done)
        if isinstance(asked.act, Agree) and asked.act.agreed:
            return self._answer(await self._join(request, asked))
        token = request.cookies.get(COOKIE)
        return self._answer(await self._state.act(token, asked.lease, asked.turn, asked.act, asked.platform))

    async def _join(self, request: Request, asked: _Done) -> Reply:
        """Somebody agrees to take part. Who joins is counted by address, and who guesses codes."""
        address, counted = whence(request, proxied=self._proxied), False
        self._joins.reserve(address)
        try:
            token = request.cookies.get(COOKIE)
            shown = await self._state.act(token, asked.lease, asked.turn, asked.act, asked.platform)
            counted = shown.identity is not None
        except ActRefused as error:
            counted = error.code == "wrong-code"
            raise
        finally:
            if not counted:
                self._joins.give_back(address)
        return shown

    async def withdraw(self, request: Request) -> Response:
        """Somebody stops, and has everything deleted."""
        asked = await body_of(request, _Withdraw)
        return self._answer(await self._state.withdraw(request.cookies.get(COOKIE), asked.lease))

    def _answer(self, shown: Reply, **more: object) -> Response:
        scene = shown.scene.model_dump(mode="json")
        answer = JSONResponse(
            {
                "lease": shown.lease,
                "turn": shown.turn,
                "scene": scene,
                "withdraw": shown.may_withdraw,
                "participant": shown.identity,
                **more,
            }
        )
        if scene["kind"] == "closed" and scene["why"] in ("declined", "withdrawn"):
            _forget(answer)  # nothing is kept of them, here or there
        else:
            answer.set_cookie(
                COOKIE, shown.token, SECONDS_REMEMBERED, secure=self._secure, httponly=True, samesite="strict"
            )
        return answer


def _forget(answer: Response) -> None:
    answer.delete_cookie(COOKIE, httponly=True, samesite="strict")


class _Refusals:
    """What is answered, and written down, where something cannot be done."""

    def __init__(self, log: ServerLog, words: Mapping[str, object]) -> None:
        self._log, self._words = log, words

    async def refused(self, request: Request, error: Exception) -> Response:
        """The request is refused."""
        assert isinstance(error, RequestRefused | ActRefused)
        why = str(error) if error.code == "incomplete" else ""  # which parameter, and not what it held
        self._log.refused(request.scope, STATUS[error.code], error.code, why)
        more = {"words": self._words} if request.url.path == "/api/open" else {}  # the page has none yet
        answer = refused(error, **more)
        if error.code == "forged":
            if request.url.path.startswith("/api/admin/"):
                answer.headers["www-authenticate"] = "Bearer"
            else:
                _forget(answer)  # a cookie of another study; the page begins anew
        return answer

    async def no_route(self, request: Request, error: Exception) -> Response:
        """There is nothing at that path, or not for that method."""
        assert isinstance(error, HTTPException)
        self._log.refused(request.scope, error.status_code, "unknown")
        answer = refusal("unknown", HTTPStatus(error.status_code).phrase, error.status_code)
        answer.headers.update(error.headers or {})
        return answer

    async def broken(self, request: Request, error: Exception) -> Response:
        """Something went wrong here. What was being done is on disk or not done; the page asks again."""
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{type(error).__name__} at {'/'.join(last.filename.split('/')[-2:])}:{last.lineno}"
        self._log.refused(request.scope, HTTPStatus.INTERNAL_SERVER_ERROR, "broken", where)
        error.add_note(LOGGED)
        return refusal("broken", "something went wrong here; please try again", HTTPStatus.INTERNAL_SERVER_ERROR)
