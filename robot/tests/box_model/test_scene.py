"""What others rely on in a scene: names, places, what touches what."""

import subprocess
import sys
from dataclasses import replace
from typing import get_args

import mujoco
import numpy as np
import pytest
from box_model.scenes import mechanism_of, scene_of
from lockprobe_robot.box_model.appearance import HandleShape, appearance_of
from lockprobe_robot.box_model.mounted_joint import KNOB_RADIUS, KNOB_TOP
from lockprobe_robot.box_model.scene import EYE, TIMESTEP, add_handle, build_scene
from lockprobe_robot.geom_groups import HIDDEN, PANEL
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.trial.pictures.frame import Camera


def test_knobs_are_where_the_panel_says_they_are():
    for name, tilt in (("chain-4", 20), ("branched", 45)):
        mechanism, model, data = mechanism_of(box(name), tilt=tilt)
        panel = scene_of(box(name), tilt=tilt).panel
        for position in (False, True):
            mechanism.set_configuration((position,) * len(panel.mounted_joints))
            for i in range(len(panel.mounted_joints)):
                expected = panel.pose[:3, :3] @ panel.handles[i, int(position)] + panel.pose[:3, 3]
                assert data.site(f"knob-{i}").xpos == pytest.approx(expected, abs=1e-6)
                assert model.joint(f"joint-{i}").range == pytest.approx([0, panel.mounted_joints[i].travel])


def test_the_scene_itself_touches_nothing_but_what_locks():
    _, model, _ = mechanism_of(box("chain-4"))
    assert model.opt.timestep == TIMESTEP <= 0.002
    pairs = {
        model.geom(g).name.split("-")[0] for pair in zip(model.pair_geom1, model.pair_geom2, strict=True) for g in pair
    }
    assert pairs == {"pin", "block"}
    for first in range(model.ngeom):
        for second in range(model.ngeom):
            assert not model.geom_contype[first] & model.geom_conaffinity[second]
    assert all(model.geom_contype[model.geom(name).id] == PANEL for name in ("board", "knob-0", "ground"))


def test_all_that_locks_is_behind_the_board_and_unseen():
    for name in ("chain-4", "common-cause-4", "gray-code-8"):
        scene = scene_of(box(name))
        model = scene.spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        for i in range(model.ngeom):
            if model.geom(i).name.split("-")[0] in {"pin", "block", "lifter", "crossbar"}:
                assert model.geom_group[i] == HIDDEN
                inside = scene.panel.pose[:3, :3].T @ (data.geom_xpos[i] - scene.panel.pose[:3, 3])
                assert -scene.panel.depth < inside[2] < -0.01


def test_looks_change_nothing_that_can_be_touched():
    plain, varied = (scene_of(box("chain-4"), seed=5, looks=looks).spec.compile() for looks in ("plain", "varied"))
    for what in ("body_mass", "body_inertia", "dof_armature", "dof_damping", "dof_frictionloss", "jnt_range"):
        assert (getattr(plain, what) == getattr(varied, what)).all(), what
    hands_on = [model.geom_size[model.geom_contype != 0] for model in (plain, varied)]
    assert (hands_on[0] == hands_on[1]).all()
    assert (plain.tex_data[:3000] != varied.tex_data[:3000]).any()


def test_the_same_seed_gives_the_same_model():
    first, second, other = (scene_of(box("random-5-1"), seed=seed, looks="varied").spec.compile() for seed in (7, 7, 8))
    for what in ("body_pos", "geom_size", "geom_pos", "geom_rgba", "cam_pos", "light_pos", "eq_data", "tex_data"):
        assert (getattr(first, what) == getattr(second, what)).all(), what
    assert (first.tex_data != other.tex_data).any()


def test_friction_is_a_multiple_of_the_usual():
    once, thrice = (scene_of(box("chain-4"), friction=friction).spec.compile() for friction in (1.0, 3.0))
    joints = [once.joint(f"joint-{i}").dofadr[0] for i in range(4)]
    assert thrice.dof_frictionloss[joints] == pytest.approx(3 * once.dof_frictionloss[joints])


def test_labels_have_to_fit_the_joints():
    with pytest.raises(BadValue, match="labels.*one for each of 4 joints"):
        build_scene(box(), labels=("A",), settings=SceneSettings(), rng=np.random.default_rng(1))


def test_a_scene_is_made_without_any_graphics():
    code = (
        "import sys, numpy, lockprobe_robot.box_model.scene as board, lockprobe_robot.twin_settings as s, lockprobe;"
        "board.build_scene(lockprobe.box(), labels=tuple('ABCD'), settings=s.SceneSettings(),"
        " rng=numpy.random.default_rng(1)).spec.compile();"
        "print([m for m in sys.modules if m.startswith(('OpenGL', 'mujoco.egl'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


PLAIN = appearance_of(SceneSettings(), np.random.default_rng(1))


@pytest.mark.parametrize("shape", get_args(HandleShape))
def test_every_shape_is_the_same_to_the_touch_and_lies_within_it(shape):
    spec = mujoco.MjSpec()
    part = spec.worldbody.add_body(name="part")
    part.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    add_handle(part, 3, np.array([0.02, 0.0]), replace(PLAIN, handle=shape))
    model = spec.compile()
    knob = model.geom("knob-3")
    assert knob.pos[2] + knob.size[1] + knob.size[0] == pytest.approx(KNOB_TOP)
    assert knob.size[0] == KNOB_RADIUS
    assert model.body_mass[1] == pytest.approx(0.105, abs=0.001)
    assert [bool(bits) for bits in model.geom_contype] == [i == knob.id for i in range(model.ngeom)]
    assert model.site_pos[model.site("knob-3").id] == pytest.approx([0.02, 0, KNOB_TOP])
    seen = [i for i in range(model.ngeom) if model.geom_group[i] != HIDDEN]
    assert (knob.id in seen) == (shape == "round")
    ball, square, capsule = (int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")) for kind in ("SPHERE", "BOX", "CAPSULE"))
    reaches, tops = [], []
    for kind, size, place in zip(model.geom_type[seen], model.geom_size[seen], model.geom_pos[seen], strict=True):
        reaches.append(np.hypot(*size[:2]) if kind == square else size[0])
        tops.append(place[2] + size[{ball: 0, square: 2}.get(int(kind), 1)] + size[0] * (kind == capsule))
    assert max(reaches) == pytest.approx(KNOB_RADIUS)
    assert max(tops) == pytest.approx(KNOB_TOP)


@pytest.mark.parametrize(("name", "tilt"), [("chain-2", 0), ("chain-4", 20), ("chain-8", 60), ("branched", 60)])
def test_the_camera_sees_the_whole_board_with_a_margin(name, tilt):
    scene = scene_of(box(name), tilt=tilt)
    model = scene.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    seen = model.camera(EYE).id
    turn = data.cam_xmat[seen].reshape(3, 3) @ np.diag([1, -1, -1])
    pose = np.eye(4)
    pose[:3, :3] = turn.T @ scene.panel.pose[:3, :3]
    pose[:3, 3] = turn.T @ (scene.panel.pose[:3, 3] - data.cam_xpos[seen])
    focal = 240 / np.tan(np.radians(model.cam_fovy[seen]) / 2)
    half = np.array([*scene.panel.size, 0]) / 2
    corners = half * [[x, y, 0] for x in (-1, 1) for y in (-1, 1)]
    points = Camera(width=640, height=480, focal=focal, panel=pose).project(corners)
    share = np.abs(points[:, :2] - (319.5, 239.5)) / (320, 240)
    assert 0.75 < share.max() < 0.85
    assert points[1, 1] < points[0, 1], "up on the panel is up in the picture"
    assert points[2, 0] > points[0, 0], "right on the panel is right in the picture"


def test_a_wide_picture_is_used_to_its_sides_and_a_tall_one_too():
    """Each is filled in one direction, so that the angle of sight differs with the shape of the picture."""
    shares = []
    for width, height in ((960, 240), (640, 480), (240, 960)):
        scene = scene_of(box("chain-4"), width=width, height=height)
        model = scene.spec.compile()
        eye = model.camera(EYE)
        up = np.tan(np.radians(eye.fovy[0]) / 2) * np.linalg.norm(eye.pos - scene.panel.pose[:3, 3])
        shares.append([scene.panel.size[0] / 2 / (up * width / height), scene.panel.size[1] / 2 / up])
    assert all(0.7 < max(share) < 0.9 for share in shares)
    assert [share[1] == max(share) for share in shares] == [True, False, False]


def test_one_camera_sees_board_and_arm_from_aside():
    scene = scene_of(box("chain-4"))
    model = scene.spec.compile()
    film = model.camera("oblique")
    pose = np.zeros(9)
    mujoco.mju_quat2Mat(pose, film.quat)
    half = np.tan(np.radians(film.fovy[0]) / 2)
    for point in (scene.panel.pose[:3, 3], np.array([0.0, 0.0, 0.3])):
        right, up, back = pose.reshape(3, 3).T @ (point - film.pos)
        assert back < 0
        assert abs(up / back) < half
        assert abs(right / back) < half * 4 / 3
