"""Image degradation: an opaque patch, then blur, then exposure, then sensor noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lockprobe.trial.pictures.frame import Frame

_PATCH: Final = 128
"""Grey level of the patch."""

_MARGIN: Final = 0.5
"""Margin of the panel around the handles, as a share of a handle's travel."""

_SEEDS: Final = 2**53


def degraded(
    frame: Frame,
    luck: NDArray[np.float64],
    *,
    blur: float = 0.0,
    noise: float = 0.0,
    occlude: float = 0.0,
    exposure: float = 0.0,
) -> Frame:
    """Degrade a picture, by the options of a camera that describes them; without any it is unchanged.

    A larger patch covers every smaller one, and more noise is the same noise scaled. ``luck`` holds three numbers,
    [0, 1): position of the patch across and down, and the seed of the noise.
    """
    if not (blur or noise or occlude or exposure):
        return frame
    rgb, depth = frame.rgb.astype(np.float64), frame.depth
    if occlude:
        patch, depth = _patch(frame, occlude, luck), depth.copy()
        rgb[patch], depth[patch] = _PATCH, 0
    if blur:
        from scipy.ndimage import gaussian_filter

        rgb = gaussian_filter(rgb, (blur, blur, 0), mode="nearest")
    if exposure:  # of light, which adds up before it is coded as sRGB
        coded = rgb / 255
        light = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
        light = np.clip(light * 2.0**exposure, 0, 1)
        rgb = 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    if noise:
        rng = np.random.Generator(np.random.PCG64(int(luck[2] * _SEEDS)))
        rgb = rgb + 255 * noise * rng.standard_normal(rgb.shape)
    return replace(frame, rgb=np.rint(np.clip(rgb, 0, 255)).astype(np.uint8), depth=depth)


def _patch(frame: Frame, share: float, luck: NDArray[np.float64]) -> tuple[slice, slice]:
    """The rows and columns of the patch."""
    places = frame.camera.project(frame.handles)[..., :2]
    apart = float(np.median(np.linalg.norm(places[:, 1] - places[:, 0], axis=-1)))
    low = places.min(axis=(0, 1)) - _MARGIN * apart
    size = places.max(axis=(0, 1)) + _MARGIN * apart - low
    first = low + luck[:2] * size * (1 - np.sqrt(share))
    last = first + size * np.sqrt(share)
    (left, top), (right, bottom) = (np.clip(np.rint(end), 0, None).astype(int).tolist() for end in (first, last))
    return slice(top, bottom), slice(left, right)
