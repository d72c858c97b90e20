"""Pictures of depth: the same colour is the same distance in every picture, and it can be read back."""

import matplotlib as mpl
import numpy as np
import pytest
from depth_pictures import decode, depth_at

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.pictures.depth import (
    HEIGHTS,
    Window,
    encode,
    from_millimetres,
    legend,
    to_millimetres,
    turbo,
)
from lockprobe.trial.pictures.frame import Camera

WINDOW = Window(near=0.64, far=0.78)
KINDS = ["turbo", "gray", "height", "packed"]


def camera(width=40, height=30):
    panel = np.diag([1.0, -1, -1, 1])
    panel[2, 3] = 0.72
    return Camera(width=width, height=height, focal=600.0, panel=panel)


def random_depth(low=0.64, high=0.78):
    depth = np.random.default_rng(1).uniform(low, high, (30, 40)).astype(np.float32)
    depth[3:5, 7:20] = 0
    return depth


@pytest.mark.parametrize(("kind", "step"), [("turbo", 0.14 / 255), ("gray", 0.14 / 254), ("packed", 1e-3)])
def test_it_is_read_back_to_within_half_a_step(kind, step):
    depth = random_depth()
    read = decode(encode(depth, kind, WINDOW, camera()), kind, WINDOW, camera())
    assert read.dtype == np.float32
    assert np.abs(read - depth).max() <= (1.0 if kind == "gray" else 0.5) * step + 1e-6
    np.testing.assert_array_equal(read == 0, depth == 0)


def test_heights_are_read_back_whatever_the_depth():
    tilted = camera()
    tilted.panel[:3, :3] = tilted.panel[:3, :3] @ np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]])
    depth = depth_at(tilted, np.random.default_rng(2).uniform(*HEIGHTS, (30, 40))).astype(np.float32)
    read = decode(encode(depth, "height", WINDOW, tilted), "height", WINDOW, tilted)
    assert np.abs(tilted.heights(read) - tilted.heights(depth)).max() <= 0.5 * 0.08 / 255 + 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_no_reading_is_black_and_nothing_else_is(kind):
    depth = random_depth(0.3, 2.0)
    image = encode(depth, kind, WINDOW, camera())
    assert image.dtype == np.uint8
    black = ~image.any(axis=2) if image.ndim == 3 else image == 0
    np.testing.assert_array_equal(black, depth == 0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_colour_depends_on_its_own_pixel_alone(kind):
    depth = random_depth()
    other = depth.copy()
    other[20:, :] = 0.66
    first, second = (encode(each, kind, WINDOW, camera()) for each in (depth, other))
    np.testing.assert_array_equal(first[:20], second[:20])


def test_near_is_red_and_white_far_is_blue_and_dark():
    depth = np.array([[0.1, 0.64, 0.78, 3.0]], np.float32)
    colours = encode(depth, "turbo", WINDOW, camera(4, 1))
    assert colours.tolist() == [[[122, 4, 3], [122, 4, 3], [48, 18, 59], [48, 18, 59]]]
    assert encode(depth, "gray", WINDOW, camera(4, 1)).tolist() == [[255, 255, 1, 1]]


def test_packed_is_spatialbots():
    depth = np.array([[0.0, 0.715, 1.5, 65.0]], np.float32)
    image = encode(depth, "packed", WINDOW, camera(4, 1))
    assert image.tolist() == [[[0, 0, 0], [0, 176, 88], [4, 112, 224], [252, 120, 64]]]
    red, green, blue = image[0].T.astype(float)
    assert (256 * red + 4 * green + blue / 8).tolist() == [0, 715, 1500, 65000]


def test_turbo_is_turbo():
    published = np.rint(255 * np.array(mpl.colormaps["turbo"].colors)).astype(np.uint8)
    np.testing.assert_array_equal(turbo(), published)


def test_legends_name_the_window_in_one_sentence():
    for kind in KINDS:
        sentence = legend(kind, WINDOW)
        assert sentence.endswith("black no reading.")
        assert sentence.count(". ") == 0
    for kind in ("turbo", "gray"):
        assert "0.64 m" in legend(kind, WINDOW)
        assert "0.78 m" in legend(kind, WINDOW)
    assert "6 cm" in legend("height", WINDOW)


def test_millimetres():
    depth = np.array([0, 0.0004, 0.0006, 0.7123, 65.535, 65.6, 1e6], np.float32)
    assert to_millimetres(depth).tolist() == [0, 0, 1, 712, 65535, 0, 0]
    assert to_millimetres(depth).dtype == np.uint16
    whole = np.arange(0, 65536, 7, dtype=np.uint16)
    np.testing.assert_array_equal(to_millimetres(from_millimetres(whole)), whole)


@pytest.mark.parametrize(("near", "far"), [(0.7, 0.7), (0.8, 0.7), (-0.1, 0.7), (float("nan"), 1.0), (0.1, 100.0)])
def test_an_empty_window_is_refused(near, far):
    with pytest.raises(BadValue, match="depth window: got"):
        Window(near=near, far=far)


def test_an_unknown_kind_is_refused():
    for call in (lambda: legend("jet", WINDOW), lambda: encode(random_depth(), "jet", WINDOW, camera())):
        with pytest.raises(BadValue, match="depth: got 'jet', expected one of turbo, gray, height, packed"):
            call()
