"""Image degradation: an opaque patch, then blur, then exposure, then sensor noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_probability
from lockprobe.trial.pictures.frame import Frame

_PATCH: Final = 128
"""Grey level of the patch."""

_MARGIN: Final = 0.5
"""Margin of the panel around the handles, as a share of a handle's travel."""

_STOPS: Final = 20
"""Most stops of exposure in either direction: more make every picture black, or white."""

_SEEDS: Final = 2**53


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """The degradation of a picture, of which the camera's options say more.

    ``blur`` and ``noise`` are standard deviations, in pixels and as a share of full brightness; ``occlude`` is the
    share of the panel that an opaque patch hides, [0, 1]; one more stop of ``exposure`` is twice the light, and the
    sensor clips what is too bright for it.
    """

    blur: float = 0.0
    noise: float = 0.0
    occlude: float = 0.0
    exposure: float = 0.0

    def __post_init__(self) -> None:
        for name in ("blur", "noise"):
            if not 0 <= (value := getattr(self, name)) < float("inf"):
                raise BadValue(name, value, "a number from 0")
        check_probability("occlude", self.occlude)
        if not -_STOPS <= self.exposure <= _STOPS:
            raise BadValue("exposure", self.exposure, f"a number from {-_STOPS} to {_STOPS}")


def degraded(frame: Frame, damage: Damage, luck: NDArray[np.float64]) -> Frame:
    """Degrade a picture; without damage it is unchanged.

    A larger patch covers every smaller one, and more noise is the same noise scaled. ``luck`` holds three numbers,
    [0, 1): position of the patch across and down, and the seed of the noise.
    """
    if damage == Damage():
        return frame
    rgb, depth = frame.rgb.astype(np.float64), frame.depth
    if damage.occlude:
        patch, depth = _patch(frame, damage.occlude, luck), depth.copy()
        rgb[patch], depth[patch] = _PATCH, 0
    if damage.blur:
        from scipy.ndimage import gaussian_filter

        rgb = gaussian_filter(rgb, (damage.blur, damage.blur, 0), mode="nearest")
    if damage.exposure:  # of light, which adds up before it is coded as sRGB
        coded = rgb / 255
        light = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
        light = np.clip(light * 2.0**damage.exposure, 0, 1)
        rgb = 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    if damage.noise:
        rng = np.random.Generator(np.random.PCG64(int(luck[2] * _SEEDS)))
        rgb = rgb + 255 * damage.noise * rng.standard_normal(rgb.shape)
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
