"""Pictures and meshes of a user's model unpack to what they say."""

import struct
import zlib
from pathlib import Path

import pytest
from lockprobe_robot.user_model.assets import plain_png, png_sides, triangles_and_vertices
from painted_png import SIGNATURE, chunk, png, zeros

from lockprobe.foundation.errors import BadFile

FILE = Path("a.png")


def test_only_what_makes_the_pixels_is_kept():
    text = chunk(b"zTXt", b"k\0\0" + zeros(1 << 24)) + chunk(b"iCCP", b"k\0\0" + zeros(1 << 24))
    colours = chunk(b"sRGB", b"\0")
    assert plain_png(png(3, 2, more=text + colours) + b"after the end", FILE) == png(3, 2, more=colours)
    assert png_sides(png(3, 2)) == (3, 2)


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


def test_triangles_and_vertices_of_a_mesh_are_counted():
    corner = struct.pack("<3f", 0, 0, 1)
    triangle = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    stl = bytes(80) + struct.pack("<I", 2) + triangle + triangle[:12] + 3 * corner + triangle[-2:]
    assert triangles_and_vertices(stl, "stl") == (2, 4)
    assert triangles_and_vertices(b"", "stl") == (0, 0)
    obj = b"v 0 0 0\nv 1 0 0\r v 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2 3\n\tf 1 2 3 1 2\n"
    assert triangles_and_vertices(obj, "obj") == (4, 3)
    assert triangles_and_vertices(struct.pack("<4i", 7, 0, 0, 5) + bytes(9), "msh") == (5, 7)
    assert triangles_and_vertices(b"", "msh") == (0, 0)
