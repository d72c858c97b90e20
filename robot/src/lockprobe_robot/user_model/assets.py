"""Files that a user's model refers to, read as untrusted data: pictures and meshes."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import numpy as np

from lockprobe.foundation.errors import BadFile

__all__ = ["LONGEST_SIDE", "plain_png", "png_sides", "triangles_and_vertices"]

LONGEST_SIDE = 4096
"""Pixels of a picture along each side."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"

_KEPT = (b"IHDR", b"PLTE", b"tRNS", b"sRGB", b"IDAT", b"IEND")
"""Chunks that MuJoCo needs. Others hold text and colour profiles, which unpack to any size."""

_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers of a pixel by the colour type of a PNG file."""

_BLOCK = 1 << 20

_STL_HEADER, _STL_TRIANGLE = 84, 50


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
    width, height = png_sides(plain)
    if max(width, height) > LONGEST_SIDE:
        raise BadFile(path, f"a picture with a side of more than {LONGEST_SIDE} pixels")
    bits, colour = plain[24], plain[25]
    most = (width * bits * _SAMPLES.get(colour, 4) // 8 + 16) * height + 64  # with room for interlaced rows
    if not _unpacks(b"".join(chunk[8:-4] for kind, chunk in chunks if kind == b"IDAT"), most):
        raise BadFile(path, f"not a PNG file that unpacks to its {width} x {height} pixels")
    return plain


def png_sides(content: bytes) -> tuple[int, int]:
    """Width and height in the header of a PNG file."""
    return int.from_bytes(content[16:20]), int.from_bytes(content[20:24])


def triangles_and_vertices(content: bytes, suffix: str) -> tuple[int, int]:
    """At least the number of triangles and of vertices in a mesh file of a format: ``stl``, ``obj`` or ``msh``."""
    if suffix == "stl":
        number = max(len(content) - _STL_HEADER, 0) // _STL_TRIANGLE
        packed = np.frombuffer(content, np.uint8, _STL_TRIANGLE * number, min(_STL_HEADER, len(content)))
        corners = np.ascontiguousarray(packed.reshape(number, _STL_TRIANGLE)[:, 12:48]).view("V12")
        return number, len(np.unique(corners)) if number else 0
    if suffix == "msh":
        numbers = np.frombuffer(content[:16].ljust(16, b"\0"), "<i4").tolist()
        return max(numbers[3], 0), max(*numbers[:3], 0)
    lines = content.replace(b"\r", b"\n")
    faces = [len(corners.split()) for corners in re.findall(rb"(?m)^[ \t]*f[ \t]+(.*)$", lines)]
    return sum(max(corners - 2, 0) for corners in faces), len(re.findall(rb"(?m)^[ \t]*v[ \t]", lines))


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
