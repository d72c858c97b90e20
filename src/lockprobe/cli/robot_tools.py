"""What commands call in the distribution lockprobe-robot: drawings of boxes for the workshop, films, checks."""

from __future__ import annotations

from typing import Any, Literal

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.plugins import find_plugin

__all__ = ["robot_tool"]


def robot_tool(name: Literal["box-model", "box-template", "doctor", "film"], what: str) -> Any:
    """A function of lockprobe-robot, by its entry point in the group ``lockprobe.tools``.

    Args:
        name: Its name.
        what: What needs it, in the plural, for the message.

    Raises:
        Missing: If lockprobe-robot is not installed.
    """
    plugin = find_plugin("tool", name)
    if plugin is None or not plugin.ships:
        raise Missing(f"{what} need the package lockprobe-robot", "pip install 'lockprobe[twin]'")
    return plugin.load()
