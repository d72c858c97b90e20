"""The adapters of FR3 and RealSense against stand-ins for their libraries."""

import sys
import types

import numpy as np
import pytest
from lockprobe_robot.calibration import calibrate
from lockprobe_robot.hardware.franky import FrankyArm
from lockprobe_robot.hardware.realsense import RealSense

from lockprobe.foundation.errors import Missing, PlantFault

TOOL = 0.108
EFFECTOR = np.eye(4)
EFFECTOR[2, 3] = 0.1034
DOWN = np.array([0.0, 0.0, -1.0])


class Refused(Exception):
    """franky's ControlException."""


class FakeRobot:
    """Remembers the calls; its flange stays at the origin."""

    has_errors, is_in_control, recovers, error = False, True, True, None
    state = types.SimpleNamespace(
        F_T_EE=types.SimpleNamespace(matrix=EFFECTOR), O_T_EE=types.SimpleNamespace(matrix=EFFECTOR),
        O_F_ext_hat_K=[1.0, 2.0, 3.0, 0, 0, 0],
    )  # fmt: skip

    def __init__(self, host, **settings):
        self.log = [f"connect {host}"]

    def set_collision_behavior(self, torque, force):
        self.log.append(f"collision {torque:g} {force:g}")

    def move(self, motion):
        self.log.append("move")

    def recover_from_errors(self):
        return self.recovers

    def join_motion(self, seconds):
        if self.error:
            raise self.error

    def stop(self):
        self.log.append("stop")


class FakeTracker:
    goes_on = True

    def __init__(self, robot, *, translational_stiffness, **settings):
        self.gains, self.targets, self.log = [translational_stiffness], [], robot.log

    def set_gains(self, *, translational_stiffness):
        self.gains.append(translational_stiffness)

    def set_target(self, pose, twist, acceleration):
        self.targets.append((pose, twist, acceleration))

    def tick(self):
        return 0.01 if self.goes_on else None

    def stop(self):
        self.log.append("end")


@pytest.fixture
def arm(monkeypatch):
    library = types.ModuleType("franky")
    library.Robot, library.CartesianImpedanceTracker, library.ControlException = FakeRobot, FakeTracker, Refused
    library.RealtimeConfig = types.SimpleNamespace(Ignore=0)
    library.Affine = library.JointMotion = np.array
    library.Twist = library.TwistAcceleration = lambda linear, angular: linear
    monkeypatch.setitem(sys.modules, "franky", library)
    return FrankyArm("10.0.0.2", tool=TOOL)


def test_targets_are_those_of_the_end_effector_for_a_point_of_the_tool(arm):
    point, speed = np.array([0.5, 0.1, 0.3]), np.array([0.1, 0, 0])
    assert arm.position() == pytest.approx([0, 0, TOOL])
    arm.reach(point, DOWN)
    arm.follow(point, speed, stiffness=2500.0)
    arm.follow(point, speed, stiffness=1500.0)
    (pose, twist, acceleration), (_, _, steady) = arm._tracker.targets
    ahead = point + 0.5 * 0.01 * speed  # the middle of the period
    assert pose[:3, 3] == pytest.approx(ahead - (EFFECTOR[2, 3] - TOOL) * np.array([0, 0, 1]), abs=3e-4)
    assert (twist == speed).all()
    assert (acceleration == pytest.approx(speed / 0.01), steady == pytest.approx(0)) == (True, True)
    assert arm._tracker.gains == [2500.0, 1500.0]
    arm.home()
    assert arm._robot.log == ["connect 10.0.0.2", "collision 30 60", "move", "end", "move"]
    with pytest.raises(PlantFault, match=r"the arm cannot reach \[2.0, 0.0, 0.3\]"):
        arm.reach(np.array([2.0, 0.0, 0.3]), DOWN)


def test_forces_come_from_the_reader_or_with_their_sign_turned_from_the_robot(arm):
    assert arm.force() == pytest.approx([-1, -2, -3])
    arm._wrench = lambda: np.array([0.0, 0.0, 1.0])
    assert arm.force() == pytest.approx(arm._pose()[:3, 2])


def test_faults(arm):
    arm.follow(arm.position(), np.zeros(3), stiffness=1.0)
    arm._tracker.goes_on, arm._robot.error = False, Refused("communication_constraints_violation")
    with pytest.raises(PlantFault, match="the robot ended the motion: communication"):
        arm.follow(arm.position(), np.zeros(3), stiffness=1.0)
    arm.stop()
    assert arm._robot.log[-1] == "stop"
    arm._robot.is_in_control, arm._robot.has_errors, arm._robot.recovers = False, True, False
    with pytest.raises(PlantFault, match="cannot recover from its error: communication"):
        arm.home()


@pytest.mark.parametrize(
    ("library", "make", "extra"),
    [
        ("franky", lambda: FrankyArm("h"), "fr3"),
        ("pyrealsense2", RealSense, "realsense"),
        ("cv2", calibrate._opencv.__wrapped__, "calibrate"),
    ],
)
def test_without_the_library_the_extra_is_named(monkeypatch, library, make, extra):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(Missing, match=rf"uv sync --all-packages --extra {extra}$"):
        make()


def test_depth_is_in_metres_and_a_camera_that_is_not_there_or_unplugged_is_said_in_one_line():
    pytest.importorskip("pyrealsense2")
    with pytest.raises(Missing, match="RealSense camera 123 is not connected"):
        RealSense("123")

    def frame(*shape_and_value):
        return lambda: types.SimpleNamespace(get_data=lambda: np.full(*shape_and_value))

    shown = types.SimpleNamespace(
        get_color_frame=frame((4, 6, 3), 7, np.uint8), get_depth_frame=frame((4, 6), 720, np.uint16)
    )
    camera = RealSense.__new__(RealSense)
    camera._metres, camera._align = 0.001, types.SimpleNamespace(process=lambda frames: frames)
    camera._source = types.SimpleNamespace(wait_for_frames=lambda timeout: shown)
    assert camera.grab().rgb.shape == (4, 6, 3)
    assert camera.grab().depth == pytest.approx(np.full((4, 6), 0.72))
    camera._align.process = lambda frames: (_ for _ in ()).throw(RuntimeError("Frame didn't arrive within 2000"))
    with pytest.raises(PlantFault, match="gives no picture .Frame didn't arrive"):
        camera.grab()
