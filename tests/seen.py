"""A plant with a made-up camera, for tests of what pictures do on their way to an agent."""

from dataclasses import replace

import numpy as np

from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.pictures.frame import Camera, Frame

CAMERA = Camera(
    width=8,
    height=6,
    focal=10.0,
    panel=np.block([[np.diag([1.0, -1.0, -1.0]), np.array([[0], [0], [1]])], [np.eye(4)[3:]]]),
)


class PhotographedPlant(SymbolicPlant):
    """The symbolic box, of which pictures can be taken: the first row of pixels holds the configuration.

    Its handles are at x = place in panel order, y = position, so that it can be told which is which. ``sensed`` is
    what its robot claims to have measured; ``looks`` counts pictures, ``closed`` how often it was let go of. Others
    paint other pictures: ``picture``.
    """

    def __init__(self, box, sensed=None):
        super().__init__(box)
        self.facts = {"robot": "made up"}
        self.sensed = sensed
        self.looks = 0
        self.closed = 0

    def observe(self):
        return self._with_camera(super().observe())

    def attempt(self, joint):
        return self._with_camera(super().attempt(joint))

    def close(self):
        self.closed += 1

    def picture(self, configuration):
        rgb = np.zeros((6, 8, 3), np.uint8)
        rgb[0, : len(configuration)] = np.array(configuration, np.uint8)[:, None] * 255
        handles = np.array([[(i, 0, 0), (i, 1, 0)] for i in range(len(configuration))], float)
        return Frame(rgb=rgb, depth=np.ones((6, 8), np.float32), camera=CAMERA, handles=handles, renderer="made up")

    def _with_camera(self, snapshot):
        def look():
            self.looks += 1
            return self.picture(snapshot.configuration)

        sensed = {} if snapshot.joint is None or self.sensed is None else {"verdict": self.sensed}
        return replace(snapshot, look=look, sensed=sensed)
