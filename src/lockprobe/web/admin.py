"""The experimenter's page: how the study stands, and people who asked by mail to be deleted. Behind a token."""

from __future__ import annotations

import hmac
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from lockprobe.people.progress import StudyProgress
from lockprobe.people.server_state import ServerState
from lockprobe.web.downloads import Downloadable, Downloads
from lockprobe.web.guard import body_of
from lockprobe.web.refusals import RequestRefused

__all__ = ["AdminApi", "AdminPage"]

_progress = TypeAdapter(StudyProgress)


class _Withdraw(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    participant: Annotated[str, Field(pattern=r"^[a-z0-9]{4,32}$")]


class _Find(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    id: Annotated[str, Field(min_length=1, max_length=200)]


@dataclass(frozen=True, slots=True, kw_only=True)
class AdminPage:
    """What the admin page gets from those above.

    Attributes:
        study_url: The address to paste into a recruitment platform, from that of the server.
        reminders: What is still to be done before people come.
        files: What has been played so far, as files.
    """

    study_url: Callable[[str], str] = lambda url: url
    reminders: tuple[str, ...] = ()
    files: Sequence[Downloadable] = ()


class AdminApi:
    """What an experimenter can ask for.

    Args:
        state: Who is there.
        token: What has to be shown, as ``Authorization: Bearer TOKEN``.
        url: Where participants go.
        desk: What comes from those above.
    """

    def __init__(self, state: ServerState, token: str, url: str = "", desk: AdminPage | None = None) -> None:
        self._state, self._token = state, token
        self._desk = desk or AdminPage()
        self._downloads = Downloads(self._desk.files, state.withdrawals)
        self._facts = {
            "study_url": self._desk.study_url(url),
            "reminders": self._desk.reminders,
            "downloads": self._downloads.described,
        }

    async def progress(self, request: Request) -> Response:
        """How many have done what, by condition."""
        self._check(request)
        return self._answer()

    async def find(self, request: Request) -> Response:
        """Who has an ID of the recruitment platform: the IDs that were made up here."""
        self._check(request)
        found = self._state.with_platform_id((await body_of(request, _Find)).id.strip())
        return JSONResponse({"participants": found})

    async def data(self, request: Request) -> Response:
        """What has been played so far, as one of the files; the steps where none is named."""
        self._check(request)
        return await self._downloads.answer(request.path_params.get("name", "steps.csv"))

    async def withdraw(self, request: Request) -> Response:
        """Delete everything that was kept of one participant; answered with how the study stands then."""
        self._check(request)
        await self._state.withdraw_participant((await body_of(request, _Withdraw)).participant)
        return self._answer()

    def _answer(self) -> Response:
        return JSONResponse({**_progress.dump_python(self._state.progress(), mode="json"), **self._facts})

    def _check(self, request: Request) -> None:
        kind, _, shown = request.headers.get("authorization", "").partition(" ")
        if kind.lower() != "bearer" or not hmac.compare_digest(shown.strip().encode(), self._token.encode()):
            raise RequestRefused("forged", "the admin page needs its token")
