"""The scene of rehearsals over the wire: a copy that is posed after another one shows the same."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from lockprobe_robot.arm.panda import HOME
from lockprobe_robot.hardware.camera import Shot
from lockprobe_robot.hardware.position_reader import read_positions
from lockprobe_robot.hardware.wire_scene import WireScene

from lockprobe.boxes.families import box

CHAIN = box("chain-4")
CONFIGURATION = (True, False, True, False)


def test_a_copy_that_is_posed_shows_the_other_one():
    played, copy = (WireScene(CHAIN, tuple("ABCD"), 3) for _ in range(2))
    assert copy.mechanism.configuration() == CHAIN.initial
    assert copy.data.qpos[copy.arm_addresses] == pytest.approx(HOME)
    played.mechanism.set_configuration(CONFIGURATION)
    copy.pose(played.data.qpos.tolist())
    assert copy.mechanism.configuration() == CONFIGURATION
    there, here = played.look(), copy.look()
    assert (there.rgb == here.rgb).all()
    assert (there.depth == here.depth).all()
    places = here.camera.project(here.handles)[..., :2].tolist()
    assert read_positions(Shot(rgb=here.rgb), places, CHAIN.names) == CONFIGURATION
    played.close()
    copy.close()


def test_the_robot_carries_its_own_weight_and_the_handles_do_not():
    scene = WireScene(CHAIN, tuple("ABCD"), 3)
    carried = {scene.model.body(i).name for i in np.flatnonzero(scene.model.body_gravcomp)}
    assert {f"link{i}" for i in range(8)} <= carried
    assert not [name for name in carried if name.startswith(("part-", "panel"))]
    assert scene.model.opt.timestep == 0.001
