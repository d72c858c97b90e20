"""The joints of a box in a compiled model, ours or a user's: where they stand, and where they are drawn."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import PlantFault

RESTING = 0.08
"""Largest distance of a resting joint from an end, as a fraction of its travel."""


_SETTLE_SECONDS = 1.0


class Joints:
    """The joints of a box (base class); a push is a subclass's, and so are the speeds at which they count as quiet.

    Position 0 of a joint is the low end of its range, position 1 the high end. Joints are in panel order, and so are
    ``bodies``, those that they move.
    """

    _scale: NDArray[np.float64]
    """What the speeds of all degrees of freedom are multiplied by before they are compared."""
    _quiet: tuple[float, float]
    """The speed below which nothing counts as moving, and for how long, seconds."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[str]) -> None:
        self.model, self.data, self.names = model, data, tuple(joints)
        ids = [model.joint(name).id for name in joints]
        self._addresses, self._dofs = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        self._low, high = model.jnt_range[ids].T
        self._travel = high - self._low
        self.bodies: NDArray[np.intp] = model.jnt_bodyid[ids]

    def step(self) -> None:
        """One step of the simulation."""
        mujoco.mj_step(self.model, self.data)

    def push(self, joint: int) -> None:
        """Push a joint, by index in panel order, towards its other end, and let everything come to rest."""
        raise NotImplementedError

    def settle(self) -> None:
        """Step until nothing moves, at most a second."""
        quiet, (speed, seconds) = 0, self._quiet
        for _ in range(self._steps(_SETTLE_SECONDS)):
            self.step()
            quiet = 0 if np.abs(self.data.qvel * self._scale).max() > speed else quiet + 1
            if quiet >= self._steps(seconds):
                return

    def _steps(self, seconds: float) -> int:
        return max(1, round(seconds / float(self.model.opt.timestep)))

    def fractions(self) -> NDArray[np.float64]:
        """How far each joint is from position 0, as a fraction of its travel."""
        fractions: NDArray[np.float64] = (self.data.qpos[self._addresses] - self._low) / self._travel
        return fractions

    def configuration(self) -> Configuration:
        """The configuration: for each joint the nearer end of its travel."""
        return tuple(bool(fraction > 0.5) for fraction in self.fractions())

    def resting(self) -> bool:
        """Whether every joint is at an end of its travel, within a tolerance."""
        fractions = self.fractions()
        return bool((np.minimum(np.abs(fractions), np.abs(1 - fractions)) <= RESTING).all())

    def where(self) -> str:
        """Each joint with the fraction of its travel, as text for messages."""
        return ", ".join(f"{name} {fraction:.2f}" for name, fraction in zip(self.names, self.fractions(), strict=True))

    def configuration_after(self, joint: int, before: Configuration, *, locked: bool = False) -> Configuration:
        """The configuration after an attempt at a joint, which the rules may lock as far as is known.

        Raises:
            PlantFault: If a joint is between its ends, or a joint moved that was not attempted.
        """
        after = self.configuration()
        if not self.resting():
            gap, name = abs(float(self.fractions()[joint]) - before[joint]), self.names[joint]
            if locked and gap > RESTING:
                raise PlantFault(
                    f"{name} moves {gap:.0%} of its travel before something holds it ({self.where()}): close the gap "
                    f"to less than {RESTING:.0%}"
                )
            raise PlantFault(
                f"a joint stays more than {RESTING:.0%} of its travel from its ends ({self.where()}): it needs less "
                "friction (frictionloss, damping), a spring, or a push with more force"
            )
        if others := [name for i, name in enumerate(self.names) if i != joint and after[i] != before[i]]:
            raise PlantFault(f"{self.names[joint]} moved {', '.join(others)} as well ({self.where()})")
        return after

    def ends(self, configuration: Configuration) -> NDArray[np.float64]:
        """The position of every joint in a configuration: metres or radians."""
        ends: NDArray[np.float64] = self._low + np.where(configuration, self._travel, 0.0)
        return ends

    def posed(self, configuration: Configuration) -> mujoco.MjData:
        """A copy of the state in which every joint is in the given configuration; other parts stay where they are."""
        copied = copy.copy(self.data)
        elsewhere = np.array(configuration) != np.array(self.configuration())
        copied.qpos[self._addresses[elsewhere]] = self.ends(configuration)[elsewhere]
        return copied
