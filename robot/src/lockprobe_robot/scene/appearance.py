"""The appearance of a scene: colours, handle shapes, light and camera offset, fixed or randomised in each trial.

The appearance does not change the physics.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe_robot.twin_settings import Looks

__all__ = ["HANDLES", "Appearance", "Colour", "HandleShape", "appearance_of"]

Colour = tuple[float, float, float]
"""Red, green, blue, 0 to 1."""

HandleShape = Literal["round", "capped", "ball", "grooved"]
"""Visible shape of a handle. The shape that a hand can touch is always the same round knob."""

HANDLES: tuple[HandleShape, ...] = ("round", "capped", "ball", "grooved")

_DRAWS = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Appearance:
    """The visual parameters of a scene.

    Attributes:
        wood: Colour of board and case.
        grain: Seed of the wood's pattern.
        knob: Colour of handles.
        bar: Colour of levers and of the bars under sliders' handles.
        floor: Colour of the ground.
        handle: Shape of handles.
        light: Offset of the lamp from the panel in x and y, metres; it is 1.6 m above the ground.
        brightness: Brightness of the lamp, as a multiple of the default.
        camera: Offset of the camera from its default position, x, y, z in metres in the world.
    """

    wood: Colour
    grain: int
    knob: Colour
    bar: Colour
    floor: Colour
    handle: HandleShape
    light: tuple[float, float]
    brightness: float
    camera: tuple[float, float, float]


_PLAIN = Appearance(
    wood=(0.80, 0.63, 0.43),
    grain=1,
    knob=(0.86, 0.13, 0.10),
    bar=(0.98, 0.76, 0.14),
    floor=(0.33, 0.35, 0.38),
    handle="round",
    light=(-0.25, 0.35),
    brightness=1.0,
    camera=(0.0, 0.0, 0.0),
)

_WOODS: tuple[Colour, ...] = (
    (0.80, 0.63, 0.43),
    (0.86, 0.74, 0.56),
    (0.70, 0.50, 0.33),
    (0.76, 0.58, 0.46),
    (0.83, 0.71, 0.47),
)


def appearance_of(looks: Looks, rng: np.random.Generator) -> Appearance:
    """The appearance of one trial.

    Args:
        looks: ``plain`` always gives the same appearance.
        rng: Random stream. The number of draws does not depend on ``looks``.
    """
    drawn = rng.random(_DRAWS)
    if looks == "plain":
        return _PLAIN
    hue, grey = float(drawn[2]), float(drawn[5])
    other = (hue + 0.30 + 0.4 * float(drawn[3])) % 1
    return Appearance(
        wood=_WOODS[int(drawn[0] * len(_WOODS))],
        grain=int(drawn[1] * 2**31),
        knob=colorsys.hsv_to_rgb(hue, 0.88, 0.82),
        bar=colorsys.hsv_to_rgb(other, 0.75, 0.95),
        floor=(0.25 + 0.25 * grey, 0.27 + 0.25 * grey, 0.30 + 0.22 * grey),
        handle=HANDLES[int(drawn[6] * len(HANDLES))],
        light=(-0.45 + 0.6 * float(drawn[7]), -0.6 + 1.2 * float(drawn[8])),
        brightness=0.8 + 0.35 * float(drawn[9]),
        camera=tuple(0.03 * (2 * float(x) - 1) for x in drawn[10:13]),  # type: ignore[arg-type]
    )
