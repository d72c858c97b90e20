"""The time of day as pages and lines say it: now, or SOURCE_DATE_EPOCH, by which equal records give equal files."""

import os
import time

held = ""
"""SOURCE_DATE_EPOCH, where a command took it out of the environment: scipy and PDF files would read it, too."""


def time_said() -> str:
    """The time in words: ``14:02 on 29 November 2026``."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", held)
    at = time.gmtime(int(epoch)) if epoch.isdecimal() and len(epoch) < 12 else time.localtime()
    return f"{time.strftime('%H:%M on', at)} {at.tm_mday} {time.strftime('%B %Y', at)}"
