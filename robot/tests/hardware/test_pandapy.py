"""The Panda's adapter against a stand-in for panda-py, and the real library's names where it is installed."""

import sys
import types

import numpy as np
import pytest

pytest.importorskip("mujoco")

from lockprobe_robot.arm.panda import HOME
from lockprobe_robot.hardware.kinematics import ArmKinematics
from lockprobe_robot.hardware.pandapy import PandaArm
from lockprobe_robot.hardware.wrench import FreshWrench, WrenchReading

from lockprobe.foundation.errors import Missing, PlantFault

TOOL = 0.108
EFFECTOR = np.eye(4)
EFFECTOR[2, 3] = 0.1034
DOWN = np.array([0.0, 0.0, -1.0])


class FakePanda:
    """Stands where it was sent; remembers the calls."""

    arrives = True

    def __init__(self, host):
        self.q, self.log, self.error = HOME.copy(), [f"connect {host}"], None

    def get_state(self):
        return types.SimpleNamespace(
            F_T_EE=EFFECTOR.ravel(order="F").tolist(),
            O_F_ext_hat_K=[1.0, 2.0, 3.0, 0, 0, 0],
            control_command_success_rate=0.98,
        )

    def get_pose(self):
        tool = np.eye(4)
        tool[2, 3] = TOOL
        return ArmKinematics(TOOL).tool(self.q) @ np.linalg.inv(tool) @ EFFECTOR

    def move_to_joint_position(self, angles, *, speed_factor):
        self.log.append("move")
        self.q = np.array(angles)
        return self.arrives

    def start_controller(self, controller):
        self.log.append("start")

    def stop_controller(self):
        self.log.append("end")

    def recover(self):
        self.log.append("recover")

    def raise_error(self):
        if self.error:
            raise self.error

    def get_robot(self):
        return types.SimpleNamespace(stop=lambda: self.log.append("stop"))


class FakeImpedance:
    def __init__(self, gains):
        self.gains, self.targets = [gains], []

    def set_impedance(self, gains):
        self.gains.append(gains)

    def set_control(self, position, quaternion, posture):
        self.targets.append((position, quaternion, posture))


@pytest.fixture
def arm(monkeypatch):
    library = types.ModuleType("panda_py")
    library.Panda = FakePanda
    library.controllers = types.SimpleNamespace(CartesianImpedance=FakeImpedance)
    monkeypatch.setitem(sys.modules, "panda_py", library)
    return PandaArm("10.0.0.2", tool=TOOL, period=0.001)


def test_targets_are_those_of_the_end_effector_for_a_point_of_the_tool(arm):
    point = np.array([0.5, 0.1, 0.3])
    arm.reach(point, DOWN)
    assert arm.position() == pytest.approx(point, abs=3e-4)
    arm.follow(point, np.array([0.1, 0, 0]), stiffness=2500.0)
    arm.follow(point, np.zeros(3), stiffness=1500.0)
    (position, quaternion, posture), (second, _, _) = arm._controller.targets
    assert second == pytest.approx(point - (EFFECTOR[2, 3] - TOOL) * np.array([0, 0, 1]), abs=3e-4)
    assert position - second == pytest.approx([0.5 * 0.001 * 0.1, 0, 0])
    assert np.linalg.norm(quaternion) == pytest.approx(1)
    assert posture == pytest.approx(arm._panda.q)
    assert [gains[0, 0] for gains in arm._controller.gains] == [2500.0, 1500.0]
    assert arm._panda.log == ["connect 10.0.0.2", "recover", "move", "start"]
    arm.home()
    assert arm._panda.log[4:] == ["end", "recover", "move"]


def test_forces_come_from_the_reader_or_with_their_sign_turned_from_the_robot(arm):
    assert arm.force() == pytest.approx([-1, -2, -3])
    reader = types.SimpleNamespace(read=lambda: WrenchReading(force=np.array([0.0, 0.0, 1.0]), age=0.0))
    arm._wrench = FreshWrench(reader=reader)
    assert arm.force() == pytest.approx(arm._pose()[:3, 2])
    assert arm.success_rate == 0.98


def test_faults(arm):
    arm.follow(arm.position(), np.zeros(3), stiffness=1.0)
    arm._panda.error = RuntimeError("communication_constraints_violation")
    with pytest.raises(RuntimeError, match="communication"):  # the bounds around it make it a fault
        arm.follow(arm.position(), np.zeros(3), stiffness=1.0)
    arm.stop()
    assert arm._panda.log[-1] == "stop"
    arm._panda.arrives = False
    with pytest.raises(PlantFault, match="did not arrive"):
        arm.home()


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "panda_py", None)
    with pytest.raises(Missing, match=r"lockprobe-robot\[panda\]"):
        PandaArm("h")


def test_the_library_has_the_names_that_are_called():
    library = pytest.importorskip("panda_py")
    from panda_py import controllers, libfranka

    used = "get_state get_pose move_to_joint_position start_controller stop_controller recover raise_error get_robot q"
    assert all(hasattr(library.Panda, name) for name in used.split())
    assert all(hasattr(controllers.CartesianImpedance, name) for name in ("set_impedance", "set_control"))
    assert all(
        hasattr(libfranka.RobotState, name) for name in ("F_T_EE", "O_F_ext_hat_K", "control_command_success_rate")
    )
    assert hasattr(libfranka.Robot, "stop")
