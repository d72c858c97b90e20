"""A hand gets to every handle in every configuration, and every label is seen to be whose it is."""

import itertools
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import TAG_SIDE, board_checksum, place_tags

from lockprobe import run_trial
from lockprobe.boxes.box import MAX_JOINTS
from lockprobe.boxes.boxfile import box_from_data
from lockprobe.boxes.families import STRUCTURES, box, generate
from lockprobe.foundation.errors import BadValue

LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
CHAIN = box("chain-4")
FEW = ("chain-4", "branched")


def drawn(layout):
    boxes = (generate("random-8", seed, layout=layout, dealt=True) for seed in range(1, 50))
    return [next(found for found in boxes if not isinstance(found, str))]


def fine_paths(panel):
    return [np.array([f.knob(x) for x in np.linspace(0, 1, 41)]) for f in panel.mounted_joints]


def apart(first, second):
    return np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)).min()


@pytest.mark.parametrize("boxes", [[box(name) for name in FEW], *map(drawn, LAYOUTS)], ids=["named", *LAYOUTS])
def test_handles_keep_apart_and_on_the_board(boxes):
    for drawn_box in boxes:
        panel = lay_out_panel(drawn_box)
        paths = fine_paths(panel)
        for path in paths:
            assert (np.abs(path) < np.array(panel.size) / 2 - 0.02).all()
        for first, second in itertools.combinations(paths, 2):
            assert apart(first, second) >= 0.072
        for i, label in enumerate(panel.labels):
            assert (np.abs(label) + 0.5 * panel.letter < np.array(panel.size) / 2).all()
            near = [apart(label[None], mounted.room()) for mounted in panel.mounted_joints]
            assert np.argmin(near) == i, "a label must be nearest to its own joint"


def test_every_named_box_has_a_panel_and_one_without_room_is_refused():
    for name in STRUCTURES:
        assert len(lay_out_panel(box(name)).mounted_joints) == len(box(name).joints) <= MAX_JOINTS
    text = (Path(__file__).parents[3] / "docs" / "boxes.md").read_text("utf-8")
    mine = box_from_data(tomllib.loads(text.split("```toml\n", 1)[1].split("```", 1)[0]))
    assert [joint.place for joint in mine.joints] == [joint.place for joint in CHAIN.joints]
    assert run_trial(box=mine, plant="twin", agent="human-inspired", max_steps=2).error is None
    crowded = replace(CHAIN, joints=tuple(replace(one, place=(i / 20, 0.5)) for i, one in enumerate(CHAIN.joints)))
    with pytest.raises(BadValue, match="places of the joints.*74 mm from middle to middle"):
        lay_out_panel(crowded)


@pytest.mark.parametrize("tilt", [0, 20, 45, 80])
def test_it_faces_the_robot_stands_above_the_ground_and_is_within_reach(tilt):
    panel = lay_out_panel(box("chain-8"), tilt=tilt, depth=0.18)
    right, up, out = panel.pose[:3, :3].T
    assert np.cross(right, up) == pytest.approx(out)
    assert math.degrees(math.acos(out[2])) == pytest.approx(tilt)
    assert out[0] <= 0
    back = np.array([[x, y, -0.18] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * (*panel.size, 1)
    assert panel.in_world(back)[:, 2].min() > 0
    tops = panel.in_world(panel.handles.reshape(-1, 3))
    assert np.hypot(tops[:, 0], tops[:, 1]).max() < 0.72


def test_the_way_of_a_handle_leads_from_end_to_end_of_the_board_wherever_that_is():
    drawn_panel = lay_out_panel(box("chain-4"))
    moved = replace(drawn_panel, pose=np.array([[0, -1, 0, 0.4], [1, 0, 0, -0.1], [0, 0, 1, 0.2], [0, 0, 0, 1.0]]))
    for panel, joint in itertools.product((drawn_panel, moved), range(4)):
        there, back = (panel.handle_path(joint, position) for position in (False, True))
        assert there.points == pytest.approx(back.points[::-1])
        assert there.points[[0, -1]] == pytest.approx(panel.in_world(panel.handles[joint]))
        assert (there.points - there.points[0]) @ there.axis == pytest.approx(0)
        assert there.axis == pytest.approx(-panel.pose[:3, 2])


@pytest.mark.parametrize("name", ["chain-2", "chain-4", "common-cause-3", "random-3-4"])
def test_tags_lie_one_in_each_quarter_of_the_board_under_no_part_and_the_checksum_is_of_dimensions(name):
    panel = lay_out_panel(box(name))
    tags, half = place_tags(panel), 0.625 * TAG_SIDE
    assert (np.abs(tags) + half < np.array(panel.size) / 2).all()
    for middle, path in itertools.product(tags, fine_paths(panel)):
        assert np.abs(path - middle).max(1).min() > half + 0.015
    assert [tuple(np.sign(middle)) for middle in tags] == [(-1, 1), (1, 1), (1, -1), (-1, -1)]
    assert board_checksum(panel) == board_checksum(lay_out_panel(box(name), tilt=25.0))
    assert board_checksum(panel) != board_checksum(lay_out_panel(box("chain-3")))
