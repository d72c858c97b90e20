"""Positions from pictures: read rightly, or not at all."""

import itertools

import numpy as np
import pytest
from drawn_board import HANDLES, board
from lockprobe_robot.hardware.camera import Shot
from lockprobe_robot.hardware.position_reader import Unclear, read_handles, read_positions
from plants.person import handles_text

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile

FIVE = box("random-5-3")
ALL = list(itertools.product((False, True), repeat=5))


def test_every_configuration_is_read():
    for seed, positions in enumerate(ALL[::4]):
        assert read_positions(Shot(rgb=board(positions, seed)), HANDLES, FIVE.names) == positions


def test_a_handle_in_the_middle_or_covered_is_unclear_and_named():
    picture = board((0,) * 5)
    (column, top), (_, bottom) = HANDLES[2]
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
    for place in (top, bottom):
        picture[(x - column) ** 2 + (y - place) ** 2 < 20**2] = 128
    with pytest.raises(Unclear, match=f"where {FIVE.names[2]} stands"):
        read_positions(Shot(rgb=picture), HANDLES, FIVE.names)


def test_a_file_of_handles_is_read_by_name(tmp_path):
    path = tmp_path / "handles.toml"
    path.write_text(handles_text(FIVE))
    assert read_handles(path, FIVE).places == HANDLES


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("width = 320", "width = true"), "width and height are True and 240"),
        (("at_1 = [40.0, 140.0]", ""), "at_1: got None, expected [column, row] inside 320 x 240"),
        (("at_1 = [40.0, 140.0]", "at_1 = [40, 240]"), "at_1: got [40, 240]"),
        (("at_1 = [40.0, 140.0]", "at_1 = [nan, 1]"), "at_1: got [nan, 1]"),
        (("at_1 = [40.0, 140.0]", "at_1 = [41, 91]"), "at_0 and at_1 are nearer than 8 pixels"),
        (("height = 240", "height = 240\n[lid]\n"), "has no joint"),
        (("width = 320", "width = "), "handles.toml"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(tmp_path, change, why):
    path = tmp_path / "handles.toml"
    path.write_text(handles_text(FIVE).replace(*change))
    with pytest.raises(BadFile) as caught:
        read_handles(path, FIVE)
    assert why in str(caught.value)
    assert "\n" not in str(caught.value)
