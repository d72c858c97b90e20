"""Refused requests: HTTP status, code and message of the answer."""

from __future__ import annotations

from collections.abc import Mapping

from starlette.responses import JSONResponse

from lockprobe.foundation.errors import LockprobeError
from lockprobe.people.refusals import ActRefused

STATUS: Mapping[str, int] = {
    "malformed": 400,
    "incomplete": 400,
    "forged": 401,  # a token that was not given out here
    "wrong-code": 403,
    "cross-site": 403,  # sent by a page of another site
    "unknown": 404,
    "stale": 409,
    "elsewhere": 409,
    "too-large": 413,
    "not-json": 415,
    "impossible": 422,
    "busy": 429,
}
"""The HTTP status for each code: those of lockprobe.people.refusals, and those that only HTTP has."""


class RequestRefused(LockprobeError):
    """A request cannot be answered, whoever sends it.

    Args:
        code: One of :data:`STATUS`.
        message: For the log and the page. It repeats nothing that was sent.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


def refusal(code: str, message: str, status: int, **more: object) -> JSONResponse:
    """The answer to a refused request."""
    return JSONResponse({"error": code, "message": message, **more}, status)


def refused(error: ActRefused | RequestRefused, **more: object) -> JSONResponse:
    """The answer for an error."""
    return refusal(error.code, str(error), STATUS[error.code], **more)
