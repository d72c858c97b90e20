"""Lines of JSON that every reader takes for lines."""

from __future__ import annotations


def one_line(line: bytes) -> bytes:
    r"""A line of JSON with its U+0085, U+2028 and U+2029 escaped: :meth:`str.splitlines` would cut it there.

    >>> one_line('{"a":"one\u2028two"}'.encode())
    b'{"a":"one\\u2028two"}'
    """
    for end in "\x85\u2028\u2029":
        line = line.replace(end.encode(), b"\\u%04x" % ord(end))
    return line
