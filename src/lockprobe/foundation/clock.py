"""The time of day as pages and lines say it: now, or SOURCE_DATE_EPOCH, by which equal records give equal files."""

from __future__ import annotations

import os
import time

_EPOCH = "SOURCE_DATE_EPOCH"
_held: dict[str, str] = {}


def hold_epoch() -> None:
    """Keep SOURCE_DATE_EPOCH here alone: scipy and PDF files read it too, and no finished file of ours holds a date."""
    if _EPOCH in os.environ:
        _held[_EPOCH] = os.environ.pop(_EPOCH)


def time_said() -> str:
    """The time in words: ``14:02 on 29 November 2026``."""
    epoch = os.environ.get(_EPOCH, _held.get(_EPOCH, ""))
    at = time.gmtime(int(epoch)) if epoch.isdecimal() and len(epoch) < 12 else time.localtime()
    return f"{time.strftime('%H:%M on', at)} {at.tm_mday} {time.strftime('%B %Y', at)}"
