"""The error of a view is luck times a size, and moves the camera by so much."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.rendering.opengl import ViewError, draw_view_error


def test_a_larger_error_is_the_same_luck_enlarged_and_none_draws_as_much():
    streams = [np.random.default_rng(3) for _ in range(3)]
    none, small, large = (
        draw_view_error(shift, turn, rng)
        for (shift, turn), rng in zip(((0, 0), (0.001, 0.01), (0.003, 0.03)), streams, strict=True)
    )
    assert none is None
    np.testing.assert_allclose(large.shift, 3 * small.shift)
    np.testing.assert_allclose(large.turn, 3 * small.turn)
    assert len({rng.random() for rng in streams}) == 1


def test_its_size_is_a_standard_deviation_along_each_axis():
    rng = np.random.default_rng(1)
    drawn = [draw_view_error(0.002, 0.01, rng) for _ in range(2000)]
    assert np.std([error.shift for error in drawn], axis=0) == pytest.approx([0.002] * 3, rel=0.08)
    assert np.std([error.turn for error in drawn], axis=0) == pytest.approx([0.01] * 3, rel=0.08)


def test_it_shifts_and_turns_the_camera_in_its_own_axes(table):
    data = mujoco.MjData(table)
    mujoco.mj_forward(table, data)
    eye = table.camera("above").id
    before, axes = data.cam_xpos[eye].copy(), data.cam_xmat[eye].reshape(3, 3).copy()
    ViewError(shift=np.array([0.01, 0, 0.02]), turn=np.array([0, 0, np.pi / 2])).move(data, eye)
    np.testing.assert_allclose(data.cam_xpos[eye] - before, axes @ [0.01, 0, 0.02], atol=1e-12)
    np.testing.assert_allclose(data.cam_xmat[eye].reshape(3, 3), axes @ [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
