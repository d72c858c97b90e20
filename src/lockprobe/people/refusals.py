"""Refusals: why a request cannot be done. A refused request changes nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

from lockprobe.foundation.errors import LockprobeError

Code = Literal[
    "malformed",  # the lease of a page has a wrong form, or the body is no such JSON object
    "incomplete",  # the recruitment platform did not fill in a parameter of the URL
    "forged",  # the token was not given out here
    "wrong-code",  # the code to join is missing or wrong
    "cross-site",  # sent by a page of another site
    "unknown",  # there is no such path
    "stale",  # the act is for another scene than the one shown; the page has to ask for that one
    "elsewhere",  # the study is open in a newer tab
    "too-large",  # the body has too many bytes
    "not-json",  # the body is no JSON
    "impossible",  # the act has the right form, but this scene does not allow it
    "busy",  # too many bodies arrive at once
]

STATUS: Mapping[Code, int] = dict(
    zip(get_args(Code), (400, 400, 401, 403, 403, 404, 409, 409, 413, 415, 422, 429), strict=True)
)
"""The HTTP status for each code."""


class ActRefused(LockprobeError):
    """A request cannot be done. The message is for the log and the page; it repeats nothing that was sent."""

    def __init__(self, code: Code, message: str) -> None:
        super().__init__(message)
        self.code: Code = code
