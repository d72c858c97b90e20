"""Lockprobe on physical boxes: the MuJoCo twin with its robot arm, films, calibration, and adapters of real robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mujoco

    from lockprobe.boxes.box import Lockbox

__all__ = ["scene"]


def scene(box: Lockbox, *, arm: bool = False) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A box as a plain MuJoCo model, and its state at the start of a trial.

    ``lockprobe box show NAME --out scene.xml`` writes the same model.

    Args:
        box: The box, for example ``lockprobe.box("chain-4")``.
        arm: Whether the arm stands before it, with motors and force sensor.

    Raises:
        BadValue: If the box cannot be built.
        Missing: If a package is missing.
    """
    from lockprobe_robot.box_model.mjcf import plain_model
    from lockprobe_robot.rendering.probe import require_mujoco

    require_mujoco()
    return plain_model(box, arm=arm)
