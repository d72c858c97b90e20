"""The appearance of a scene, which does not change the physics: colours, light, camera.

It is fixed, or drawn in each trial, as a whole (``looks``) or factor by factor.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lockprobe_robot.twin_settings import SceneSettings

Colour = tuple[float, float, float]
"""Red, green, blue, 0 to 1."""

_DRAWS = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Appearance:
    """The visual parameters of a scene; left out, as in every plain one.

    Attributes:
        wood: Colour of board and case.
        grain: Seed of the wood's pattern.
        knob: Colour of handles.
        bar: Colour of levers and of the bars under sliders' handles.
        pivot: Colour of the pins about which levers turn.
        floor: Colour of the ground.
        light: Offset of the lamp from the panel in x and y, metres.
        lamp_height: Height of the lamp above the ground, metres.
        brightness: Brightness of the lamp, as a multiple of the default.
        ambient: Brightness of the light from everywhere, likewise.
        camera: Offset of the camera from its default position, x, y, z in metres in the world.
        luck: Seed of places, shapes and colours of what lies on the board.
    """

    wood: Colour = (0.80, 0.63, 0.43)
    grain: int = 1
    knob: Colour = (0.86, 0.13, 0.10)
    bar: Colour = (0.98, 0.76, 0.14)
    floor: Colour = (0.33, 0.35, 0.38)
    light: tuple[float, float] = (-0.25, 0.35)
    brightness: float = 1.0
    camera: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot: Colour = (0.2, 0.2, 0.2)
    lamp_height: float = 1.6
    ambient: float = 1.0
    luck: int = 0


_PLAIN = Appearance()
_SECOND = Appearance(wood=(0.47, 0.33, 0.24), knob=(0.10, 0.42, 0.80), bar=(0.86, 0.86, 0.82), floor=(0.60, 0.58, 0.53))

_WOODS: tuple[Colour, ...] = (
    _PLAIN.wood,
    (0.86, 0.74, 0.56),
    (0.70, 0.50, 0.33),
    (0.76, 0.58, 0.46),
    (0.83, 0.71, 0.47),
)

_LIGHTS: dict[str, dict[str, Any]] = {
    "side": {"light": (0.0, -1.5), "lamp_height": 0.95, "brightness": 1.5, "ambient": 0.75},
    "dim": {"light": _PLAIN.light, "brightness": 0.3, "ambient": 0.3},
}


def appearance_of(settings: SceneSettings, rng: np.random.Generator) -> Appearance:
    """The appearance of one trial. The number of draws does not depend on the settings."""
    drawn = [float(number) for number in rng.random(_DRAWS)]
    grey = drawn[5]
    varied = Appearance(
        wood=_WOODS[int(drawn[0] * len(_WOODS))],
        grain=int(drawn[1] * 2**31),
        knob=colorsys.hsv_to_rgb(drawn[2], 0.88, 0.82),
        bar=colorsys.hsv_to_rgb((drawn[2] + 0.30 + 0.4 * drawn[3]) % 1, 0.75, 0.95),
        floor=(0.25 + 0.25 * grey, 0.27 + 0.25 * grey, 0.30 + 0.22 * grey),
        light=(-0.45 + 0.6 * drawn[7], -0.6 + 1.2 * drawn[8]),
        brightness=0.8 + 0.35 * drawn[9],
        camera=(0.03 * (2 * drawn[10] - 1), 0.03 * (2 * drawn[11] - 1), 0.03 * (2 * drawn[12] - 1)),
    )
    look = varied if settings.looks == "varied" else _PLAIN
    of = {"plain": look, "second": _SECOND, "drawn": varied}[settings.colours]
    look = replace(look, wood=of.wood, knob=of.knob, bar=of.bar, floor=of.floor, **_LIGHTS.get(settings.light, {}))
    if settings.handle_colours == "plain":
        look = replace(look, bar=look.knob, pivot=look.knob)
    return replace(look, luck=int(drawn[13] * 2**53))
