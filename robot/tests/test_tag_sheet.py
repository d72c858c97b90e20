"""The printed tags are found again, and have their size on paper."""

import io

import numpy as np
import pytest
from lockprobe_robot.tag_sheet import tag_sheet

from lockprobe.foundation.errors import BadValue

DPI = 150


def raster(figure):
    from PIL import Image

    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return np.asarray(Image.open(file).convert("L"))


def test_tags_are_found_again_in_a_raster_of_the_sheet_with_their_size():
    pytest.importorskip("cv2")
    from lockprobe_robot.calibration.opencv import find_tags, tag_bits

    numbers = (0, 1, 2, 3, 586)
    picture = raster(tag_sheet(tag_bits(numbers), numbers, 40.0))
    assert picture.shape == pytest.approx((297 / 25.4 * DPI, 210 / 25.4 * DPI), abs=1)
    found = dict(find_tags(picture))
    assert sorted(found) == list(numbers)
    for corners in found.values():
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1) / DPI * 25.4
        np.testing.assert_allclose(sides, 40.0, atol=0.2)
        assert corners[0, 0] < corners[1, 0] - 100  # upright: the first corner is the upper left one
        assert corners[0, 1] < corners[3, 1] - 100


def test_black_cells_touch_without_a_gap():
    cells = np.zeros((1, 8, 8), dtype=bool)
    picture = raster(tag_sheet(cells, [0], 40.0))
    rows, columns = np.nonzero(picture < 10)
    inside = picture[200 : rows[columns < 400].min() + 100, 160:300]
    black = inside[(inside < 10).any(1)]
    assert (black[2:, 20:-20] < 10).all()


def test_every_tag_says_its_number_and_size():
    figure = tag_sheet(np.zeros((2, 8, 8), dtype=bool), [7, 11], 25.0)
    words = [text.get_text() for text in figure.axes[0].texts]
    for number in (7, 11):
        assert f"AprilTag 36h11, number {number}: 25 mm" in words


def test_tags_that_do_not_fit_are_refused():
    with pytest.raises(BadValue, match="tags: got '4 of 100 mm', expected at most 1 of this size on A4"):
        tag_sheet(np.zeros((4, 8, 8), dtype=bool), range(4), 100.0)
