"""A plant with a camera and no physics: joints are painted where they stand, and every attempt is the box's rule."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from lockprobe_robot import plants
from seen import PhotographedPlant

from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.record import Snapshot


class PaintedPlant(PhotographedPlant):
    """Stands in for ``fast-twin``. Its pictures depend on how the joints stand, or are told to, and on the stream that it was given."""

    made: list[PaintedPlant] = []  # noqa: RUF012 - of all that were made, for tests

    def __init__(self, box, labels, settings, rng):
        super().__init__(box)
        self.facts = {"engine": "paint"}
        self._settings = settings
        self._joints = len(labels)
        self._wood = rng.integers(80, 120, size=3)
        PaintedPlant.made.append(self)

    def _with_camera(self, snapshot: Snapshot) -> Snapshot:
        return replace(super()._with_camera(snapshot), render=self.picture)

    def picture(self, configuration: tuple[bool, ...]) -> Frame:
        height, width = self._settings.height, self._settings.width
        rgb = np.full((height, width, 3), self._wood, dtype=np.uint8)
        depth = np.full((height, width), 0.7, dtype=np.float32)
        depth[0] = 0
        depth[1] = 5
        across = width // self._joints
        for i, position in enumerate(configuration):
            rows = slice(height // 2, height - 4) if position else slice(4, height // 2)
            columns = slice(i * across + 2, (i + 1) * across - 2)
            rgb[rows, columns] = (220, 40, 40)
            depth[rows, columns] = 0.65
        camera = Camera(width=width, height=height, focal=500.0, panel=np.eye(4))
        return Frame(rgb=rgb, depth=depth, camera=camera, handles=np.ones((self._joints, 2, 3)), renderer="paint")


_PICTURED = plants._pictured


def painted_twins(monkeypatch, kind=PaintedPlant) -> list[PaintedPlant]:
    """Puts it, or a kind of it, in the place of ``fast-twin`` and ``twin``; every one that is made is in the list."""
    PaintedPlant.made.clear()

    def painted(spec, settings, make):
        source = _PICTURED(spec, settings, lambda box, labels, rng: kind(box, labels, settings, rng))
        return replace(source, check=lambda box: None)  # which makes one to see if it can

    monkeypatch.setattr(plants, "_pictured", painted)
    return PaintedPlant.made
