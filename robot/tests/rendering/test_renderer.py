"""Whatever draws a model: depth is metric, only what is shown is seen, and looking changes nothing."""

import os

import mujoco
import numpy as np
import pytest
from lockprobe_robot.geom_groups import SHOWN_GROUPS
from lockprobe_robot.rendering.opengl import shown_options, shown_state
from lockprobe_robot.rendering.probe import open_renderer, renderer_name


def test_a_state_is_shown_as_it_is_and_stays_as_it_was(lockbox_model):
    data, seen = mujoco.MjData(lockbox_model), mujoco.MjData(lockbox_model)
    data.qpos[:] = np.linspace(0.01, 0.05, lockbox_model.nq)
    everything = mujoco.mjtState.mjSTATE_INTEGRATION
    before = np.empty(mujoco.mj_stateSize(lockbox_model, everything))
    after = before.copy()
    mujoco.mj_getState(lockbox_model, data, before, everything)
    stale = data.geom_xpos.copy()
    shown_state(lockbox_model, data, seen)
    mujoco.mj_getState(lockbox_model, data, after, everything)
    np.testing.assert_array_equal(after, before)
    np.testing.assert_array_equal(data.geom_xpos, stale)
    mujoco.mj_forward(lockbox_model, data)
    for what in ("geom_xpos", "geom_xmat", "cam_xpos", "cam_xmat", "light_xpos", "light_xdir"):
        np.testing.assert_array_equal(getattr(seen, what), getattr(data, what), what)
    assert (seen.geom_xpos != stale).any()


def test_things_that_hang_on_mocap_bodies_are_shown_where_they_are_put():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='hand' mocap='true'><geom size='.1'/></body></worldbody></mujoco>"
    )
    data, seen = mujoco.MjData(model), mujoco.MjData(model)
    data.mocap_pos[0] = (1, 2, 3)
    shown_state(model, data, seen)
    np.testing.assert_array_equal(seen.geom_xpos[0], (1, 2, 3))


def test_options_show_the_shown_groups_and_no_sites_or_tendons():
    options = shown_options()
    assert tuple(map(bool, options.geomgroup)) == SHOWN_GROUPS
    assert not options.sitegroup.any()
    assert not options.flags[mujoco.mjtVisFlag.mjVIS_TENDON]


def pixel(model, camera, point, *, width=160, height=120):
    """Row and column at which a camera that looks straight down sees a point."""
    eye = model.camera(camera)
    focal = 0.5 * height / np.tan(0.5 * np.radians(eye.fovy[0]))
    away = eye.pos[2] - point[2]
    column = (width - 1) / 2 + focal * (point[0] - eye.pos[0]) / away
    row = (height - 1) / 2 - focal * (point[1] - eye.pos[1]) / away
    return round(row), round(column)


POINTS = {
    "the table": ((0, 0, 0), 1.5),
    "the tower on the brick, neither of which collides": ((-0.2, 0.2, 0.2), 1.3),
    "the brick": ((-0.235, 0.2, 0.1), 1.4),
    "the ball": ((0.2, 0.2, 0.12), 1.38),
    "the pill": ((0.2, -0.2, 0.08), 1.42),
}


def test_depth_is_metres_along_the_axis_and_hidden_things_are_not_seen(table, table_renderer, state):
    _, seen = table_renderer.render(state(table), "above")
    for what, (point, depth) in POINTS.items():
        assert seen[pixel(table, "above", point)] == pytest.approx(depth, abs=1e-3), what


def test_a_mesh_lies_where_the_model_has_it(table, table_renderer, state):
    # A third of the way up the wedge's slope x + y + z = 0.2, in its own frame.
    turn = np.radians(30)
    inside = np.array([0.08, 0.06, 0.06])
    x = -0.2 + np.cos(turn) * inside[0] - np.sin(turn) * inside[1]
    y = -0.25 + np.sin(turn) * inside[0] + np.cos(turn) * inside[1]
    _, seen = table_renderer.render(state(table), "above")
    assert seen[pixel(table, "above", (x, y, inside[2]))] == pytest.approx(1.5 - inside[2], abs=5e-3)


def test_what_moves_is_seen_where_it_is(table, table_renderer, state):
    before, _ = table_renderer.render(state(table, 0.0), "above")
    _, seen = table_renderer.render(state(table, 0.1), "above")
    assert seen[pixel(table, "above", (-0.1, 0.2, 0.2))] == pytest.approx(1.3, abs=1e-3)
    assert seen[pixel(table, "above", (-0.24, 0.2, 0))] == pytest.approx(1.5, abs=1e-3)
    again, _ = table_renderer.render(state(table, 0.0), "above")
    np.testing.assert_array_equal(again, before)


def test_the_sky_has_no_depth_and_its_own_colour(table, table_renderer, state):
    rgb, depth = table_renderer.render(state(table), "sky")
    assert not depth.any()
    assert rgb.dtype == np.uint8
    assert np.abs(rgb.astype(int) - [0, 0, 255]).max() <= 1


def test_shape_is_height_by_width(table, opens, state):
    rgb, depth = opens(table, width=96, height=64).render(state(table), "above")
    assert rgb.shape == (64, 96, 3)
    assert depth.shape == (64, 96)
    assert depth.dtype == np.float32


def test_looking_leaves_the_simulation_as_it_was_to_the_last_bit(lockbox_model, opens, state):
    data, other = state(lockbox_model), state(lockbox_model)
    renderer = opens(lockbox_model)
    for _ in range(5):
        mujoco.mj_step(lockbox_model, data)
        renderer.render(data, "rgbd")
        mujoco.mj_step(lockbox_model, other)
    assert data.qpos.tobytes() == other.qpos.tobytes()
    assert data.xpos.tobytes() == other.xpos.tobytes()
    assert data.qacc_warmstart.tobytes() == other.qacc_warmstart.tobytes()


def test_two_renderers_at_once_do_not_disturb_each_other(table, lockbox_model, table_renderer, opens, state):
    first, second = table_renderer, opens(lockbox_model)
    alone = first.render(state(table), "above")
    second.render(state(lockbox_model), "rgbd")
    again = first.render(state(table), "above")
    np.testing.assert_array_equal(alone[0], again[0])
    np.testing.assert_array_equal(alone[1], again[1])


def test_no_environment_variable_is_left_behind(table, opens, state):
    before = dict(os.environ)
    opens(table).render(state(table), "above")
    assert dict(os.environ) == before


def test_what_is_opened_is_what_was_named(table):
    opened = open_renderer(table, width=64, height=64)
    assert renderer_name() == opened.name
    opened.close()
