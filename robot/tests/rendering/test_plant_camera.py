"""A plant's camera: pictures of one moment, where the camera is, when it opens a renderer, and the noise of depth."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.rendering import plant_camera as camera_module
from lockprobe_robot.rendering.plant_camera import PlantCamera, add_depth_noise
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.foundation.errors import PlantFault

RAYS = SceneSettings(width=64, height=64, depth_noise=0.002)
LARGE = SceneSettings(width=320, height=240)


@pytest.fixture
def camera(lockbox_scene, lockbox_model, state):
    """Makes a camera of the lockbox, with a stream of noise."""

    def make(data=None, settings=RAYS, **view):
        data = data or state(lockbox_model)
        return PlantCamera(
            lockbox_model,
            data,
            mechanism=Mechanism(lockbox_model, data, lockbox_scene),
            panel=lockbox_scene.panel,
            settings=settings,
            rng=np.random.default_rng(1),
            **view,
        )

    return make


def look(camera):
    return camera.look_now()()


def test_a_moment_can_be_looked_at_until_it_ends(camera):
    seen = camera()
    first, second = seen.look_now(), seen.look_now()
    np.testing.assert_array_equal(first().rgb, second().rgb)
    np.testing.assert_array_equal(first().rgb, first().rgb)
    seen.end_moment()
    for look in (first, second):
        with pytest.raises(PlantFault, match="after the next attempt"):
            look()
    assert seen.look_now()().rgb.shape == (64, 64, 3)


def test_the_renderer_is_a_fact_once_it_has_made_a_picture_and_stays_one(camera):
    seen = camera()
    look = seen.look_now()
    assert seen.facts["renderer"] is None
    frame = look()
    assert seen.facts["renderer"] == frame.renderer
    seen.close()
    assert seen.facts["renderer"] == frame.renderer


def test_the_fact_is_what_drew_and_not_what_was_asked_for(camera, monkeypatch):
    really = camera_module.open_renderer

    def another(*args, **options):
        renderer = really(*args, **options)
        renderer.name = "paint by numbers"
        return renderer

    monkeypatch.setattr(camera_module, "open_renderer", another)
    seen = camera()
    seen.look_now()()
    assert seen.facts["renderer"] == "paint by numbers"


def test_facts_are_engine_settings_and_renderer(camera):
    facts = camera().facts
    assert facts["engine"] == f"mujoco {mujoco.__version__}"
    assert (facts["width"], facts["depth_noise"], facts["mechanism"]) == (64, 0.002, "contact")


def test_a_look_that_is_refused_takes_no_luck(camera):
    one, other = camera(), camera()
    late = one.look_now()
    one.end_moment()
    with pytest.raises(PlantFault):
        late()
    np.testing.assert_array_equal(one.look_now()().depth, other.look_now()().depth)


@pytest.mark.parametrize("position", [0, 1])
def test_handles_are_seen_where_they_are(camera, lockbox_model, position):
    data = mujoco.MjData(lockbox_model)
    for joint in range(4):
        first = lockbox_model.joint(f"joint-{joint}")
        data.qpos[first.qposadr[0]] = first.range[position]
    mujoco.mj_forward(lockbox_model, data)
    frame = look(camera(data, LARGE))
    for column, row, depth in frame.camera.project(frame.handles[:, position]):
        assert frame.depth[round(row), round(column)] == pytest.approx(depth, abs=2e-3)
    elsewhere = frame.camera.project(frame.handles[:, 1 - position])
    for column, row, depth in elsewhere:
        assert frame.depth[round(row), round(column)] > depth + 0.01


def test_the_board_is_where_heights_are_zero(camera):
    frame = look(camera(settings=LARGE))
    heights = frame.camera.heights(frame.depth)
    assert (np.abs(heights) < 1e-3).mean() > 0.1
    assert heights[frame.depth < frame.camera.project(frame.handles)[..., 2].max()].max() < 0.055


def test_where_it_is_does_not_depend_on_what_was_computed_before(camera, lockbox_model):
    known, fresh = look(camera()), look(camera(mujoco.MjData(lockbox_model)))
    np.testing.assert_array_equal(fresh.camera.panel, known.camera.panel)


def test_nothing_is_opened_before_it_looks(camera, monkeypatch):
    opened = []
    really = camera_module.open_renderer

    def counted(*args, **options):
        opened.append(options["width"])
        return really(*args, **options)

    monkeypatch.setattr(camera_module, "open_renderer", counted)
    seen = camera(settings=SceneSettings(width=64, height=64))
    seen.close()
    assert opened == []
    first = look(seen)
    look(seen)
    assert opened == [64]
    assert first.renderer.startswith("egl (mujoco ")
    seen.close()
    again = look(seen)
    np.testing.assert_array_equal(first.rgb, again.rgb)
    np.testing.assert_array_equal(first.depth, again.depth)
    assert opened == [64, 64]


def test_noise_is_the_settings(camera):
    size = {"width": 160, "height": 120}
    clean = look(camera(settings=SceneSettings(**size)))
    noisy, again = (look(camera(settings=SceneSettings(**size, depth_noise=0.002))) for _ in range(2))
    board = (np.abs(clean.camera.heights(clean.depth)) < 1e-3) & (noisy.depth > 0)
    assert 0.0015 < np.std((noisy.depth - clean.depth)[board]) < 0.003
    np.testing.assert_array_equal(noisy.rgb, clean.rgb)
    np.testing.assert_array_equal(noisy.depth, again.depth)


def test_the_view_moves_with_every_picture_and_the_recorded_camera_does_not(camera):
    size = SceneSettings(width=160, height=120)
    steady, moved, turned = (camera(settings=size, **view) for view in ({}, {"jitter": 5.0}, {"turn": 1.0}))
    nominal = look(steady)
    for seen in (moved, turned):
        first, second = look(seen), look(seen)
        assert (first.rgb != nominal.rgb).any()
        assert (first.rgb != second.rgb).any()
        for frame in (first, second):
            assert (frame.camera.panel == nominal.camera.panel).all()
            board = np.abs(nominal.camera.heights(frame.depth)[40:80, 40:120])
            assert np.median(board) < 0.06, "it is still the board, not far away"


def test_the_noise_of_depth_is_the_same_luck_whether_the_view_moves_or_not(camera):
    flat = SceneSettings(width=64, height=64, depth_noise=0.002)
    still, moving = camera(settings=flat), camera(settings=flat, jitter=1e-6)
    for _ in range(2):
        np.testing.assert_allclose(look(still).depth, look(moving).depth, atol=2e-3)


FLAT = np.full((120, 160), 0.7, np.float32)


def sensed(depth, noise, seed=1):
    return add_depth_noise(depth.astype(np.float32), noise, np.random.default_rng(seed))


def test_without_noise_only_millimetres_are_rounded():
    depth = np.linspace(0.5, 0.9, 500, dtype=np.float32).reshape(20, 25)
    read = sensed(depth, 0.0)
    assert np.abs(read - depth).max() <= 0.000501
    np.testing.assert_allclose(read * 1000, np.rint(read * 1000), atol=1e-3)
    assert (read > 0).all()


@pytest.mark.parametrize("noise", [0.0, 0.0012, 0.05])
def test_equally_much_is_drawn_whatever_the_noise_is(noise):
    rng = np.random.default_rng(3)
    add_depth_noise(FLAT, noise, rng)
    other = np.random.default_rng(3)
    add_depth_noise(FLAT, 0.01, other)
    assert rng.random() == other.random()


def test_its_size_is_as_stated_and_grows_with_the_square_of_depth():
    assert np.std(sensed(FLAT, 0.004)) == pytest.approx(0.004, rel=0.03)
    assert np.std(sensed(2 * FLAT, 0.004)) == pytest.approx(0.016, rel=0.03)


def test_larger_noise_is_the_same_luck_enlarged():
    small, large = (sensed(FLAT, noise) - 0.7 for noise in (0.004, 0.008))
    assert np.abs(large - 2 * small).max() < 0.0016


def test_holes_are_along_edges_only():
    depth = FLAT.copy()
    depth[:, 80:] = 0.8
    lost = sensed(depth, 0.001) == 0
    assert lost[:, 79:81].mean() == pytest.approx(0.6, abs=0.1)
    assert not lost[:, :79].any()
    assert not lost[:, 81:].any()
    assert (sensed(depth, 0.0) > 0).all()


def test_nothing_stays_nothing():
    depth = FLAT.copy()
    depth[:60] = 0
    assert not sensed(depth, 0.01)[:59].any()
