"""The experimenter's page: how the study stands, and people who asked by mail to be deleted. Behind a token."""

from __future__ import annotations

import hmac
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from starlette.requests import Request
from starlette.responses import Response

from lockprobe.people.progress import Progress
from lockprobe.people.reception import Reception
from lockprobe.people.refusals import Refused

__all__ = ["Admin"]

_progress = TypeAdapter(Progress)


class _Withdraw(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    participant: Annotated[str, Field(pattern=r"^[a-z0-9]{4,32}$")]


class Admin:
    """What an experimenter can ask for.

    Args:
        reception: Who is there.
        token: What has to be shown, as ``Authorization: Bearer TOKEN``.
    """

    def __init__(self, reception: Reception, token: str) -> None:
        self._reception, self._token = reception, token

    async def progress(self, request: Request) -> Response:
        """How many have done what, by condition."""
        self._check(request)
        return self._answer()

    async def withdraw(self, request: Request) -> Response:
        """Delete everything that was kept of one participant; answered with how the study stands then."""
        self._check(request)
        try:
            asked = _Withdraw.model_validate_json(await request.body())
        except ValidationError:
            raise Refused("malformed", "the body is no such JSON object") from None
        await self._reception.withdraw_participant(asked.participant)
        return self._answer()

    def _answer(self) -> Response:
        return Response(_progress.dump_json(self._reception.progress()), media_type="application/json")

    def _check(self, request: Request) -> None:
        kind, _, shown = request.headers.get("authorization", "").partition(" ")
        if kind.lower() != "bearer" or not hmac.compare_digest(shown.strip().encode(), self._token.encode()):
            raise Refused("forged", "the admin page needs its token")
