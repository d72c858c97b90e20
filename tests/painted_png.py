"""PNG files for tests, whole and false."""

import struct
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def zeros(size):
    """Packed zeros, made in pieces."""
    packer, block = zlib.compressobj(9), bytes(1 << 16)
    pieces = [packer.compress(block[: min(len(block), size - at)]) for at in range(0, size, len(block))]
    return b"".join(pieces) + packer.flush()


def png(width, height, *, pixels=None, more=b""):
    """A black picture in colour; ``pixels`` are packed, ``more`` are chunks before them."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    packed = zeros(height * (1 + 3 * width)) if pixels is None else pixels
    return SIGNATURE + header + more + chunk(b"IDAT", packed) + chunk(b"IEND", b"")
