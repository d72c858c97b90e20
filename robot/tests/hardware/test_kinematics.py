"""Angles for a pose, and the pose of angles, are each other's inverse."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from lockprobe_robot.arm.panda import HOME
from lockprobe_robot.hardware.kinematics import ArmKinematics

from lockprobe.foundation.errors import PlantFault


@pytest.mark.parametrize("tool", [0.108, 0.2])
@pytest.mark.parametrize("lean", [0.0, 0.35])
def test_there_and_back(tool, lean):
    kinematics, axis = ArmKinematics(tool), np.array([np.sin(lean), 0.0, -np.cos(lean)])
    for place in ([0.5, 0.1, 0.25], [0.42, -0.2, 0.2]):
        pose = kinematics.tool(kinematics.angles(np.array(place), axis))
        assert pose[:3, 3] == pytest.approx(place, abs=3e-4)
        assert pose[:3, 2] == pytest.approx(axis, abs=2e-3)


def test_a_longer_tool_reaches_further_along_the_hand():
    short, long = (ArmKinematics(tool).tool(HOME) for tool in (0.1, 0.2))
    assert long[:3, 3] - short[:3, 3] == pytest.approx(0.1 * short[:3, 2])


def test_what_is_out_of_reach_is_said():
    with pytest.raises(PlantFault, match=r"the arm cannot reach \[2.0, 0.0, 0.3\]"):
        ArmKinematics(0.1).angles(np.array([2.0, 0.0, 0.3]), np.array([0.0, 0.0, -1.0]))
