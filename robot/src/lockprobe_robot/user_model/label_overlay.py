"""Draws the labels of joints over a picture of a user's model, which has no labels itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import Missing

_HEIGHT = 0.05
"""Height of the letters, as a share of the picture's height."""


def draw_labels(rgb: NDArray[np.uint8], labels: Sequence[str], places: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Draw labels on a picture, white with a dark outline.

    Args:
        rgb: Shape (height, width, 3).
        labels: One per joint.
        places: Column and row of the middle of each label, shape (joints, 2), pixels. Labels outside the picture are
            not seen.

    Returns:
        A new picture of the same shape.

    Raises:
        Missing: If Pillow is not installed.
    """
    try:
        from PIL import Image, ImageDraw, ImageFont
    except ImportError:
        raise Missing("the twins need the package pillow", "pip install 'lockprobe[twin]'") from None
    image = Image.fromarray(rgb)
    draw, size = ImageDraw.Draw(image), _HEIGHT * rgb.shape[0]
    font = ImageFont.load_default(size)
    for label, (column, row) in zip(labels, places, strict=True):
        if 0 <= column < rgb.shape[1] and 0 <= row < rgb.shape[0]:
            at = (float(column), float(row))
            draw.text(at, label, (255, 255, 255), font, anchor="mm", stroke_width=2, stroke_fill=(20, 20, 20))
    return np.asarray(image)
