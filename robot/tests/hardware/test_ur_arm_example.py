"""The example of another arm: it rehearses through a stand-in for ur_rtde, and its page shows it as it is."""

import runpy
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware import rehearsal
from lockprobe_robot.hardware.bounds import Bounded
from lockprobe_robot.hardware.rig import Rig
from lockprobe_robot.hardware.scripted_arm import ScriptedArm
from scipy.spatial.transform import Rotation

from lockprobe.boxes.families import box

ROOT = Path(__file__).parents[3]
PATH = ROOT / "examples" / "ur_arm.py"
STRAIGHT = np.array([0.0, 0.0, -1.0])


class FakeRobot:
    """The controller: a box of the rules in front of an arm that goes where it is sent. What is not here says True."""

    def __init__(self, puzzle):
        self.arm, self.log = ScriptedArm(puzzle, lay_out_panel(puzzle).handle_path), []
        self.turn = [0.0] * 3

    def __getattr__(self, name):
        return lambda *given: True

    def control(self, host, frequency):
        self.log.append(f"connect {host} {frequency:g} Hz")
        self.arm.period = 1 / frequency
        return self

    def moveJ(self, angles, speed, acceleration):  # noqa: N802 - the library's name, as all below
        assert len(angles) == 6
        self.arm.home()
        return True

    def moveJ_IK(self, pose, speed, acceleration):  # noqa: N802
        self.arm.reach(np.array(pose[:3]), STRAIGHT)
        self.turn = pose[3:]
        return True

    def servoL(self, pose, speed, acceleration, seconds, lookahead, gain):  # noqa: N802
        assert 0.03 <= lookahead <= 0.2
        assert 100 <= gain <= 2000
        assert pose[3:] == self.turn
        self.arm.follow(np.array(pose[:3]), np.zeros(3), stiffness=0.0)
        return True

    def getActualTCPPose(self):  # noqa: N802
        return [*self.arm.position(), *self.turn]

    def getActualTCPForce(self):  # noqa: N802
        return [*self.arm.force(), 0.0, 0.0, 0.0]


@pytest.fixture
def robot():
    return FakeRobot(box("chain-3"))


@pytest.fixture
def arm(monkeypatch, robot):
    for name, kind, made in (
        ("rtde_control", "RTDEControlInterface", robot.control),
        ("rtde_receive", "RTDEReceiveInterface", lambda host: robot),
        ("dashboard_client", "DashboardClient", lambda host: robot),
    ):
        monkeypatch.setitem(sys.modules, name, types.SimpleNamespace(**{kind: made}))
    return runpy.run_path(str(PATH))["URArm"]("192.168.0.3")


def test_attempts_through_it_say_what_the_rules_say(arm, robot):
    puzzle = box("chain-3")
    panel = lay_out_panel(puzzle)
    within = Bounded(arm, rehearsal._BOUNDS, operator := rehearsal.ConsentingOperator())
    rig = Rig(puzzle, labels=puzzle.names, arm=within, panel=panel, operator=operator, truth="verdict")
    before, verdicts = rig.observe().configuration, set()
    for joint in np.random.default_rng(2).integers(len(puzzle.joints), size=6).tolist():
        seen = rig.attempt(joint)
        before, moved = puzzle.attempt(before, joint)
        assert (seen.configuration, robot.arm.configuration, seen.outcome == "moved") == (before, before, moved)
        verdicts.add(seen.sensed["verdict"])
    assert (verdicts, rig.facts["driver"]) == ({"moved", "blocked"}, "ur_rtde")
    assert robot.log == ["connect 192.168.0.3 125 Hz"]


def test_it_gives_way_by_force_over_stiffness(arm, robot):
    point = np.array([0.5, 0.2, 0.4])
    arm.reach(point, STRAIGHT)
    arm.follow(point, np.zeros(3), stiffness=1000.0)
    robot.arm.force = lambda: np.array([4.0, 0.0, -6.0])  # the weight, and 4 N along x
    for _ in range(50):
        arm.follow(point, np.zeros(3), stiffness=1000.0)
    assert arm.position() == pytest.approx(point + np.array([0.004, 0, 0]), abs=1e-6)
    arm.reach(point, np.array([0.0, 0.6, -0.8]))
    tool = Rotation.from_rotvec(robot.turn).as_matrix()
    assert tool[:, 2] == pytest.approx([0, 0.6, -0.8])
