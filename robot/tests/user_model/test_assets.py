"""Pictures of a user's model unpack to what they say."""

import struct
import zlib
from pathlib import Path

import pytest
from lockprobe_robot.user_model.assets import plain_png
from painted_png import SIGNATURE, chunk, png, zeros

from lockprobe.foundation.errors import BadFile

FILE = Path("a.png")


def test_only_what_makes_the_pixels_is_kept():
    text = chunk(b"zTXt", b"k\0\0" + zeros(1 << 24)) + chunk(b"iCCP", b"k\0\0" + zeros(1 << 24))
    colours = chunk(b"sRGB", b"\0")
    assert plain_png(png(3, 2, more=text + colours) + b"after the end", FILE) == png(3, 2, more=colours)


def test_an_interlaced_picture_is_whole():
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 9, 9, 8, 2, 0, 0, 1))
    rows = 9 * 9 * 3 + sum((2, 2, 2, 3, 3, 5, 4))
    content = SIGNATURE + header + chunk(b"IDAT", zeros(rows)) + chunk(b"IEND", b"")
    assert plain_png(content, FILE) == content


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "not a whole PNG file"),
        (b"GIF89a" + bytes(100), "not a whole PNG file"),
        (png(3, 2)[:-1], "not a whole PNG file"),
        (SIGNATURE + chunk(b"tIME", bytes(7)) + png(3, 2)[8:], "not a whole PNG file"),
        (SIGNATURE + struct.pack(">I", 2**32 - 1) + b"IHDR", "not a whole PNG file"),
        (png(4097, 1), "a side of more than 4096 pixels"),
        (png(1, 1, pixels=zeros(1 << 24)), "not a PNG file that unpacks to its 1 x 1 pixels"),
        (png(3, 2, pixels=b"no zlib"), "not a PNG file that unpacks"),
        (png(3, 2, pixels=zlib.compress(bytes(20))[:-6]), "not a PNG file that unpacks"),
    ],
)
def test_what_is_no_such_picture_is_one_line(content, why):
    with pytest.raises(BadFile, match=why):
        plain_png(content, FILE)
