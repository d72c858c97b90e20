"""The HTTP API of the participants' page: requests become calls of lockprobe.people.server_state.

``GET /`` is the page. ``POST /api/open``, ``/api/act`` and ``/api/withdraw`` take a JSON object and answer with the
scene to show. A refused request is answered with a status, a code and a message, and changes nothing. A cookie that
scripts cannot read holds the token that identifies a participant.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from dataclasses import asdict
from http import HTTPStatus
from typing import Annotated

from pydantic import Field
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Act
from lockprobe.people.scenes import StrictModel
from lockprobe.people.server_state import PageReply, ServerState
from lockprobe.people.texts import Words
from lockprobe.people.web.address import Address
from lockprobe.people.web.files import Files
from lockprobe.people.web.guard import Guard, body_of
from lockprobe.people.web.log import LOGGED, ServerLog
from lockprobe.people.web.refusals import STATUS, RequestRefused, refusal, refused

COOKIE = "lockprobe"

SECONDS_REMEMBERED = 60 * 24 * 3600
"""How long a browser keeps its cookie, so that one can come back later."""

_LONGEST_LEASE = 200

Word = Annotated[str, Field(max_length=200)]
Platform = Annotated[dict[Word, Word], Field(max_length=40)]
"""The parameters of the URL under which the page was opened. The experimenter chooses which of them are kept."""


class _Open(StrictModel):
    platform: Platform = Field(default_factory=dict)


class _Done(StrictModel):
    lease: Annotated[str, Field(max_length=_LONGEST_LEASE)]
    turn: Annotated[int, Field(ge=0, le=10**9)]
    act: Act
    platform: Platform = Field(default_factory=dict)


class _Withdraw(StrictModel):
    lease: Annotated[str, Field(max_length=_LONGEST_LEASE)]


def application(state: ServerState, words: Words, address: Address, log: ServerLog) -> ASGIApp:
    """The application of the page, with its guard."""
    texts = _of_the_page(words)
    api = _ParticipantApi(state, texts, address)
    files = Files()

    routes = [
        Route("/", _answering(lambda request: files.answer("index.html", request))),
        Route("/static/{name}", _answering(lambda request: files.answer(request.path_params["name"], request))),
        Route("/api/open", api.open, methods=["POST"]),
        Route("/api/act", api.act, methods=["POST"]),
        Route("/api/withdraw", api.withdraw, methods=["POST"]),
        Route("/healthz", _answering(lambda request: PlainTextResponse("ok"))),
        Route("/robots.txt", _answering(lambda request: PlainTextResponse("User-agent: *\nDisallow: /\n"))),
        Route("/favicon.ico", _answering(lambda request: Response(status_code=HTTPStatus.NO_CONTENT))),
    ]
    errors = _Refusals(log, texts)
    inner = Starlette(
        routes=routes,
        exception_handlers={
            RequestRefused: errors.refused,
            ActRefused: errors.refused,
            HTTPException: errors.no_route,
            Exception: errors.broken,
        },
    )
    inner.router.redirect_slashes = False
    return Guard(GZipMiddleware(inner, minimum_size=1000, compresslevel=6), address, log)


def _answering(answer: Callable[[Request], Response]) -> Callable[[Request], object]:
    """Answer in the event loop, not in a thread: nothing here waits for a disk."""

    async def answered(request: Request) -> Response:
        return answer(request)

    return answered


def _of_the_page(words: Words) -> Mapping[str, object]:
    """The texts that the page needs from the start; other texts come with their scenes."""
    return {
        "language": words.language,
        "direction": words.direction,
        "title": words.title,
        "consent": words.consent.model_dump(include={"agree", "decline"}),
        "debrief": words.debrief.model_dump(include={"completion", "code"}),
        "page": words.page.model_dump(),
    }


class _ParticipantApi:
    """The requests of participants."""

    def __init__(self, state: ServerState, words: Mapping[str, object], address: Address) -> None:
        self._state, self._words = state, words
        self._secure = address.secure

    async def open(self, request: Request) -> Response:
        """A page was loaded."""
        asked = await body_of(request, _Open)
        shown = await self._state.enter(request.cookies.get(COOKIE), asked.platform)
        return self._answer(shown, words=self._words)

    async def act(self, request: Request) -> Response:
        """A participant acts in a scene."""
        asked = await body_of(request, _Done)
        token = request.cookies.get(COOKIE)
        return self._answer(await self._state.act(token, asked.lease, asked.turn, asked.act, asked.platform))

    async def withdraw(self, request: Request) -> Response:
        """A participant withdraws: all their data are deleted."""
        asked = await body_of(request, _Withdraw)
        return self._answer(await self._state.withdraw(request.cookies.get(COOKIE), asked.lease))

    def _answer(self, shown: PageReply, **more: object) -> Response:
        scene = shown.scene.model_dump(mode="json")
        answer = JSONResponse(
            {
                "lease": shown.lease,
                "turn": shown.turn,
                "scene": scene,
                "withdraw": shown.may_withdraw,
                "participant": shown.identity,
                "progress": None if shown.progress is None else asdict(shown.progress),
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
    """Answers and logs requests that are refused or fail."""

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
            _forget(answer)  # a cookie of another study; the page starts again
        return answer

    async def no_route(self, request: Request, error: Exception) -> Response:
        """This path does not exist, or not for this method."""
        assert isinstance(error, HTTPException)
        self._log.refused(request.scope, error.status_code, "unknown")
        answer = refusal("unknown", HTTPStatus(error.status_code).phrase, error.status_code)
        answer.headers.update(error.headers or {})
        return answer

    async def broken(self, request: Request, error: Exception) -> Response:
        """An unexpected error. The act is on disk or has not been done; the page asks again."""
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{type(error).__name__} at {'/'.join(last.filename.split('/')[-2:])}:{last.lineno}"
        self._log.refused(request.scope, HTTPStatus.INTERNAL_SERVER_ERROR, "broken", where)
        error.add_note(LOGGED)
        return refusal("broken", "something went wrong here; please try again", HTTPStatus.INTERNAL_SERVER_ERROR)
