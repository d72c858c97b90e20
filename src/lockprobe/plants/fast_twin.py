"""The mechanism simulated and pushed without an arm, with a camera: the same pictures as the twin's, much sooner."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Final

import mujoco
import numpy as np

from lockprobe.errors import PlantFault
from lockprobe.lockbox.box import Lockbox, bits
from lockprobe.pictures.frame import Frame
from lockprobe.plants.rendering.eye import Eye
from lockprobe.plants.scene.board import compile_scene
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.settings import SceneSettings
from lockprobe.record import Fact, Snapshot

__all__ = ["PUSH", "FastTwin"]

PUSH: Final = 30.0
"""Force at a handle, newtons."""


class FastTwin:
    """A simulated lockbox whose handles are pushed by a force.

    Args:
        box: The box.
        labels: What stands on the panel beside the joints, in panel order.
        settings: Of mechanism, looks and camera.
        rng: For looks and for the noise of depth, which has a stream of its own.

    Raises:
        BadValue: If the box cannot be built.
        Missing: If a package is not there.
    """

    def __init__(
        self, box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
    ) -> None:
        self._settings = settings
        self._scene = compile_scene(box, labels=labels, settings=settings, rng=rng)
        self._sight = rng.spawn(1)[0]
        self._model = self._scene.spec.compile()
        self._data = mujoco.MjData(self._model)
        self._mechanism = Mechanism(self._model, self._data, self._scene)
        self._mechanism.set_configuration(box.initial)
        self._mechanism.settle()
        self._eye = Eye(self._model, self._scene.camera, settings)
        self._looked = False
        self._attempts = 0

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Settings, engine, and what made the pictures (None if none was taken)."""
        facts: dict[str, Fact] = {"engine": f"mujoco {mujoco.__version__}", **asdict(self._settings)}
        return facts | {"renderer": self._eye.renderer if self._looked else None}

    def observe(self) -> Snapshot:
        """The truth now."""
        return Snapshot(configuration=self._mechanism.configuration(), look=self._camera())

    def attempt(self, joint: int) -> Snapshot:
        """Push a joint's handle towards its other end, by place in panel order.

        Raises:
            PlantFault: If a joint is left between its ends, or one moved that was not pushed.
        """
        mechanism = self._mechanism
        before = mechanism.configuration()
        self._attempts += 1
        moved = mechanism.push(joint, PUSH)
        after = mechanism.configuration()
        others = [i for i, (was, is_now) in enumerate(zip(before, after, strict=True)) if was != is_now and i != joint]
        if others or not mechanism.resting():
            where = ", ".join(f"{fraction:.2f}" for fraction in mechanism.fractions())
            raise PlantFault(
                f"joint {joint} was pushed in {bits(before)} and the joints now stand at {where} of their travel"
            )
        return Snapshot(configuration=after, joint=joint, outcome="moved" if moved else "blocked", look=self._camera())

    def close(self) -> None:
        """Let go of the renderer."""
        self._eye.close()

    def _camera(self) -> Callable[[], Frame]:
        taken_at = self._attempts

        def look() -> Frame:
            if self._attempts != taken_at:
                raise PlantFault("a picture was asked for after the next attempt")
            self._looked = True
            panel = self._scene.panel
            return self._eye.look(self._data, panel.pose, panel.handles, self._sight)

        return look
