"""The plant ``twin``: a physical lockbox that a robot arm acts on (paper, Sec. 2.1).

A snapshot holds both the truth and the robot's verdict. The outcome is the state of the mechanism at rest; ``sensed``
holds the measurements and the verdict of the arm's guarded move.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.plants.catalogue import FilmHook
from lockprobe.trial.record import Fact
from lockprobe_robot.arm.guarded_move import CLEARANCE, HandlePath, guarded_move
from lockprobe_robot.arm.model import add_arm, add_hand
from lockprobe_robot.arm.simulated_arm import SimulatedArm
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.simulated_plant import SimulatedPlant
from lockprobe_robot.twin_settings import TwinSettings
from lockprobe_robot.user_model.mjcf_file import read_hand

_PATIENCE = 1.0
"""Longest wait for the mechanism to come to rest after the arm is at home, seconds."""

_FILM_EVERY = 1 / 25
"""Simulated seconds between two pictures of a film."""


class Twin(SimulatedPlant):
    """A lockbox, an arm and a camera in one simulation.

    Before every attempt the robot receives the true positions of the handles, up to ``pose_error``, so a wrong verdict
    does not mislead its next move.

    Args:
        rng: The trial's random stream for the plant. The appearance draws from it; depth noise, pose error and force
            noise each draw from a child of it. The n-th look and the n-th attempt have the same luck whatever the
            settings are. Every attempt has a separate force stream, because attempts differ in length.
        film: Called about 25 times per simulated second with the model and its state, which it must not change.

    Raises:
        BadValue: If the box cannot be built, or its handles cannot be reached.
        BadFile: If one's own hand cannot be mounted.
    """

    joints: Mechanism
    _settings: TwinSettings

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
        hand = read_hand(Path(settings.hand), settings.hand_digest) if settings.hand else None
        add_hand(scene.spec, add_arm(scene.spec), hand)
        self.panel = panel = scene.panel
        super().__init__(Mechanism(scene), pose=panel.pose, handles=panel.handles, settings=settings, rng=noise)
        model, data = self.joints.model, self.joints.data
        self._film_due = 0.0

        def after_step() -> None:
            if film is not None and data.time >= self._film_due:
                self._film_due += _FILM_EVERY
                film(model, data)

        self.arm = SimulatedArm(model, data, force_noise=settings.force_noise, rng=self._force, after_step=after_step)
        for joint, name in enumerate(box.names):
            path = panel.handle_path(joint, False)
            lift = -CLEARANCE * path.axis
            for point in (path.points[0], path.points[-1], path.points[0] + lift, path.points[-1] + lift):
                if not self.arm.reaches(point, path.axis):
                    raise BadValue("tilt", settings.tilt, f"one at which the arm reaches the handle of {name}")
        self.put(box.initial)

    def put(self, configuration: Configuration) -> None:
        """Set the configuration with the arm at home, at rest; for measurements."""
        self.joints.set_configuration(configuration)
        self.arm.stand()
        self.settle()

    def _act(self, joint: int, before: Configuration) -> Mapping[str, Fact]:
        """The guarded move along the handle's path, with a random pose error in the panel's plane."""
        self.arm.rng = self._force.spawn(1)[0]
        shift = self._settings.pose_error * self._aim.standard_normal(2)
        path = self.panel.handle_path(joint, before[joint])
        believed = HandlePath(points=path.points + self.panel.pose[:3, :2] @ shift, axis=path.axis)
        touch = guarded_move(self.arm, believed)
        if self.settle():
            return touch.as_facts()
        # The hand left a handle between its ends. A person would push it to the nearer one.
        self.joints.set_configuration(self.joints.configuration())
        self.settle()
        return {**touch.as_facts(), "nudged": True}

    def settle(self) -> bool:
        """Wait until every joint is at an end, up to a time limit; whether they are."""
        deadline = self.arm.time + _PATIENCE
        self.arm.wait()
        while not self.joints.resting() and self.arm.time < deadline:
            self.arm.wait()
        return self.joints.resting()
