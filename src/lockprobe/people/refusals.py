"""Refusals: why a participant's request cannot be done. A refused request changes nothing."""

from __future__ import annotations

from typing import Literal

from lockprobe.foundation.errors import LockprobeError

Code = Literal[
    "malformed",  # the lease of a page has a wrong form
    "incomplete",  # the recruitment platform did not fill in a parameter of the URL
    "forged",  # the token was not given out here
    "wrong-code",  # the code to join is missing or wrong
    "stale",  # the act is for another scene than the one shown; the page has to ask for that one
    "elsewhere",  # the study is open in a newer tab
    "impossible",  # the act has the right form, but this scene does not allow it
]


class ActRefused(LockprobeError):
    """An act cannot be done. The message is for the log and the page; it repeats nothing that the page sent."""

    def __init__(self, code: Code, message: str) -> None:
        super().__init__(message)
        self.code: Code = code
