"""Rays show what OpenGL shows."""

import mujoco
import numpy as np
import pytest

import lockprobe
from lockprobe.errors import BadValue
from lockprobe.plants.rendering.rays import RayCaster
from lockprobe.plants.scene.board import compile_scene
from lockprobe.plants.settings import SceneSettings

TOLERANCE = 2e-3
"""Metres by which depth may differ in all but a thousandth of the pixels."""


def both(model, data, camera, egl, *, width=320, height=240):
    drawn = egl(model, width=width, height=height).render(data, camera)
    return drawn, RayCaster(model, width=width, height=height).render(data, camera)


def ends(model, joints, configuration):
    """Data with every joint at its end."""
    data = mujoco.MjData(model)
    for joint in range(joints):
        first = model.joint(f"joint-{joint}")
        data.qpos[first.qposadr[0]] = first.range[1] if configuration[joint] else first.range[0]
    mujoco.mj_forward(model, data)
    return data


@pytest.mark.parametrize("configuration", [(0, 0, 0, 0), (1, 0, 1, 0), (0, 1, 1, 1)])
def test_depth_of_a_lockbox_agrees_but_for_a_thousandth(lockbox_model, configuration, egl):
    data = ends(lockbox_model, 4, configuration)
    (rgb, depth), (cast_rgb, cast_depth) = both(lockbox_model, data, "rgbd", egl)
    assert (np.abs(depth - cast_depth) > TOLERANCE).mean() <= 1e-3
    assert np.abs(rgb.astype(int) - cast_rgb).mean() < 3


@pytest.mark.parametrize("seed", [1, 2])
def test_varied_looks_agree_too(seed, egl):
    box = lockprobe.box("chain-4")
    settings = SceneSettings(looks="varied")
    scene = compile_scene(box, labels=tuple("ABCD"), settings=settings, rng=np.random.default_rng(seed))
    model = scene.spec.compile()
    (rgb, depth), (cast_rgb, cast_depth) = both(model, ends(model, 4, (0, 1, 0, 1)), scene.camera, egl)
    assert (np.abs(depth - cast_depth) > TOLERANCE).mean() <= 1e-3
    assert np.abs(rgb.astype(int) - cast_rgb).mean() < 3


def test_letters_on_the_board_are_as_sharp(lockbox_scene, lockbox_model, egl):
    data = ends(lockbox_model, 4, (0, 0, 0, 0))
    (rgb, _), (cast_rgb, _) = both(lockbox_model, data, "rgbd", egl, width=640, height=480)
    dark, cast_dark = (picture.mean(axis=2) < 60 for picture in (rgb, cast_rgb))
    assert dark.sum() > 1000
    assert (dark & cast_dark).sum() / (dark | cast_dark).sum() > 0.9


@pytest.mark.parametrize(
    "light",
    [
        'pos="-.5 0 2" dir=".25 0 -1" diffuse=".6 .6 .6"',
        'pos="0 0 2" dir=".5 .2 -1" type="directional" diffuse=".6 .5 .4" castshadow="false"',
        'pos="0 .5 2" dir="0 0 -1" castshadow="false" ambient=".2 .1 .1" cutoff="20" exponent="3"',
        'pos="0 .5 2" dir="0 0 -1" type="point" attenuation=".5 .1 .2" castshadow="false"',
        'active="false"',
    ],
)
def test_light_and_shadow(light, egl):
    ground = '<geom type="plane" size="1 1 .01"/><geom type="box" size=".1 .1 .1" pos="0 0 .3"/>'
    camera = '<camera name="above" pos="0 0 3" fovy="30"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><light {light}/>{ground}{camera}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    (rgb, _), (cast_rgb, _) = both(model, data, "above", egl)
    assert np.abs(rgb.astype(int) - cast_rgb).mean() < 2


def test_what_cannot_be_cast_is_refused():
    field = '<asset><hfield name="hills" nrow="3" ncol="3" size="1 1 1 1"/></asset>'
    world = '<worldbody><geom type="hfield" hfield="hills"/></worldbody>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{field}{world}</mujoco>")
    with pytest.raises(BadValue, match="shows mjGEOM_HFIELD"):
        RayCaster(model, width=64, height=64)
