"""The API of the admin page: progress, downloads and deletion. It requires a token."""

from __future__ import annotations

import hmac
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, TypeAdapter
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from lockprobe.people.progress import PeopleProgress
from lockprobe.people.scenes import StrictModel
from lockprobe.people.server_state import ServerState
from lockprobe.people.web.downloads import Downloadable, Downloads
from lockprobe.people.web.guard import body_of
from lockprobe.people.web.refusals import RequestRefused

__all__ = ["AdminApi", "AdminPage"]

_progress = TypeAdapter(PeopleProgress)


class _Withdraw(StrictModel):
    participant: Annotated[str, Field(pattern=r"^[a-z0-9]{4,32}$")]


class _Find(StrictModel):
    id: Annotated[str, Field(min_length=1, max_length=200)]


@dataclass(frozen=True, slots=True, kw_only=True)
class AdminPage:
    """What the admin page shows besides progress.

    Attributes:
        study_url: Turns the server's address into the one for a recruitment platform.
        reminders: What the experimenter still has to do before people come.
        files: The files to download.
    """

    study_url: Callable[[str], str] = lambda url: url
    reminders: tuple[str, ...] = ()
    files: Sequence[Downloadable] = ()


class AdminApi:
    """The requests of an experimenter, who sends ``Authorization: Bearer TOKEN``.

    ``url`` is the address for participants.
    """

    def __init__(self, state: ServerState, token: str, url: str = "", page: AdminPage | None = None) -> None:
        self._state, self._token = state, token
        page = page or AdminPage()
        self._downloads = Downloads(page.files, state.withdrawals)
        self._facts = {
            "study_url": page.study_url(url),
            "reminders": page.reminders,
            "downloads": self._downloads.described,
        }

    async def progress(self, request: Request) -> Response:
        """How far participants have come, by condition."""
        self._check(request)
        return self._answer()

    async def find(self, request: Request) -> Response:
        """The participants with an ID of the recruitment platform."""
        self._check(request)
        found = self._state.with_platform_id((await body_of(request, _Find)).id.strip())
        return JSONResponse({"participants": found})

    async def data(self, request: Request) -> Response:
        """A file with the data so far; the steps where the path names none."""
        self._check(request)
        return await self._downloads.answer(request.path_params.get("name", "steps.csv"))

    async def withdraw(self, request: Request) -> Response:
        """Delete all data of one participant, and answer with the progress."""
        self._check(request)
        await self._state.withdraw_participant((await body_of(request, _Withdraw)).participant)
        return self._answer()

    def _answer(self) -> Response:
        return JSONResponse({**_progress.dump_python(self._state.progress(), mode="json"), **self._facts})

    def _check(self, request: Request) -> None:
        kind, _, shown = request.headers.get("authorization", "").partition(" ")
        if kind.lower() != "bearer" or not hmac.compare_digest(shown.strip().encode(), self._token.encode()):
            raise RequestRefused("forged", "the admin page needs its token")
