"""Makes text safe to print in a terminal: control characters become question marks."""

from __future__ import annotations

import re

_CONTROLS = re.compile("[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\x7f-\\x9f\\u2028\\u2029\\u202a-\\u202e\\u2066-\\u2069]")


def printable(text: str) -> str:
    r"""The text with a question mark for every character that is invisible or changes the order of others.

    >>> printable("one\x1b[2Jtwo")
    'one?[2Jtwo'
    """
    return text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)


def readable(text: str) -> str:
    """A text of several lines with question marks for control characters and changes of writing direction.

    Letters of every script stay, with the joiners and marks they need.
    """
    return _CONTROLS.sub("?", text)
