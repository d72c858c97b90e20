"""What others rely on in a scene: names, places, what touches what, and that looks change nothing of that."""

import mujoco
import numpy as np
import pytest
from box_model.scenes import mechanism_of, scene_of
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS, KNOB_TOP
from lockprobe_robot.geom_groups import ARM, CAMERA, HIDDEN, NOTHING, PANEL, SHOWN_GROUPS

from lockprobe.boxes.families import box


def model_of(name="chain-4", seed=1, **settings):
    scene = scene_of(box(name), seed=seed, **settings)
    model = scene.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return scene, model, data


@pytest.mark.parametrize(("name", "tilt"), [("chain-4", 20), ("branched", 45)])
def test_knobs_are_where_the_panel_says_they_are(name, tilt):
    mechanism = mechanism_of(box(name), tilt=tilt)
    model, data = mechanism.model, mechanism.data
    panel = scene_of(box(name), tilt=tilt).panel
    for position in (False, True):
        mechanism.set_configuration((position,) * len(panel.mounted_joints))
        for joint, handle, mounted in zip(box(name).names, panel.handles, panel.mounted_joints, strict=True):
            assert data.site(joint).xpos == pytest.approx(panel.in_world(handle[int(position)]), abs=1e-6)
            assert model.joint(joint).range == pytest.approx([0, mounted.travel])


@pytest.mark.parametrize("name", ["chain-4", "common-cause-4", "gray-code-8"])
def test_nothing_of_it_touches_but_what_locks_behind_the_board_and_unseen(name):
    scene, model, data = model_of(name)
    pairs = zip(model.pair_geom1, model.pair_geom2, strict=True)
    touching = {model.geom(geom).name.split("-")[0] for pair in pairs for geom in pair}
    assert touching <= {"pin", "block", "lifter", "crossbar"}
    assert not (model.geom_contype[:, None] & model.geom_conaffinity).any()
    assert all(model.geom_contype[model.geom(part).id] == PANEL for part in ("board", "knob-0", "ground"))
    assert ARM & NOTHING == ARM & ARM >> 2 == 0
    for i in range(model.ngeom):
        if model.geom(i).name.split("-")[0] in touching:
            assert model.geom_group[i] == HIDDEN
            inside = scene.panel.pose[:3, :3].T @ (data.geom_xpos[i] - scene.panel.pose[:3, 3])
            assert -scene.panel.depth < inside[2] < -0.01
    assert not SHOWN_GROUPS[HIDDEN]


def test_the_same_seed_gives_the_same_model_and_another_one_another_and_friction_is_a_multiple():
    first, second, other = (model_of("random-5-1", seed=seed, looks="varied", clutter=3)[1] for seed in (7, 7, 8))
    for what in ("body_pos", "geom_size", "geom_pos", "geom_rgba", "cam_pos", "light_pos", "eq_data", "tex_data"):
        assert (getattr(first, what) == getattr(second, what)).all(), what
    assert (first.tex_data != other.tex_data).any()
    once, thrice = (model_of(friction=friction)[1].dof_frictionloss for friction in (1.0, 3.0))
    assert thrice == pytest.approx(3 * once)


def in_picture(model, data, points):
    """Points of the world in the picture of the plant's camera of 4 by 3: -1 to 1 from left to right, and up."""
    eye = model.camera(CAMERA).id
    seen = (points - data.cam_xpos[eye]) @ data.cam_xmat[eye].reshape(3, 3)
    half = np.tan(np.radians(model.cam_fovy[eye]) / 2)
    return seen[..., :2] / (-seen[..., 2:] * (4 / 3 * half, half))


@pytest.mark.parametrize("viewpoint", ["plain", "oblique"])
@pytest.mark.parametrize(("name", "tilt"), [("chain-4", 20), ("chain-8", 60)])
def test_board_and_handles_are_in_the_picture_with_a_margin(name, tilt, viewpoint):
    scene, model, data = model_of(name, tilt=tilt, viewpoint=viewpoint)
    panel = scene.panel
    corners = np.array([[x, y, 0] for x in (-1, 1) for y in (-1, 1)]) * np.array([*panel.size, 0]) / 2
    seen = in_picture(model, data, panel.in_world(corners))
    assert 0.7 < np.abs(seen).max() < 0.87
    assert np.abs(in_picture(model, data, panel.in_world(panel.handles))).max() < 0.9
    assert seen[1, 1] > seen[0, 1], "up on the panel is up in the picture"
    assert seen[2, 0] > seen[0, 0], "right on the panel is right in the picture"


@pytest.mark.parametrize(("name", "settings"), [("chain-4", {}), ("branched", {"tilt": 60, "viewpoint": "oblique"})])
def test_clutter_lies_on_the_board_hides_no_handle_and_more_is_the_same_and_more(name, settings):
    scene, model, data = model_of(name, clutter=12, **settings)
    panel, ids = scene.panel, [model.geom(f"clutter-{number}").id for number in range(12)]
    assert (np.abs(model.geom_pos[ids][:, :2]) < np.array(panel.size) / 2).all()
    _, few, _ = model_of(name, clutter=4, **settings)
    assert (model.geom_pos[ids[:4]] == few.geom_pos[[few.geom(f"clutter-{number}").id for number in range(4)]]).all()
    model.geom_group[:], model.geom_group[ids] = 0, 1
    only, hit = np.array([0, 1, 0, 0, 0, 0], dtype=np.uint8), np.zeros(1, dtype=np.int32)
    eye = data.camera(CAMERA).xpos
    for mounted in panel.mounted_joints:
        for fraction, turn in np.stack(np.meshgrid(np.linspace(0, 1, 6), np.arange(4) * np.pi / 2), -1).reshape(-1, 2):
            rim = mounted.knob(fraction) + KNOB_RADIUS * np.array([np.cos(turn), np.sin(turn)])
            for height in (0.0, KNOB_TOP / 2, KNOB_TOP):
                point = panel.in_world(np.array([*rim, height]))
                seen = mujoco.mj_ray(model, data, eye, point - eye, only, 1, -1, hit)
                assert not 0 <= seen < 1, "clutter before a handle"
