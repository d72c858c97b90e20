"""A hand gets to every handle in every configuration, and every label is seen to be whose it is."""

import itertools
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from lockprobe_robot.box_model.mounted_joint import BAR, KNOB_TOP
from lockprobe_robot.box_model.panel import CAMERA_DISTANCE, camera_angle, lay_out_panel, panel_pose

from lockprobe.boxes.box import MAX_JOINTS, Joint
from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.generate import Recipe, RefusedRecipe, generate
from lockprobe.foundation.errors import BadValue

LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
FEW = ("chain-2", "chain-4", "chain-8", "branched", "common-cause-4")


def drawn(layout):
    recipes = (Recipe(family="random-8", layout=layout, dealt=True, seed=seed) for seed in range(1, 50))
    return [next(found for found in map(generate, recipes) if not isinstance(found, RefusedRecipe))]


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


def test_every_named_box_has_a_panel():
    assert all(
        len(lay_out_panel(box(name)).mounted_joints) == len(box(name).joints) <= MAX_JOINTS for name in named_boxes()
    )


@pytest.mark.parametrize("tilt", [0, 20, 60])
def test_no_label_is_under_a_part_or_behind_a_handle(tilt):
    panel = lay_out_panel(box("chain-4"), tilt=tilt)
    angle = camera_angle(math.radians(tilt))
    eye = CAMERA_DISTANCE * np.array([0, math.sin(angle), math.cos(angle)])
    heights = np.linspace(0, KNOB_TOP, 11)
    for label, path in itertools.product(panel.labels, fine_paths(panel)):
        for height in heights:
            hidden = path + (path - eye[:2]) * height / (eye[2] - height)
            assert apart(label[None], hidden) > 0.5 * panel.letter + 0.014
    for label, mounted in itertools.product(panel.labels, panel.mounted_joints):
        if mounted.kind == "prismatic":
            offset = np.abs(label - np.array([mounted.knob(x) for x in np.linspace(0, 1, 41)]))
            assert (offset > np.array([BAR[1], BAR[0]]) + 0.3 * panel.letter).any(1).all()


def test_letters_are_at_least_25_pixels_high():
    for name in ("chain-2", "chain-4", "chain-8", "branched"):
        panel = lay_out_panel(box(name))
        pixels_a_metre = min(0.84 * 640 / panel.size[0], 0.84 * 480 / panel.size[1])
        assert panel.letter * pixels_a_metre >= 25


def test_handles_stand_where_the_pose_and_the_fittings_say():
    panel = lay_out_panel(box("chain-4"), tilt=30)
    assert panel.handles.shape == (4, 2, 3)
    assert panel.handles[2, 1] == pytest.approx([*panel.mounted_joints[2].knob(1.0), KNOB_TOP])
    turn = panel.pose[:3, :3]
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1)
    sine, cosine = math.sin(math.radians(30)), math.cos(math.radians(30))
    assert turn == pytest.approx(np.array([[0, cosine, -sine], [-1, 0, 0], [0, sine, cosine]]))


@pytest.mark.parametrize("tilt", [0, 20, 45, 80])
def test_the_case_stands_above_the_ground_within_reach(tilt):
    panel = lay_out_panel(box("chain-8"), tilt=tilt, depth=0.18)
    back = np.array([[x, y, -0.18] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * (*panel.size, 1)
    assert (back @ panel.pose[:3, :3].T + panel.pose[:3, 3])[:, 2].min() > 0
    tops = panel.handles.reshape(-1, 3) @ panel.pose[:3, :3].T + panel.pose[:3, 3]
    assert np.hypot(tops[:, 0], tops[:, 1]).max() < 0.72


def test_the_same_places_give_the_same_panel():
    first, second = lay_out_panel(box("chain-4")), lay_out_panel(replace(box("reset"), name="other"))
    assert first.mounted_joints == second.mounted_joints
    assert (first.labels == second.labels).all()


def test_joints_without_room_are_refused_with_the_reason():
    crowded = replace(box("chain-4"), joints=tuple(Joint(name=name, kind="revolute") for name in box("chain-4").names))
    with pytest.raises(BadValue, match="places of the joints.*74 mm from middle to middle"):
        lay_out_panel(crowded)


SIZE = (0.56, 0.28)
DEGREES = [0, 10, 20, 30, 45, 60, 80]


@pytest.mark.parametrize("degrees", DEGREES)
def test_a_panel_faces_who_stands_before_it_and_clears_the_ground(degrees):
    tilt = math.radians(degrees)
    pose = panel_pose(SIZE, tilt, depth=0.1)
    right, up, out = pose[:3, :3].T
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3))
    assert np.allclose(np.cross(right, up), out)
    assert np.allclose(right, [0, -1, 0])
    assert math.degrees(math.acos(out[2])) == pytest.approx(degrees)
    assert out[0] <= 0
    corners = [
        pose[:3, 3] + x * right + y * up - z * out for x in (-0.28, 0.28) for y in (-0.14, 0.14) for z in (0, 0.1)
    ]
    assert min(corner[2] for corner in corners) > 0.02


def test_steeper_panels_stand_higher():
    heights = [panel_pose(SIZE, math.radians(degrees), depth=0.06)[2, 3] for degrees in DEGREES]
    assert heights[:3] == [heights[0]] * 3
    assert all(low < high for low, high in pairwise(heights[2:]))


def test_the_camera_follows_the_panel_as_far_as_it_can():
    angles = [math.degrees(camera_angle(math.radians(degrees))) for degrees in DEGREES]
    assert angles == pytest.approx([0, 10, 12, 12, 12, 20, 40])
