"""Tags lie on the board where nothing covers them, and the checksum follows the board."""

import numpy as np
import pytest
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import TAG_SIDE, board_checksum, place_tags

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue


@pytest.mark.parametrize("name", ["chain-2", "chain-4", "common-cause-3", "random-3-4"])
def test_every_tag_with_its_border_is_on_the_board_and_under_no_part(name):
    panel = lay_out_panel(box(name))
    tags = place_tags(panel)
    half = 0.625 * TAG_SIDE
    assert (np.abs(tags.middles) + half < np.array(panel.size) / 2).all()
    for middle in tags.middles:
        for mounted in panel.mounted_joints:
            for knob in mounted.path():
                assert np.abs(knob - middle).max() > half + 0.015
    assert [tuple(np.sign(middle)) for middle in tags.middles] == [(-1, 1), (1, 1), (1, -1), (-1, -1)]


def test_corners_run_clockwise_from_the_upper_left():
    corners = place_tags(lay_out_panel(box("chain-4"))).corners
    assert corners.shape == (4, 4, 3)
    for square in corners:
        np.testing.assert_allclose(square[1] - square[0], [TAG_SIDE, 0, 0])
        np.testing.assert_allclose(square[2] - square[1], [0, -TAG_SIDE, 0])
        np.testing.assert_allclose(square[3] - square[2], [-TAG_SIDE, 0, 0])


def test_tags_that_have_no_room_are_refused():
    with pytest.raises(BadValue, match="tags: got '150 mm'"):
        place_tags(lay_out_panel(box("chain-4")), side=0.15)


def test_the_checksum_changes_with_dimensions_alone():
    def checksum(name, side=TAG_SIDE, tilt=20.0):
        panel = lay_out_panel(box(name), tilt=tilt)
        return board_checksum(panel, place_tags(panel, side))

    assert checksum("chain-2") == checksum("chain-2", tilt=25.0)
    assert len({checksum("chain-4"), checksum("chain-2"), checksum("chain-2", side=0.03)}) == 3
