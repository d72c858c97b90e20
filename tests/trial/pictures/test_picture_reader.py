"""Reading joints from pictures: what is plain to see is read rightly, and misreads come as pictures get coarser."""

import colorsys
import io
import itertools
from dataclasses import replace

import numpy as np
import pytest
from drawn_board import HANDLES, HEIGHT, WIDTH, coloured, deep, grey
from PIL import Image

from lockprobe.trial.pictures.depth import Window, encode
from lockprobe.trial.pictures.frame import Camera
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.pictures.picture_reader import evidence, shrunk
from lockprobe.trial.pictures.png import from_png, to_png

ALL = list(itertools.product((0, 1), repeat=5))


def right(pictures, positions, acuity=64):
    """Evidence for the truth, from -1 to 1, of each joint."""
    return np.array(evidence(pictures, HANDLES, acuity=acuity)) * (2 * np.array(positions) - 1)


@pytest.mark.parametrize("kinds", [(coloured,), (grey,), (coloured, grey)])
def test_every_configuration_is_read_with_conviction(kinds):
    for seed, positions in enumerate(ALL[::3]):
        assert right([kind(positions, seed) for kind in kinds], positions).min() > 0.5


def test_handles_and_wood_of_any_colour_under_any_light_are_read():
    rng = np.random.default_rng(5)
    for seed in range(12):
        positions = tuple(rng.integers(0, 2, 5).tolist())
        look = {
            "colour": colorsys.hsv_to_rgb(seed / 12, 0.88, 0.82),
            "wood": [(0.80, 0.63, 0.43), (0.86, 0.74, 0.56), (0.70, 0.50, 0.33)][seed % 3],
            "light": float(rng.random()),
        }
        assert right([coloured(positions, seed, **look)], positions).min() > 0.2


CAMERA = Camera(
    width=WIDTH,
    height=HEIGHT,
    focal=300.0,
    panel=np.array([[1, 0, 0, 0], [0, -0.94, 0.34, 0], [0, -0.34, -0.94, 0.67], [0, 0, 0, 1]]),
)


@pytest.mark.parametrize("kind", ["turbo", "gray", "height", "packed"])
def test_depth_is_read_in_every_form_in_which_it_is_shown(kind):
    for seed in (0, 1, 2):
        positions = ALL[7 * seed + 5]
        shown = encode(deep(positions, CAMERA), kind, Window(near=0.55, far=0.8), CAMERA)
        assert right([Picture(kind="depth", png=to_png(shown))], positions).min() > 0.5


def test_gaps_in_depth_are_no_holes_in_the_board():
    rng = np.random.default_rng(2)
    positions = (0, 1, 1, 0, 1)
    depth = deep(positions, CAMERA)
    depth[rng.random(depth.shape) < 0.1] = 0
    depth[:, :60] = 0
    shown = encode(depth, "turbo", Window(near=0.55, far=0.8), CAMERA)
    told = right([Picture(kind="depth", png=to_png(shown))], positions)
    assert told[1:].min() > 0.2
    assert abs(told[0]) < 0.05  # nothing is known there


def test_a_picture_without_handles_convinces_of_nothing():
    empty = Picture(kind="rgb", png=to_png(np.full((HEIGHT, WIDTH, 3), 130, dtype=np.uint8)))
    black = Picture(kind="depth", png=to_png(np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)))
    for picture in (empty, black):
        assert np.abs(evidence([picture], HANDLES, acuity=64)).max() < 0.01


def test_misreads_come_as_pictures_get_coarser():
    drawn = [(coloured(positions, seed), positions) for seed, positions in enumerate(ALL[::2])]
    rates = [
        (np.array([right([picture], positions, acuity) for picture, positions in drawn]) < 0).mean()
        for acuity in (4, 5, 8, 64)
    ]
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 0.15
    assert rates[-2:] == [0, 0]


@pytest.mark.parametrize("kind", [coloured, grey])
def test_a_view_that_moved_is_read_rightly_where_pixels_are_small(kind):
    """Places are known where handles would be seen if the view had not moved."""
    apart = np.linalg.norm(np.subtract(*HANDLES[0]))
    for seed, positions in enumerate(ALL[1:-1:9]):
        picture = from_png(kind(positions, seed).png)
        for across, down in ((0.4, 0), (0, -0.4), (-0.3, 0.3)):
            shift = (round(down * apart), round(across * apart))
            moved = Picture(kind=kind(positions, seed).kind, png=to_png(np.roll(picture, shift, axis=(0, 1))))
            assert right([moved], positions, acuity=160).min() > 0.5


@pytest.mark.parametrize("kind", [coloured, grey])
def test_it_is_read_alike_however_its_file_was_written(kind):
    """Another Pillow or zlib writes other bytes for the same pixels."""
    for seed, positions in enumerate(ALL[::3]):
        picture = kind(positions, seed)
        file = io.BytesIO()
        Image.fromarray(from_png(picture.png)).save(file, "PNG", compress_level=9)
        again = replace(picture, png=file.getvalue())
        assert again.name != picture.name
        assert evidence([again], HANDLES, acuity=5) == evidence([picture], HANDLES, acuity=5)


@pytest.mark.parametrize("gaze", [(0.0, 0.0), (0.25, 0.8)])
@pytest.mark.parametrize("width", [1, 7, 16, 39])
def test_scaling_down_averages_over_areas(width, gaze):
    """A slope stays the same slope: each whole coarse pixel is as bright as the picture is in its middle."""
    rows, columns = 30, 40
    slope = np.broadcast_to(np.arange(columns) + 0.5, (rows, columns))[..., None]
    small = shrunk(slope, width, gaze)
    size = columns / width
    middles = (np.arange(small.shape[1]) + 0.5 - gaze[0]) * size
    assert small.shape[0] == np.ceil(rows / size + gaze[1])
    assert np.allclose(small[:, 1:-1, 0], middles[1:-1], rtol=0, atol=0.126 / size)  # fine pixels are steps
    even = np.full((30, 40, 2), 0.7)
    assert np.allclose(shrunk(even, width, gaze), 0.7)
    assert shrunk(even, 40) is shrunk(even, 4000) is even  # it never scales up
