"""The plant ``fast-twin``: the simulated lockbox pushed by a force instead of an arm, with the same camera."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import mujoco
import numpy as np

from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.rendering.camera import PlantCamera
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.scene.scene import build_scene
from lockprobe.plants.twin_settings import SceneSettings
from lockprobe.record import Fact, Snapshot

__all__ = ["FastTwin"]

_PUSH: Final = 30.0
"""Force at a handle, newtons."""


class FastTwin:
    """A simulated lockbox whose handles are pushed by a force.

    Args:
        box: The box.
        labels: Labels of the joints, in panel order.
        settings: Mechanism, looks and camera.
        rng: For the appearance; the noise of depth draws from a child of it.

    Raises:
        BadValue: If the box cannot be built.
        Missing: If a package is missing.
    """

    def __init__(
        self, box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
    ) -> None:
        scene = build_scene(box, labels=labels, settings=settings, rng=rng)
        model = scene.spec.compile()
        data = mujoco.MjData(model)
        self._mechanism = Mechanism(model, data, scene)
        self._mechanism.set_configuration(box.initial)
        self._mechanism.settle()
        self._camera = PlantCamera(
            model, data, mechanism=self._mechanism, scene=scene, settings=settings, rng=rng.spawn(1)[0]
        )

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings and renderer (None if no picture was taken)."""
        return self._camera.facts

    def observe(self) -> Snapshot:
        """The truth now."""
        return Snapshot(
            configuration=self._mechanism.configuration(),
            look=self._camera.look_now(),
            render=self._camera.look_as_if(),
        )

    def attempt(self, joint: int) -> Snapshot:
        """Push a joint's handle towards its other end, by index in panel order.

        Raises:
            PlantFault: If a joint stays between its ends, or a joint moves that was not pushed.
        """
        before = self._mechanism.configuration()
        self._camera.end_moment()
        moved = self._mechanism.push(joint, _PUSH)
        return Snapshot(
            configuration=self._mechanism.configuration_after(joint, before),
            joint=joint,
            outcome="moved" if moved else "blocked",
            look=self._camera.look_now(),
            render=self._camera.look_as_if(),
        )

    def close(self) -> None:
        """Release the renderer."""
        self._camera.close()
