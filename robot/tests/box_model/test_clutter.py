"""Clutter is in the picture, and neither in the way of a handle nor before it."""

import mujoco
import numpy as np
import pytest
from box_model.scenes import scene_of
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS, KNOB_TOP
from lockprobe_robot.box_model.view import view_of

from lockprobe.boxes.families import box

COUNT = 12


def cluttered(name, seed, count=COUNT, **settings):
    """The scene, its model, its state, and the geoms of clutter."""
    scene = scene_of(box(name), seed=seed, clutter=count, **settings)
    model = scene.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return scene, model, data, [model.geom(f"clutter-{number}").id for number in range(count)]


@pytest.mark.parametrize(
    ("name", "settings"),
    [("chain-4", {}), ("random-5-1", {"viewpoint": "oblique"}), ("branched", {"tilt": 60, "viewpoint": "oblique"})],
)
def test_no_handle_s_path_is_hidden_and_all_that_lies_about_is_in_the_picture(name, settings):
    for seed in (1, 2):
        scene, model, data, ids = cluttered(name, seed, **settings)
        panel = scene.panel
        eye = view_of(panel, scene.appearance, aspect=4 / 3)
        assert np.abs(eye.project(data.geom_xpos[ids])).max() < 1
        model.geom_group[:], model.geom_group[ids] = 0, 1
        only = np.array([0, 1, 0, 0, 0, 0], dtype=np.uint8)
        hit = np.zeros(1, dtype=np.int32)
        for mounted in panel.mounted_joints:
            for fraction in np.linspace(0, 1, 6):
                for turn in np.arange(4) * np.pi / 2:
                    rim = mounted.knob(fraction) + KNOB_RADIUS * np.array([np.cos(turn), np.sin(turn)])
                    for height in (0.0, KNOB_TOP / 2, KNOB_TOP):
                        point = panel.in_world(np.array([*rim, height]))
                        seen = mujoco.mj_ray(model, data, eye.position, point - eye.position, only, 1, -1, hit)
                        assert not 0 <= seen < 1, "clutter before a handle"


def test_it_lies_on_the_board_and_beside_it_and_away_from_parts_and_labels():
    scene, model, data, ids = cluttered("chain-4", 1)
    panel = scene.panel
    on_board = [i for i in ids if model.geom_bodyid[i] == model.body("panel").id]
    assert 3 <= len(on_board) <= len(ids) / 2
    swept = np.concatenate([mounted.path() for mounted in panel.mounted_joints])
    for geom in on_board:
        place, radius = model.geom_pos[geom][:2], model.geom_size[geom][0]
        assert (np.abs(place) + radius < np.array(panel.size) / 2).all()
        assert np.linalg.norm(swept - place, axis=1).min() > radius + KNOB_RADIUS
        assert np.linalg.norm(panel.labels - place, axis=1).min() > radius + panel.letter / 2
        assert model.geom_pos[geom][2] > 0
    assert all(0 < data.geom_xpos[i][2] < 0.05 for i in ids if i not in on_board)


def test_more_clutter_is_the_same_and_more_at_places_of_the_trial():
    few, many, other = (cluttered("chain-4", seed, count) for seed, count in ((1, 4), (1, COUNT), (2, 4)))
    places = [model.geom_pos[ids] for _, model, _, ids in (few, many, other)]
    np.testing.assert_array_equal(places[0], places[1][:4])
    assert np.abs(places[0] - places[2]).min(0).max() > 0.01


def test_it_can_only_be_seen():
    _, model, _, ids = cluttered("chain-4", 1)
    assert not model.geom_contype[ids].any()
    assert not model.geom_conaffinity[ids].any()
    plain = scene_of(box("chain-4"), seed=1).spec.compile()
    for what in ("nbody", "nv", "body_mass", "body_inertia", "dof_M0", "dof_invweight0"):
        assert np.array_equal(getattr(plain, what), getattr(model, what)), what
