import mujoco
import numpy as np
import pytest
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.rendering.opengl import OpenGL
from lockprobe_robot.twin_settings import SceneSettings

import lockprobe

TABLE = """
<mujoco>
  <asset>
    <mesh name="wedge" vertex="0 0 0  .2 0 0  0 .2 0  0 0 .2"/>
    <texture name="sky" type="skybox" builtin="flat" rgb1="0 0 1" rgb2="0 0 1" width="8" height="48"/>
  </asset>
  <worldbody>
    <light pos="0 0 3" dir="0 0 -1"/>
    <geom name="table" type="box" size=".5 .4 .1" pos="0 0 -.1" rgba=".2 .8 .2 1"/>
    <geom name="hidden" type="box" size=".5 .5 .1" pos="0 0 .8" group="4"/>
    <geom name="glass" type="box" size=".5 .5 .1" pos="0 0 .8" rgba="1 1 1 0"/>
    <body name="slider" pos="-.2 .2 .05">
      <joint name="slide" type="slide" axis="1 0 0"/>
      <geom name="brick" type="box" size=".05 .05 .05" contype="0" conaffinity="0" rgba=".8 .2 .2 1" mass="1"/>
      <geom name="tower" type="cylinder" size=".02 .05" pos="0 0 .1" contype="0" conaffinity="0" mass="1"/>
      <site name="tip" pos="0 0 .5" size=".2"/>
    </body>
    <site name="post" pos="0 0 .5"/>
    <geom name="ball" type="sphere" size=".06" pos=".2 .2 .06"/>
    <geom name="pill" type="capsule" size=".04 .06" pos=".2 -.2 .04" euler="0 90 0"/>
    <geom name="wedge" type="mesh" mesh="wedge" pos="-.2 -.25 0" euler="0 0 30"/>
    <camera name="above" pos="0 0 1.5" fovy="45"/>
    <camera name="sky" pos="0 0 1.5" zaxis="0 0 -1" fovy="45"/>
  </worldbody>
  <tendon><spatial width=".1"><site site="tip"/><site site="post"/></spatial></tendon>
</mujoco>
"""


@pytest.fixture(scope="session")
def state():
    """Data of a model with its first joints at given positions."""

    def make(model, *positions):
        data = mujoco.MjData(model)
        data.qpos[: len(positions)] = positions
        mujoco.mj_forward(model, data)
        return data

    return make


@pytest.fixture(scope="session")
def table():
    return mujoco.MjModel.from_xml_string(TABLE)


@pytest.fixture(scope="session")
def lockbox_scene():
    box = lockprobe.box("chain-4")
    return build_scene(box, labels=tuple("ABCD"), settings=SceneSettings(), rng=np.random.default_rng(1))


@pytest.fixture(scope="session")
def lockbox_model(lockbox_scene):
    return lockbox_scene.spec.compile()


@pytest.fixture
def opens():
    """Opens renderers, and closes them."""
    opened = []

    def opens(model, *, width=160, height=120):
        opened.append(OpenGL(model, width=width, height=height))
        return opened[-1]

    yield opens
    for renderer in opened:
        renderer.close()


@pytest.fixture(scope="module")
def table_renderer(table):
    """A renderer of the table for all tests of a file."""
    renderer = OpenGL(table, width=160, height=120)
    yield renderer
    renderer.close()
