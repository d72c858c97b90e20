"""The plant ``fast-twin``: the simulated lockbox pushed by a force instead of an arm, with the same camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.trial.record import Fact, Snapshot
from lockprobe_robot.box_model.joints import Joints
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import LockboxScene, build_scene
from lockprobe_robot.plant_camera import PlantCamera
from lockprobe_robot.twin_settings import SceneSettings


class SimulatedPlant:
    """A simulation as a plant (base class).

    Args:
        joints: The joints of the box, with the model and its state.
        camera: Its camera.
    """

    def __init__(self, joints: Joints, camera: PlantCamera) -> None:
        self.joints, self._camera = joints, camera

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Engine, settings and renderer (None if no picture was taken)."""
        return self._camera.facts

    def observe(self) -> Snapshot:
        """The truth now."""
        look, render = self._camera.looks()
        return Snapshot(configuration=self.joints.configuration(), look=look, render=render)

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order.

        Raises:
            PlantFault: If a joint stays between its ends, another joint moves, an arm is blocked, or the simulation
                becomes unstable.
        """
        before = self.joints.configuration()
        self._camera.end_moment()
        sensed = self._act(joint, before)
        after = self.joints.configuration_after(joint, before)
        return replace(
            self.observe(), joint=joint, outcome="moved" if after[joint] != before[joint] else "blocked", sensed=sensed
        )

    def _act(self, joint: int, before: Configuration) -> Mapping[str, Fact]:
        """Act on a joint until the box is at rest, by a push if no arm does; what a robot sensed."""
        self.joints.push(joint)
        return {}

    def close(self) -> None:
        """Release the renderer."""
        self._camera.close()


class SimulatedLockbox(SimulatedPlant):
    """A compiled scene, with everything that is added to it, as a plant (base class).

    Its camera draws noise of depth and error of the view from the stream ``noise``.
    """

    joints: Mechanism

    def __init__(self, scene: LockboxScene, settings: SceneSettings, noise: np.random.Generator) -> None:
        model, panel = scene.spec.compile(), scene.panel
        joints = Mechanism(model, mujoco.MjData(model), scene)
        camera = PlantCamera(joints, pose=panel.pose, handles=panel.handles, settings=settings, rng=noise)
        super().__init__(joints, camera)


class FastTwin(SimulatedLockbox):
    """A simulated lockbox whose handles are pushed by a force, without an arm.

    Args:
        box: The box.
        labels: Labels of the joints, in panel order.
        settings: Looks and camera.
        rng: For the appearance; noise of depth and error of the view draw from a child of it.

    Raises:
        BadValue: If the box cannot be built.
    """

    def __init__(
        self, box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
    ) -> None:
        super().__init__(build_scene(box, labels=labels, settings=settings, rng=rng), settings, rng.spawn(1)[0])
        self.joints.set_configuration(box.initial)
        self.joints.settle()
