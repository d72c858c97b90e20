"""The plant ``twin``: a physical lockbox that a robot arm acts on (paper, Sec. 2.1).

A snapshot holds both the truth and the robot's verdict. The outcome is the state of the mechanism at rest; ``sensed``
holds the measurements and the verdict of the arm's guarded move.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.plants.catalogue import FilmHook
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import GuardedMove, HandlePath
from lockprobe_robot.arm.hand import add_hand
from lockprobe_robot.arm.panda import add_panda
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.box_model.panel import PanelLayout
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.fast_twin import SimulatedLockbox
from lockprobe_robot.filming import Filming
from lockprobe_robot.twin_settings import TwinSettings
from lockprobe_robot.user_model.own_hand import add_own_hand

_PATIENCE = 1.0
"""Longest wait for the mechanism to come to rest after the arm is at home, seconds."""


class Twin(SimulatedLockbox):
    """A lockbox, an arm and a camera in one simulation.

    Before every attempt the robot receives the true positions of the handles, up to ``pose_error``, so a wrong verdict
    does not mislead its next move.

    Args:
        box: The box; its rules become pins and blocks.
        labels: Labels of the joints, in panel order.
        settings: Mechanism, looks, camera and errors of the robot.
        rng: The trial's random stream for the plant. The appearance draws from it; depth noise, pose error and force
            noise each draw from a child of it. The n-th look and the n-th attempt have the same luck whatever the
            settings are. Every attempt has a separate force stream, because attempts differ in length.
        film: Called about 25 times per simulated second with the model and its state, which it must not change.

    Raises:
        BadValue: If the box cannot be built, or its handles cannot be reached.
        BadFile: If one's own hand cannot be mounted.
    """

    def __init__(
        self,
        box: Lockbox,
        *,
        labels: tuple[str, ...],
        settings: TwinSettings,
        rng: np.random.Generator,
        film: FilmHook | None = None,
    ) -> None:
        scene = build_scene(box, labels=labels, settings=settings, rng=rng)
        # The same streams as in fast-twin: one seed gives the same panel with and without an arm.
        noise, self._aim, self._force = *rng.spawn(1), *rng.spawn(2)
        flange = add_panda(scene.spec)
        if settings.hand:
            add_own_hand(scene.spec, flange, Path(settings.hand), settings.hand_digest)
        else:
            add_hand(scene.spec, flange)
        super().__init__(scene, settings, noise)
        self._box, self._settings, self._panel = box, settings, scene.panel
        self._arm = SimulatedArm(
            self._model,
            self._data,
            force_noise=settings.force_noise,
            rng=self._force,
            before_step=self._mechanism.before_step,
            after_step=Filming(film, self._model, self._data),
        )
        self._move = GuardedMove()
        self._refuse_out_of_reach()
        self.put(box.initial)

    def _act(self, joint: int, before: Configuration) -> Mapping[str, Fact]:
        self._arm.use_stream(self._force.spawn(1)[0])
        touch = self._move.attempt(self._arm, self._believed_path(joint, before[joint]))
        self._settle()
        return {**touch.as_facts(), **self._nudged()}

    def _nudged(self) -> Mapping[str, Fact]:
        """Push a handle that the hand left between its ends to the nearer one, as a person would; for the record."""
        if self._mechanism.resting():
            return {}
        self._mechanism.set_configuration(self._mechanism.configuration())
        self._settle()
        return {"nudged": True}

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled scene with the arm."""
        return self._model

    @property
    def data(self) -> mujoco.MjData:
        """The state of the simulation, for measurements."""
        return self._data

    @property
    def arm(self) -> SimulatedArm:
        """The arm, for rehearsals of a rig."""
        return self._arm

    @property
    def panel(self) -> PanelLayout:
        """The layout of the panel, with the positions of the handles."""
        return self._panel

    def settled(self) -> Configuration:
        """The configuration once the mechanism is at rest.

        Raises:
            PlantFault: If a joint stays between its ends.
        """
        self._settle()
        if not self._mechanism.resting():
            raise PlantFault(f"a joint stays between its ends: {np.round(self._mechanism.fractions(), 2).tolist()}")
        return self._mechanism.configuration()

    def put(self, configuration: Configuration) -> None:
        """Set the configuration with the arm at home, at rest; for tests and measurements."""
        self._mechanism.set_configuration(configuration)
        self._arm.stand()
        self._settle()

    def _settle(self) -> None:
        """Wait until every joint is at an end, up to a time limit."""
        deadline = self._data.time + _PATIENCE
        self._arm.wait()
        while not self._mechanism.resting() and self._data.time < deadline:
            self._arm.wait()

    def _believed_path(self, joint: int, position: bool) -> HandlePath:
        """The handle's path with a random pose error in the panel's plane."""
        shift = self._settings.pose_error * self._aim.standard_normal(2)
        path = self._panel.handle_path(joint, position)
        return HandlePath(points=path.points + self._panel.pose[:3, :2] @ shift, axis=path.axis)

    def _refuse_out_of_reach(self) -> None:
        for joint, name in enumerate(self._box.names):
            path = self._panel.handle_path(joint, False)
            lift = -self._move.clearance * path.axis
            for point in (path.points[0], path.points[-1], path.points[0] + lift, path.points[-1] + lift):
                if not self._arm.reaches(point, path.axis):
                    raise BadValue("tilt", self._settings.tilt, f"one at which the arm reaches the handle of {name}")
