"""The mechanism simulated and pushed without an arm, with a camera: the same pictures as the twin's, much sooner."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import mujoco
import numpy as np

from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.rendering.camera import Sight
from lockprobe.plants.scene.board import compile_scene
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.settings import SceneSettings
from lockprobe.record import Fact, Snapshot

__all__ = ["FastTwin"]

_PUSH: Final = 30.0
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
        scene = compile_scene(box, labels=labels, settings=settings, rng=rng)
        model = scene.spec.compile()
        data = mujoco.MjData(model)
        self._mechanism = Mechanism(model, data, scene)
        self._mechanism.set_configuration(box.initial)
        self._mechanism.settle()
        self._sight = Sight(model, data, mechanism=self._mechanism, scene=scene, settings=settings, rng=rng.spawn(1)[0])

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings, and what made the pictures (None if none was taken)."""
        return self._sight.facts

    def observe(self) -> Snapshot:
        """The truth now."""
        return Snapshot(
            configuration=self._mechanism.configuration(), look=self._sight.now(), render=self._sight.otherwise()
        )

    def attempt(self, joint: int) -> Snapshot:
        """Push a joint's handle towards its other end, by place in panel order.

        Raises:
            PlantFault: If a joint is left between its ends, or one moved that was not pushed.
        """
        before = self._mechanism.configuration()
        self._sight.end_moment()
        moved = self._mechanism.push(joint, _PUSH)
        return Snapshot(
            configuration=self._mechanism.configuration_after(joint, before),
            joint=joint,
            outcome="moved" if moved else "blocked",
            look=self._sight.now(),
            render=self._sight.otherwise(),
        )

    def close(self) -> None:
        """Let go of the renderer."""
        self._sight.close()
