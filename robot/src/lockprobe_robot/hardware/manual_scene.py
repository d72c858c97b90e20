"""The scene in front of a camera that a person sets up: the looks of ``fast-twin``, in words for that person."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from lockprobe_robot.twin_settings import HandleColours, Light, SceneSettings, Viewpoint


@dataclass(frozen=True, slots=True, kw_only=True)
class ManualScene:
    """Options of ``manual`` with a camera. They have the names and levels of those of the simulated scene.

    Attributes:
        discs: Whether discs mark the ends of the track of every handle.
        handle_colours: Whether a handle differs from its bar in colour.
        labels: Whether the labels of the joints are on the board.
        clutter: Number of small objects on and beside the board.
        light: The light.
        colours: The colours of board, handles and bars: the usual ones, or second ones that the lab chooses.
        viewpoint: Where the camera stands.
        view_jitter: About how far the camera is moved before every picture, millimetres.

    Raises:
        BadValue: If a number is out of the range of the simulated scene.
    """

    discs: bool = True
    handle_colours: HandleColours = "coloured"
    labels: bool = True
    clutter: int = 0
    light: Light = "plain"
    colours: Literal["plain", "second"] = "plain"
    viewpoint: Viewpoint = "plain"
    view_jitter: float = 0.0

    def __post_init__(self) -> None:
        SceneSettings(clutter=self.clutter, view_jitter=self.view_jitter)

    @property
    def levels(self) -> dict[str, bool | int | float | str]:
        """Option -> its level."""
        return {part.name: getattr(self, part.name) for part in fields(ManualScene)}

    @property
    def instruction(self) -> str:
        """What the person is asked to set up: all that differs from the plain scene.

        >>> ManualScene(discs=False, light="side").instruction
        'Set up the scene: no discs; light from a low lamp at the right.'
        >>> ManualScene().instruction
        'Set up the plain scene.'
        """
        asked = {
            "no discs": not self.discs,
            "handles in the colour of their bars": self.handle_colours == "plain",
            "no labels": not self.labels,
            f"{self.clutter} small objects on and beside the board, at new places": self.clutter > 0,
            "light from a low lamp at the right": self.light == "side",
            "30 % of the light": self.light == "dim",
            "the second colours of board, handles and bars": self.colours == "second",
            "camera at its place on the left side of the board": self.viewpoint == "oblique",
            f"before every picture move the camera from its place by about {self.view_jitter:g} mm": (
                self.view_jitter > 0
            ),
        }
        changes = "; ".join(words for words, applies in asked.items() if applies)
        return f"Set up the scene: {changes}." if changes else "Set up the plain scene."
