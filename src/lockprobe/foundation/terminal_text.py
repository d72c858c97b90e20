"""Text that steers nobody: no control characters in a terminal, no end of a line within a line of JSON."""

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


def one_line(line: bytes) -> bytes:
    r"""A line of JSON with its U+0085, U+2028 and U+2029 escaped: :meth:`str.splitlines` would cut it there.

    >>> one_line('{"a":"one\u2028two"}'.encode())
    b'{"a":"one\\u2028two"}'
    """
    if line.isascii():
        return line
    for end in "\x85\u2028\u2029":
        line = line.replace(end.encode(), b"\\u%04x" % ord(end))
    return line
