"""A hand gets to every handle in every configuration, and every label is seen to be whose it is."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from lockprobe.errors import BadValue
from lockprobe.lockbox.box import MAX_JOINTS, Joint
from lockprobe.lockbox.families import box, named_boxes
from lockprobe.lockbox.generate import Recipe, Refused, generate
from lockprobe.plants.scene.fitting import BAR, KNOB_TOP
from lockprobe.plants.scene.panel import fit_panel
from lockprobe.plants.scene.placement import CAMERA_DISTANCE, camera_angle

LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
FEW = ("chain-2", "chain-4", "chain-8", "branched", "common-cause-4")


def drawn(layout):
    recipes = (Recipe(family="random-8", layout=layout, dealt=True, seed=seed) for seed in range(1, 50))
    return [found for found in map(generate, recipes) if not isinstance(found, Refused)][:2]


def fine_paths(panel):
    return [np.array([f.knob(x) for x in np.linspace(0, 1, 41)]) for f in panel.fittings]


def apart(first, second):
    return np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1)).min()


@pytest.mark.parametrize("boxes", [[box(name) for name in FEW], *map(drawn, LAYOUTS)], ids=["named", *LAYOUTS])
def test_handles_keep_apart_and_on_the_board(boxes):
    for drawn_box in boxes:
        panel = fit_panel(drawn_box)
        paths = fine_paths(panel)
        for path in paths:
            assert (np.abs(path) < np.array(panel.size) / 2 - 0.02).all()
        for first, second in itertools.combinations(paths, 2):
            assert apart(first, second) >= 0.072
        for i, label in enumerate(panel.labels):
            assert (np.abs(label) + 0.5 * panel.letter < np.array(panel.size) / 2).all()
            near = [apart(label[None], fitting.room()) for fitting in panel.fittings]
            assert np.argmin(near) == i, "a label must be nearest to its own joint"


def test_every_named_box_has_a_panel():
    assert all(len(fit_panel(box(name)).fittings) == len(box(name).joints) <= MAX_JOINTS for name in named_boxes())


@pytest.mark.parametrize("tilt", [0, 20, 60])
def test_no_label_is_under_a_part_or_behind_a_handle(tilt):
    panel = fit_panel(box("chain-4"), tilt=tilt)
    angle = camera_angle(math.radians(tilt))
    eye = CAMERA_DISTANCE * np.array([0, math.sin(angle), math.cos(angle)])
    heights = np.linspace(0, KNOB_TOP, 11)
    for label, path in itertools.product(panel.labels, fine_paths(panel)):
        for height in heights:
            hidden = path + (path - eye[:2]) * height / (eye[2] - height)
            assert apart(label[None], hidden) > 0.5 * panel.letter + 0.014
    for label, fitting in itertools.product(panel.labels, panel.fittings):
        if fitting.kind == "prismatic":
            offset = np.abs(label - np.array([fitting.knob(x) for x in np.linspace(0, 1, 41)]))
            assert (offset > np.array([BAR[1], BAR[0]]) + 0.3 * panel.letter).any(1).all()


def test_letters_are_at_least_25_pixels_high():
    for name in ("chain-2", "chain-4", "chain-8", "branched"):
        panel = fit_panel(box(name))
        pixels_a_metre = min(0.84 * 640 / panel.size[0], 0.84 * 480 / panel.size[1])
        assert panel.letter * pixels_a_metre >= 25


def test_handles_stand_where_the_pose_and_the_fittings_say():
    panel = fit_panel(box("chain-4"), tilt=30)
    assert panel.handles.shape == (4, 2, 3)
    assert panel.handles[2, 1] == pytest.approx([*panel.fittings[2].knob(1.0), KNOB_TOP])
    turn = panel.pose[:3, :3]
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1)
    sine, cosine = math.sin(math.radians(30)), math.cos(math.radians(30))
    assert turn == pytest.approx(np.array([[0, cosine, -sine], [-1, 0, 0], [0, sine, cosine]]))


@pytest.mark.parametrize("tilt", [0, 20, 45, 80])
def test_the_case_stands_above_the_ground_within_reach(tilt):
    panel = fit_panel(box("chain-8"), tilt=tilt, depth=0.18)
    back = np.array([[x, y, -0.18] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * (*panel.size, 1)
    assert (back @ panel.pose[:3, :3].T + panel.pose[:3, 3])[:, 2].min() > 0
    tops = panel.handles.reshape(-1, 3) @ panel.pose[:3, :3].T + panel.pose[:3, 3]
    assert np.hypot(tops[:, 0], tops[:, 1]).max() < 0.72


def test_the_same_places_give_the_same_panel():
    first, second = fit_panel(box("chain-4")), fit_panel(replace(box("reset"), name="other"))
    assert first.fittings == second.fittings
    assert (first.labels == second.labels).all()


def test_joints_without_room_are_refused_with_the_reason():
    crowded = replace(box("chain-4"), joints=tuple(Joint(name=name, kind="revolute") for name in box("chain-4").names))
    with pytest.raises(BadValue, match="places of the joints.*74 mm from middle to middle"):
        fit_panel(crowded)
