"""Files that a user's model refers to, read as untrusted data: pictures and meshes."""

from __future__ import annotations

import zlib
from pathlib import Path

from lockprobe.foundation.errors import BadFile

LONGEST_SIDE = 4096
"""Pixels of a picture along each side."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"

_KEPT = (b"IHDR", b"PLTE", b"tRNS", b"sRGB", b"IDAT", b"IEND")
"""Chunks that MuJoCo needs. Others hold text and colour profiles, which unpack to any size."""

_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers of a pixel by the colour type of a PNG file."""

_BLOCK = 1 << 20


def plain_png(content: bytes, path: Path) -> bytes:
    """A PNG file with its pixels alone.

    Raises:
        BadFile: If it is no PNG file, has a side of more than :data:`LONGEST_SIDE` pixels, or unpacks to more than its
            pixels.
    """
    chunks = _chunks(content)
    if not chunks or chunks[0][0] != b"IHDR" or len(chunks[0][1]) != 25 or chunks[-1][0] != b"IEND":
        raise BadFile(path, "not a whole PNG file")
    plain = _SIGNATURE + b"".join(chunk for kind, chunk in chunks if kind in _KEPT)
    width, height = int.from_bytes(plain[16:20]), int.from_bytes(plain[20:24])
    if max(width, height) > LONGEST_SIDE:
        raise BadFile(path, f"a picture with a side of more than {LONGEST_SIDE} pixels")
    bits, colour = plain[24], plain[25]
    most = (width * bits * _SAMPLES.get(colour, 4) // 8 + 16) * height + 64  # with room for interlaced rows
    if not _unpacks(b"".join(chunk[8:-4] for kind, chunk in chunks if kind == b"IDAT"), most):
        raise BadFile(path, f"not a PNG file that unpacks to its {width} x {height} pixels")
    return plain


def _chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    """The chunks of a PNG file with their kinds, up to its end; none if it is no PNG file."""
    found: list[tuple[bytes, bytes]] = []
    at = len(_SIGNATURE)
    while content.startswith(_SIGNATURE) and at + 12 <= len(content):
        kind, end = content[at + 4 : at + 8], at + 12 + int.from_bytes(content[at : at + 4])
        if end > len(content):
            return []
        found.append((kind, content[at:end]))
        if kind == b"IEND":
            break
        at = end
    return found


def _unpacks(packed: bytes, most: int) -> bool:
    """Whether packed data are whole and unpack to at most so many bytes; little more is unpacked to find out."""
    unpacker, rest = zlib.decompressobj(), packed
    try:
        while rest and not unpacker.eof and most >= 0:
            most -= len(unpacker.decompress(rest, _BLOCK))
            rest = unpacker.unconsumed_tail
    except zlib.error:
        return False
    return most >= 0 and unpacker.eof
