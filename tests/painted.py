"""A plant with a camera and no physics: joints are painted where they stand, and every attempt is the box's rule."""

from __future__ import annotations

import numpy as np

from lockprobe.lockbox.box import Lockbox
from lockprobe.pictures.frame import Camera, Frame
from lockprobe.plants import catalogue
from lockprobe.plants.settings import SceneSettings
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.record import Snapshot

__all__ = ["PaintedPlant", "painted_twins"]


class PaintedPlant:
    """Stands in for ``fast-twin``. Its pictures depend on how the joints stand and on the stream that it was given.

    Attributes:
        closed: How often it was let go of.
        looks: How often it was looked at.
    """

    made: list[PaintedPlant] = []  # noqa: RUF012 - of all that were made, for tests

    def __init__(
        self, box: Lockbox, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
    ) -> None:
        self.facts = {"engine": "paint"}
        self.closed = self.looks = 0
        self._rules = SymbolicPlant(box)
        self._settings = settings
        self._joints = len(labels)
        self._wood = rng.integers(80, 120, size=3)
        PaintedPlant.made.append(self)

    def observe(self) -> Snapshot:
        return self._with_look(self._rules.observe())

    def attempt(self, joint: int) -> Snapshot:
        return self._with_look(self._rules.attempt(joint))

    def close(self) -> None:
        self.closed += 1

    def _with_look(self, snapshot: Snapshot) -> Snapshot:
        def look() -> Frame:
            self.looks += 1
            return self._picture(snapshot.configuration)

        return Snapshot(configuration=snapshot.configuration, joint=snapshot.joint, outcome=snapshot.outcome, look=look)

    def _picture(self, configuration: tuple[bool, ...]) -> Frame:
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


def painted_twins(monkeypatch) -> list[PaintedPlant]:
    """Puts it in the place of ``fast-twin``; every one that is made is in the list."""
    PaintedPlant.made.clear()
    monkeypatch.setattr(catalogue, "_check", lambda settings, make, box: None)  # which makes one to see if it can
    monkeypatch.setattr(
        catalogue, "_fast_twin", lambda settings: lambda box, labels, rng: PaintedPlant(box, labels, settings, rng)
    )
    return PaintedPlant.made
