"""A Universal Robots arm through ur_rtde 1.6.5 as an arm for the guarded move. It was never run on a robot."""

import math
import time

import numpy as np
from dashboard_client import DashboardClient
from rtde_control import RTDEControlInterface
from rtde_receive import RTDEReceiveInterface
from scipy.spatial.transform import Rotation

HOME = (0.0, -1.9, 1.2, -0.9, -math.pi / 2, 0.0)  # change: joint angles at which the arm is out of the camera's view
DOWN = Rotation.from_rotvec([math.pi, 0.0, 0.0])
PACE = {"speed": 0.5, "acceleration": 0.5}  # of free motions: rad/s and rad/s^2 of the fastest joint


class URArm:
    """Position-controlled: it gives way by its measured force divided by the stiffness, as springs would."""

    def __init__(self, host, *, tool=0.15, period=0.008):
        self.period, self.facts = period, {"driver": "ur_rtde", "wrench": "the flange's sensor (e-Series)"}
        self._control = RTDEControlInterface(host, 1 / period)
        self._receive = RTDEReceiveInterface(host)
        self._dashboard = DashboardClient(host)  # a separate connection: another thread calls stop()
        self._dashboard.connect()
        self._control.setTcp([0.0, 0.0, tool, 0.0, 0.0, 0.0])
        self._turn, self._zero, self._felt = [math.pi, 0.0, 0.0], None, np.zeros(3)
        self._stopped = False

    time = property(lambda self: time.monotonic())

    def home(self):
        self._go(self._control.moveJ, HOME)

    def reach(self, position, axis):
        lean, _ = Rotation.align_vectors([axis], [[0.0, 0.0, -1.0]])
        self._turn = list((lean * DOWN).as_rotvec())
        self._go(self._control.moveJ_IK, [*position, *self._turn])

    def follow(self, position, velocity, *, stiffness):
        began = self._control.initPeriod()
        self._zero = self.force() if self._zero is None else self._zero  # nothing is held at the first command
        self._felt = self._felt + 0.2 * (self.force() - self._zero - self._felt)
        point = position + self.period * velocity + self._felt / stiffness
        if not self._control.servoL([*point, *self._turn], 0.0, 0.0, self.period, 0.03, 500.0):
            raise RuntimeError("the robot refused a point: see its pendant")
        self._control.waitPeriod(began)

    def position(self):
        return np.array(self._receive.getActualTCPPose()[:3])

    def force(self):
        return np.array(self._receive.getActualTCPForce()[:3])

    def stop(self):
        self._stopped = True
        self._dashboard.stop()  # ends the program on the robot, which brakes

    def _go(self, move, where):
        if self._stopped:
            self._stopped = not self._control.reuploadScript()
        self._control.servoStop()
        self._zero, self._felt = None, np.zeros(3)
        if not move(list(where), **PACE):
            raise RuntimeError("the arm did not arrive: see its pendant")
