"""What a participant's page gets that asks for what cannot be: a status, a code, and nothing is written."""

from __future__ import annotations

from typing import Literal

from lockprobe.errors import LockprobeError

__all__ = ["Code", "Refused"]

Code = Literal[
    "malformed",  # 400: no such body
    "incomplete",  # 400: a parameter of the URL that is no ID; the recruitment platform did not fill it in
    "forged",  # 401: a token that was not given out here, or a wrong admin token
    "wrong-code",  # 403: not the code that everybody has to give who joins
    "cross-site",  # 403: sent by a page of somebody else
    "unknown",  # 404
    "stale",  # 409: not the scene that is shown; the page has to ask for the one that is
    "elsewhere",  # 409: the study is open in a newer tab
    "too-large",  # 413
    "not-json",  # 415
    "impossible",  # 422: well formed, and nothing that can be done in this scene
    "busy",  # 429
]

_STATUS: dict[Code, int] = {
    "malformed": 400,
    "incomplete": 400,
    "forged": 401,
    "wrong-code": 403,
    "cross-site": 403,
    "unknown": 404,
    "stale": 409,
    "elsewhere": 409,
    "too-large": 413,
    "not-json": 415,
    "impossible": 422,
    "busy": 429,
}


class Refused(LockprobeError):
    """Raised when something cannot be done.

    Args:
        code: Why.
        message: In words, for the log and the page; without anything that was sent.
    """

    def __init__(self, code: Code, message: str) -> None:
        super().__init__(message)
        self.code: Code = code
        self.status = _STATUS[code]
