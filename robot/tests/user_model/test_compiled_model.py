"""MuJoCo compiles a user's model within limits, and every model has a camera."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.user_model.compiled_model import CAMERA, compile_model
from lockprobe_robot.user_model.mjcf_file import read_model
from mjcf_models import OWN, written

from lockprobe.foundation.errors import BadFile


def test_an_error_of_mujoco_is_one_line_with_the_line_of_the_file(tmp_path):
    path = written(tmp_path, "<mujoco>\n<!-- two\nlines -->\n<worldbody>\n<geom\nsze='1'/></worldbody></mujoco>")
    with pytest.raises(BadFile, match=r"box.xml: .*unrecognized attribute: 'sze' Element 'geom', line 5") as refused:
        compile_model(read_model(path))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ({"head": "<option timestep='1e-9'/>"}, "timestep is 1e-09, expected 0.0002 to 0.01"),
        ({"head": "<option iterations='2000000000'/>"}, "iterations is 2e+09, expected 1 to 1000"),
        ({"head": "<size njmax='10000'/>"}, "memory in bytes is"),
        (
            {"head": "<asset><texture name='t' type='2d' builtin='flat' width='99999' height='1'/></asset>"},
            "99999 pixels along a texture",
        ),
        ({"head": "<visual><quality numslices='100000'/></visual>"}, "numslices is 100000"),
        ({"outside": "<geom size='1'/>" * 2000}, "2001 geoms, expected at most 2000"),
        ({"inside": "<geom size='nan'/>"}, "nan size in geom"),
        ({"inside": "<geom type='mesh' mesh='gone'/>"}, "gone"),
        ({"outside": "<camera name='lockprobe' projection='orthographic'/>"}, "camera 'lockprobe' is orthographic"),
        (
            {"outside": f"<body>{'<joint/>' * 3}<geom size='1'/></body>" * 70},
            "211 joints, expected at most",
        ),
    ],
)
def test_what_mujoco_refuses_or_would_take_hours_for_is_one_line(tmp_path, parts, why, capfd):
    with pytest.raises(BadFile) as refused:
        compile_model(read_model(written(tmp_path, **parts)))
    assert why in str(refused.value)
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")


def test_a_camera_in_the_file_is_taken():
    model = compile_model(read_model(OWN))
    assert model.ncam == 1
    assert model.camera(CAMERA).pos == pytest.approx([-0.01, 0, 0.62])


def test_without_one_it_is_the_free_view_of_mujoco(tmp_path):
    model = compile_model(read_model(written(tmp_path, outside="<geom size='.1' pos='.5 0 .2'/>")))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    views = []
    for fixed in (True, False):
        camera, scene = mujoco.MjvCamera(), mujoco.MjvScene(model, 10)
        if fixed:
            camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera(CAMERA).id
        else:
            mujoco.mjv_defaultFreeCamera(model, camera)
        mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
        eyes = scene.camera
        views.append(
            [
                np.mean([eye.pos for eye in eyes], axis=0),
                np.mean([eye.forward for eye in eyes], axis=0),
                eyes[0].up,
                [eyes[0].frustum_top],
            ]
        )
    for fixed, free in zip(*views, strict=True):
        assert fixed == pytest.approx(free, abs=1e-5)
