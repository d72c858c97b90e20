"""An arm that goes exactly where it is drawn and feels what a script says."""

import numpy as np


class FakeArm:
    """Keeps a log of what it was asked to do, and of how it was drawn.

    ``feel`` is the force on the hand, newtons, from where the tool is and the seconds for which it has been drawn;
    ``follows`` says where the tool comes to when it is drawn to a point.
    """

    period = 0.01

    def __init__(self, feel=lambda position, time: np.zeros(3), follows=lambda point: point):
        self.log, self.drawn = [], []
        self._feel, self._follows = feel, follows
        self._at, self.time = np.zeros(3), 0.0

    def home(self):
        self.log.append("home")
        self.time += 1.0

    def reach(self, position, axis):
        self.log.append("reach")
        self._at, self.time = np.array(position), self.time + 1.0

    def follow(self, position, velocity, *, stiffness):
        self.log.append("follow")
        self.drawn.append((np.array(position), np.array(velocity)))
        self._at = self._follows(position + self.period * velocity)
        self.time += self.period

    def position(self):
        return self._at.copy()

    def force(self):
        return self._feel(self._at, self.time)

    def stop(self):
        self.log.append("stop")
