"""A scripted arm without a body: it tracks targets exactly, and a symbolic box resists it."""

import numpy as np
from arm.fake_arm import FakeArm

GRIP, GIVE = 0.012, 0.15
"""Metres from a handle within which the hand holds it; share of its way that a locked handle gives way."""

HELD, LOOSE = 25.0, 3.0
"""Newtons against the drag of a locked and of a free handle."""

WEIGHT, HOME = np.array([0.0, 0.0, -6.0]), np.array([0.3, 0.0, 0.5])


class ScriptedArm(FakeArm):
    """A kinematic arm in front of a box; ``path`` gives a handle's path from its joint and present position."""

    period = 0.02

    def __init__(self, box, path):
        super().__init__()
        self._box, self.configuration = box, box.initial
        self._paths = [(path(joint, False), path(joint, True)) for joint in range(len(box.joints))]
        self._at, self._felt, self._held = HOME, np.zeros(3), None

    def home(self):
        self.reach(HOME, None)

    def reach(self, position, axis):
        super().reach(position, axis)
        self._held = None

    def follow(self, position, velocity, *, stiffness):
        """Move to the target at the end of the period, as far as the held handle allows."""
        super().follow(position, velocity, stiffness=stiffness)
        point, self._felt = self._at, np.zeros(3)
        for joint, at in enumerate(self.configuration if self._held is None else ()):
            path = self._paths[joint][at]
            if np.linalg.norm(path.points[0] - point) < GRIP:
                self._held = joint, path, self._box.may_move(self.configuration, joint), self.configuration
                break
        if self._held is None:
            return
        joint, path, free, before = self._held
        travelled = path.travelled(point)
        stuck = not free and travelled > GIVE * path.length
        along, direction = path.at(GIVE * path.length if stuck else travelled)
        if float((along - point) @ path.axis) > GRIP:
            self._held = None  # it rose from the handle
            return
        self._felt = -(HELD if stuck else LOOSE) * direction * (travelled > 0)
        if stuck:
            self._at = along
        elif free and travelled > 0.5 * path.length and self.configuration == before:
            self.configuration = self._box.attempt(self.configuration, joint)[0]

    def force(self):
        return WEIGHT + self._felt
