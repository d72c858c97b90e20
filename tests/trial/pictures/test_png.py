"""An array goes into a file and comes back the same."""

import struct
import sys
import zlib

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.trial.pictures.png import from_png, to_png

RNG = np.random.default_rng(5)


@pytest.mark.parametrize(
    "image",
    [
        RNG.integers(0, 256, (7, 11, 3), dtype=np.uint8),
        RNG.integers(0, 256, (7, 11), dtype=np.uint8),
        RNG.integers(0, 65536, (7, 11), dtype=np.uint16),
        np.array([[0, 65535, 256]], np.uint16),
        RNG.integers(0, 256, (14, 22, 3), dtype=np.uint8)[::-2, ::2],
    ],
)
def test_it_comes_back_the_same(image):
    read = from_png(to_png(image))
    assert read.dtype == image.dtype
    np.testing.assert_array_equal(read, image)


def test_equal_pictures_are_equal_files():
    image = RNG.integers(0, 256, (7, 11, 3), dtype=np.uint8)
    assert to_png(image) == to_png(image.copy())


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((3, 4), np.float32),
        np.zeros((3, 4, 4), np.uint8),
        np.zeros((3, 4, 3), np.uint16),
        np.zeros(4, np.uint8),
    ],
)
def test_other_arrays_are_refused(image):
    with pytest.raises(BadValue, match="picture: got"):
        to_png(image)


def test_other_files_are_refused():
    image = to_png(RNG.integers(0, 256, (7, 11, 3), dtype=np.uint8))
    for broken in (b"", b"not a picture", image[:40], image[: len(image) // 2]):
        with pytest.raises(BadValue, match=f"picture: got '{len(broken)} bytes', expected a PNG file"):
            from_png(broken)


@pytest.mark.parametrize("side", [5000, 60000])
def test_a_header_that_promises_too_much_is_refused_before_anything_is_read(side):
    png = bytearray(to_png(np.zeros((4, 4), np.uint8)))
    png[16:24] = struct.pack(">II", side, side)
    png[29:33] = struct.pack(">I", zlib.crc32(bytes(png[12:29])))
    with pytest.raises(BadValue, match="^picture: got"):
        from_png(bytes(png))


def test_without_pillow_it_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL", None)
    for call in (lambda: to_png(np.zeros((3, 4), np.uint8)), lambda: from_png(b"")):
        with pytest.raises(Missing, match=r"pillow: pip install 'lockprobe\[twin\]'"):
            call()
