"""The texture of the board: wood, the dark track of every handle with its two ends, and the labels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lockprobe_robot.box_model.appearance import Appearance, Colour
from lockprobe_robot.box_model.mounted_joint import TRACK_RADIUS, WAY_RADIUS
from lockprobe_robot.box_model.panel import PanelLayout
from lockprobe_robot.twin_settings import SceneSettings

PIXELS_PER_METRE = 1600

_MARK = 0.6
"""Radius of the mark of the target, in heights of a letter."""

_DARK = (30, 27, 26)
_START, _END = (245, 245, 240), (30, 27, 26)
_INK, _PAPER, _TARGET = (22, 20, 20), (250, 250, 245), (28, 78, 140)


def paint_board(
    panel: PanelLayout, labels: Sequence[str], appearance: Appearance, settings: SceneSettings, *, target: int
) -> NDArray[np.uint8]:
    """Paint the front of the board.

    The track of each handle is dark. A white disc marks its position 0, a black one its position 1. The label of the
    target, a joint by index in panel order, is white on a blue disc. Settings leave out discs, tracks or labels.

    Returns:
        Shape (rows, columns, 3); the first row is the board's upper edge.
    """
    columns, rows = (round(side * PIXELS_PER_METRE) for side in panel.size)
    image = Image.fromarray(wood((rows, columns), appearance.wood, appearance.grain))
    draw = ImageDraw.Draw(image)
    for mounted in panel.mounted_joints if settings.board == "painted" else ():
        points = [_pixel(panel, mounted.knob(float(fraction))) for fraction in np.linspace(0, 1, 65)]
        for point in points:
            _disc(draw, point, TRACK_RADIUS, _DARK)
        for point, inside in ((points[0], _START), (points[-1], _END)) if settings.discs else ():
            _disc(draw, point, WAY_RADIUS, _DARK)
            _disc(draw, point, 0.0185, (240, 240, 235))
            _disc(draw, point, 0.0150, inside)
    font = ImageFont.load_default(panel.letter * PIXELS_PER_METRE / 0.72)
    for number, (label, point) in enumerate(zip(labels, panel.labels, strict=True) if settings.labels else ()):
        ink, place = _PAPER if number == target else _INK, _pixel(panel, point)
        if number == target:
            _disc(draw, place, _MARK * panel.letter, _TARGET)
        draw.text(place, label, fill=ink, font=font, anchor="mm", stroke_width=2, stroke_fill=ink)
    return np.asarray(image)


def wood(shape: tuple[int, int], colour: Colour, grain: int) -> NDArray[np.uint8]:
    """A wood texture of a mean colour, shape (rows, columns, 3); the same ``grain`` gives the same pattern."""
    rng = np.random.Generator(np.random.PCG64(grain))
    rows, columns = shape
    y = np.linspace(0, rows / PIXELS_PER_METRE, rows, dtype=np.float32)[:, None]
    x = np.linspace(0, columns / PIXELS_PER_METRE, columns, dtype=np.float32)[None]
    phases = rng.random(6).astype(np.float32) * 6.28
    wave = 0.006 * np.sin(5 * x + phases[0]) + 0.003 * np.sin(13 * x + phases[1]) + 0.002 * np.sin(31 * x + phases[5])
    depth = y + wave
    rings = np.sin(190 * depth + 2.2 * np.sin(37 * depth + phases[2]) + phases[3])
    fine = np.repeat(rng.random((rows, columns // 48 + 1), dtype=np.float32), 48, axis=1)[:, :columns] - 0.5
    shade = 1 + 0.05 * rings + 0.02 * np.sin(700 * depth + phases[4]) + 0.05 * fine
    picture = np.clip(255 * shade[..., None] * np.array(colour, dtype=np.float32), 0, 255)
    return np.asarray(picture, dtype=np.uint8)


def _pixel(panel: PanelLayout, point: NDArray[np.float64]) -> tuple[float, float]:
    """Column and row of a point of the panel's frame in its picture."""
    x, y = (np.asarray(point) * (1, -1) + np.array(panel.size) / 2) * PIXELS_PER_METRE
    return float(x), float(y)


def _disc(draw: ImageDraw.ImageDraw, middle: tuple[float, float], radius: float, fill: tuple[int, int, int]) -> None:
    reach = radius * PIXELS_PER_METRE
    draw.ellipse((middle[0] - reach, middle[1] - reach, middle[0] + reach, middle[1] + reach), fill=fill)
