"""Pictures as arrays and files, depth in colours, where things are seen, and worse pictures."""

import struct
import zlib
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.camera import encode
from lockprobe.trial.pictures.frame import Camera, Frame, degraded, from_png, to_png, turbo
from lockprobe.trial.pictures.picture import Picture

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
def test_an_array_comes_back_from_its_file_and_equal_pictures_have_equal_names(image):
    read = from_png(to_png(image))
    assert read.dtype == image.dtype
    np.testing.assert_array_equal(read, image)
    one, same, other = (Picture(kind="rgb", png=png) for png in (to_png(image), to_png(image.copy()), b"b"))
    assert one.name == same.name != other.name
    assert one.name.endswith(".png")


def test_other_files_are_refused_and_those_that_promise_too_much_before_anything_is_read():
    image = to_png(RNG.integers(0, 256, (7, 11, 3), dtype=np.uint8))
    for broken in (b"", b"not a picture", image[:40], image[: len(image) // 2]):
        with pytest.raises(BadValue, match=f"picture: got '{len(broken)} bytes', expected a PNG file"):
            from_png(broken)
    for side in (5000, 60000):
        png = bytearray(to_png(np.zeros((4, 4), np.uint8)))
        png[16:24] = struct.pack(">II", side, side)
        png[29:33] = struct.pack(">I", zlib.crc32(bytes(png[12:29])))
        with pytest.raises(BadValue, match="^picture: got"):
            from_png(bytes(png))


# Where things of the panel are seen.
def camera(width=40, height=30, focal=600.0, distance=0.72):
    panel = np.diag([1.0, -1, -1, 1])
    panel[2, 3] = distance
    return Camera(width=width, height=height, focal=focal, panel=panel)


def test_the_middle_of_the_panel_is_seen_in_the_middle():
    upright = camera(640, 480, 600, 0.7)
    assert upright.project(np.zeros(3)) == pytest.approx([319.5, 239.5, 0.7])
    # Right on the panel is right in the picture, up is up, and what stands out is nearer.
    assert upright.project(np.array([0.1, 0.05, 0.07])) == pytest.approx([319.5 + 60 / 0.63, 239.5 - 30 / 0.63, 0.63])
    assert upright.project(np.zeros((4, 2, 3))).shape == (4, 2, 3)


def test_turbo_is_turbo_and_red_is_near():
    published = np.rint(255 * np.array(mpl.colormaps["turbo"].colors)).astype(np.uint8)
    np.testing.assert_array_equal(turbo(), published)
    depth = np.array([[0.1, 0.64, 0.78, 3.0]], np.float32)
    colours = encode(depth)
    assert colours.tolist() == [[[122, 4, 3], [122, 4, 3], [48, 18, 59], [48, 18, 59]]]


# Worse pictures: each dose does what it says, nests, and leaves the rest alone.
FRAME = Frame(
    rgb=RNG.integers(60, 200, (120, 160, 3), dtype=np.uint8),
    depth=RNG.uniform(0.65, 0.77, (120, 160)).astype(np.float32),
    camera=camera(160, 120, 200.0),
    handles=np.array([[[x, -0.04, 0.05], [x, 0.04, 0.05]] for x in (-0.15, 0.0, 0.15)]),
    renderer="a fake",
)
LUCK = np.array([0.3, 0.8, 0.5])


def test_the_patch_hides_its_share_of_the_panel_and_what_a_smaller_one_hides():
    hidden = []
    for share in (0.1, 0.4, 0.9, 1.0):
        worse = degraded(FRAME, LUCK, occlude=share)
        gone = worse.depth == 0
        assert (worse.rgb[gone] == 128).all()
        np.testing.assert_array_equal(worse.rgb[~gone], FRAME.rgb[~gone])
        np.testing.assert_array_equal(worse.depth[~gone], FRAME.depth[~gone])
        hidden.append(gone)
    for less, more in pairwise(hidden):
        assert (more | ~less).all()
    whole = hidden[-1].sum()
    for share, gone in zip((0.1, 0.4, 0.9), hidden, strict=False):
        assert gone.sum() / whole == pytest.approx(share, rel=0.05)
    places = FRAME.camera.project(FRAME.handles)[..., :2].reshape(-1, 2).round().astype(int)
    assert all(hidden[-1][row, column] for column, row in places)
    # Where the patch lies is luck.
    here, there = (degraded(FRAME, np.array(luck), occlude=0.2) for luck in ((0, 0, 0), (0.9, 0.9, 0)))
    assert not ((here.depth == 0) & (there.depth == 0)).all()
    assert (here.depth == 0).sum() == pytest.approx((there.depth == 0).sum(), rel=0.05)
