"""What commands call in the distribution lockprobe-robot: models of boxes, films, the doctor."""

from __future__ import annotations

from typing import Any, Literal

from lockprobe.foundation.plugins import robot_plugin


def robot_tool(name: Literal["box-model", "doctor", "film"], what: str) -> Any:
    """A function of lockprobe-robot, by its entry point in the group ``lockprobe.tools``.

    Args:
        name: Its name.
        what: What needs it, in the plural, for the message.

    Raises:
        Missing: If lockprobe-robot is not installed.
    """
    return robot_plugin("tool", name, f"{what} need").load()
