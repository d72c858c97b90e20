"""Lines of JSON that carry a checksum: a line that was changed by a single bit is refused, not read.

The last field of the object is ``crc``: eight hexadecimal digits, the CRC-32 (:func:`zlib.crc32`) of all bytes of the
line before ``,"crc"``. Lines without it, of earlier releases, are read as they are.
"""

from __future__ import annotations

import re
import zlib

from lockprobe.errors import BadValue

__all__ = ["has_checksum", "with_checksum", "without_checksum"]

_CHECKSUM = re.compile(rb',"crc":"([0-9a-f]{8})"\}\Z')


def with_checksum(line: bytes) -> bytes:
    """A line with its checksum.

    Args:
        line: A JSON object that is not empty, without a newline.

    >>> with_checksum(b'{"a":1}')
    b'{"a":1,"crc":"a702fc6e"}'
    """
    said = line[:-1]
    return said + b',"crc":"%08x"}' % zlib.crc32(said)


def has_checksum(line: bytes) -> bool:
    """Whether a line carries one, right or wrong."""
    return _CHECKSUM.search(line.rstrip()) is not None


def without_checksum(line: bytes) -> bytes:
    """A line without its checksum, which is checked; a line that has none is given back as it is.

    Args:
        line: A JSON object, with or without a newline.

    Raises:
        BadValue: If the checksum is not that of the line.
    """
    line = line.rstrip()
    found = _CHECKSUM.search(line)
    if found is None:
        return line
    said = line[: found.start()]
    if zlib.crc32(said) != int(found[1], 16):
        raise BadValue("checksum", found[1].decode(), f"{zlib.crc32(said):08x}: the line was changed")
    return said + b"}"
