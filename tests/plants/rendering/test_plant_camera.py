"""The camera of a plant knows where it is, and opens nothing before it looks."""

import mujoco
import numpy as np
import pytest

from lockprobe.errors import BadValue
from lockprobe.plants.rendering import plant_camera as eye_module
from lockprobe.plants.rendering.plant_camera import Eye
from lockprobe.plants.settings import SceneSettings

RAYS = SceneSettings(renderer="rays", width=320, height=240)


def look(eye, scene, data, seed=1):
    return eye.look(data, scene.panel.pose, scene.panel.handles, np.random.default_rng(seed))


@pytest.mark.parametrize("position", [0, 1])
def test_handles_are_seen_where_they_are(lockbox_scene, lockbox_model, position):
    data = mujoco.MjData(lockbox_model)
    for joint in range(4):
        first = lockbox_model.joint(f"joint-{joint}")
        data.qpos[first.qposadr[0]] = first.range[position]
    mujoco.mj_forward(lockbox_model, data)
    frame = look(Eye(lockbox_model, lockbox_scene.camera, RAYS), lockbox_scene, data)
    for column, row, depth in frame.camera.project(frame.handles[:, position]):
        assert frame.depth[round(row), round(column)] == pytest.approx(depth, abs=2e-3)
    elsewhere = frame.camera.project(frame.handles[:, 1 - position])
    for column, row, depth in elsewhere:
        assert frame.depth[round(row), round(column)] > depth + 0.01


def test_the_board_is_where_heights_are_zero(lockbox_scene, lockbox_model, state):
    frame = look(Eye(lockbox_model, lockbox_scene.camera, RAYS), lockbox_scene, state(lockbox_model))
    heights = frame.camera.heights(frame.depth)
    assert (np.abs(heights) < 1e-3).mean() > 0.1
    assert heights[frame.depth < frame.camera.project(frame.handles)[..., 2].max()].max() < 0.055


def test_where_it_is_does_not_depend_on_what_was_computed_before(lockbox_scene, lockbox_model, state):
    eye = Eye(lockbox_model, lockbox_scene.camera, RAYS)
    fresh = mujoco.MjData(lockbox_model)
    known = look(eye, lockbox_scene, state(lockbox_model)).camera.panel
    np.testing.assert_array_equal(look(eye, lockbox_scene, fresh).camera.panel, known)


def test_nothing_is_opened_before_it_looks(lockbox_scene, lockbox_model, state, monkeypatch):
    opened = []
    really = eye_module.open_renderer

    def counted(*args, **options):
        opened.append(options["choice"])
        return really(*args, **options)

    monkeypatch.setattr(eye_module, "open_renderer", counted)
    eye = Eye(lockbox_model, lockbox_scene.camera, RAYS)
    eye.close()
    assert opened == []
    first = look(eye, lockbox_scene, state(lockbox_model))
    look(eye, lockbox_scene, state(lockbox_model))
    assert opened == ["rays"]
    assert first.renderer.startswith("rays (mujoco ")
    eye.close()
    again = look(eye, lockbox_scene, state(lockbox_model))
    np.testing.assert_array_equal(first.rgb, again.rgb)
    np.testing.assert_array_equal(first.depth, again.depth)
    assert opened == ["rays", "rays"]


def test_noise_is_the_settings(lockbox_scene, lockbox_model, state):
    data = state(lockbox_model)
    clean = look(Eye(lockbox_model, lockbox_scene.camera, RAYS), lockbox_scene, data)
    noisy_eye = Eye(
        lockbox_model, lockbox_scene.camera, SceneSettings(renderer="rays", width=320, height=240, depth_noise=0.002)
    )
    noisy = look(noisy_eye, lockbox_scene, data)
    board = (np.abs(clean.camera.heights(clean.depth)) < 1e-3) & (noisy.depth > 0)
    assert 0.0015 < np.std((noisy.depth - clean.depth)[board]) < 0.003
    np.testing.assert_array_equal(noisy.rgb, clean.rgb)
    np.testing.assert_array_equal(noisy.depth, look(noisy_eye, lockbox_scene, data).depth)


def test_an_unknown_camera_is_refused(lockbox_model):
    with pytest.raises(BadValue, match="camera: got 'front', expected one of rgbd"):
        Eye(lockbox_model, "front", RAYS)
