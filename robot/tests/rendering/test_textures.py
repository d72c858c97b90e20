"""Textures lie on shapes as OpenGL lays them."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.rendering.ray_caster import RayCaster
from lockprobe_robot.rendering.textures import Textures

MODEL = """
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <texture name="flat" type="2d" builtin="flat" width="64" height="32"/>
    <texture name="cube" type="cube" builtin="flat" width="32" height="32"/>
    <material name="once" texture="flat"/>
    <material name="often" texture="flat" texrepeat="2 3"/>
    <material name="metric" texture="flat" texrepeat="4 6" texuniform="true"/>
    <material name="cube" texture="cube"/>
    <material name="metric-cube" texture="cube" texuniform="true"/>
  </asset>
  <worldbody>{geoms}</worldbody>
</mujoco>
"""
BOX = 'type="box" size=".3 .2 .1"'
SHAPES = (BOX, 'type="plane" size=".3 .2 .1"', 'type="cylinder" size=".25 .1"')
TEXTURED = [
    *((shape, material) for shape in SHAPES for material in ("once", "often", "metric")),
    (BOX, "cube"),
    (BOX, "metric-cube"),
]
"""Shape and material of each geom, in order; camera ``i`` looks at geom ``i`` alone."""


@pytest.fixture(scope="module")
def textured():
    """A model on whose textures red grows to the right and green downwards; blue tells the side of a cube."""
    geoms = "".join(
        f'<geom {shape} material="{material}" pos="{2 * i} 0 0"/><camera name="{i}" pos="{2 * i} 0 3" fovy="15"/>'
        for i, (shape, material) in enumerate(TEXTURED)
    )
    model = mujoco.MjModel.from_xml_string(MODEL.format(geoms=geoms))
    for texture in range(model.ntex):
        height, width = model.tex_height[texture], model.tex_width[texture]
        rows, columns = np.mgrid[:height, :width]
        image = np.stack([columns * 255 // (width - 1), rows % width * 255 // (width - 1), rows // width * 40], axis=-1)
        start = model.tex_adr[texture]
        model.tex_data[start : start + image.size] = image.astype(np.uint8).ravel()
    return model


def test_as_opengl_shows_it(textured, egl):
    data, size = mujoco.MjData(textured), {"width": 240, "height": 180}
    opengl, rays = egl(textured, **size), RayCaster(textured, **size)
    for camera, described in enumerate(TEXTURED):
        drawn, depth = opengl.render(data, str(camera))
        cast, _ = rays.render(data, str(camera))
        top = np.abs(depth - depth[90, 120]) < 1e-3  # sides are left out: each of a box's has a direction of its own
        wrong = np.abs(drawn.astype(int) - cast).max(axis=2)[top] > 24
        assert top.sum() > 2800, described
        assert wrong.mean() < 0.06, described  # where a texture ends and begins again


def test_corners_of_a_board(textured):
    corners = np.array([[-0.29, 0.19, 0.1], [0.29, 0.19, 0.1], [-0.29, -0.19, 0.1]])
    colours = Textures(textured).sample(0, corners, 0.001)
    assert colours[0, :2] == pytest.approx([0, 0], abs=0.03)
    assert colours[1, 0] - colours[0, 0] > 0.9
    assert colours[2, 1] - colours[0, 1] > 0.4  # the texture is half as high as wide


def test_seen_from_afar_a_texture_is_its_mean(textured):
    colours = Textures(textured).sample(0, np.random.default_rng(1).uniform(-0.2, 0.2, (50, 3)), 0.6)
    assert np.ptp(colours[:, 0]) < 0.05
    assert colours[:, 0].mean() == pytest.approx(0.5, abs=0.05)


def test_without_a_texture_there_is_none():
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert Textures(model).of(0) is None
    assert Textures(model).background == pytest.approx([0, 0, 0])
