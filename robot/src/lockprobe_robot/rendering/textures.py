"""Texture mapping as in MuJoCo: colours of textures at points of geoms."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["Textures"]

_FLAT = frozenset(map(int, (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER)))
"""Shapes onto which a flat texture is projected along their z axis."""

_Sums = NDArray[np.uint8] | NDArray[np.uint32]

_WHITE = 255

_MOST_HALVED = 12
"""Halvings after which 4096 pixels are one, and sums still fit 32 bits."""

_COLOUR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


class Textures:
    """The textures of a model.

    Args:
        model: The model.

    Attributes:
        background: Colour behind everything, shape (3,): the mean colour of the sky, or black without a sky.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._levels: dict[tuple[int, int], _Sums] = {}
        skies = np.flatnonzero(model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX)
        self.background = self._sums(int(skies[0]), 0).mean(axis=(0, 1)) / _WHITE if skies.size else np.zeros(3)

    def of(self, geom: int) -> int | None:
        """Id of the texture on a geom; None without a texture that the ray caster supports."""
        model = self._model
        material = model.geom_matid[geom]
        texture = model.mat_texid[material, _COLOUR] if material >= 0 else -1
        if texture < 0:
            return None
        flat = model.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_2D
        return None if flat and int(model.geom_type[geom]) not in _FLAT else int(texture)

    def sample(self, geom: int, local: NDArray[np.float64], pixel: float) -> NDArray[np.float64]:
        """Colours of the texture on a geom.

        Args:
            geom: A geom with a texture.
            local: Points on it in the geom's frame, shape (points, 3), metres.
            pixel: Approximate distance between neighbouring points, metres.

        Returns:
            Shape (points, 3), 0 to 1.
        """
        texture = self.of(geom)
        if texture is None:
            return np.ones_like(local)
        if self._model.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_2D:
            return self._flat(geom, texture, local, pixel)
        return self._cube(geom, texture, local)

    def _flat(self, geom: int, texture: int, local: NDArray[np.float64], pixel: float) -> NDArray[np.float64]:
        model = self._model
        material = model.geom_matid[geom]
        size = self._extent(geom)[:2].copy()
        endless = size <= 0
        size[endless] = 1.0
        scale = 0.5 * model.mat_texrepeat[material].astype(np.float64)
        if not model.mat_texuniform[material]:
            scale = np.where(endless, scale, scale / size)
        shift = np.where(endless, 0.0, size)
        across = scale[0] * (local[:, 0] + shift[0])
        upright = 1 if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER else -1
        down = scale[1] * (shift[1] + upright * local[:, 1])
        texels = pixel * max(scale[0] * model.tex_width[texture], scale[1] * model.tex_height[texture])
        # If neighbouring points skip texels, letters break up; so distant textures are sampled from a smaller copy.
        level = min(max(0, round(np.log2(max(texels, 1e-9)))), _MOST_HALVED)
        colours: NDArray[np.float64] = _between(self._sums(texture, level), across, down) / (_WHITE * 4**level)
        return colours

    def _cube(self, geom: int, texture: int, local: NDArray[np.float64]) -> NDArray[np.float64]:
        model = self._model
        directions = local
        if not model.mat_texuniform[model.geom_matid[geom]]:
            directions = local / np.maximum(self._extent(geom), 1e-9)
        axis = np.abs(directions).argmax(axis=1)
        x, y, z = directions.T
        main = np.take_along_axis(directions, axis[:, None], axis=1)[:, 0]
        ahead = main > 0
        across = np.choose(axis, [np.where(ahead, -z, z), x, np.where(ahead, x, -x)])
        down = np.choose(axis, [-y, np.where(ahead, z, -z), -y])
        length = np.maximum(np.abs(main), 1e-12)
        side = self._sums(texture, 0)
        pixels = side.shape[1]
        column = np.clip((0.5 * pixels * (1 + across / length)).astype(np.intp), 0, pixels - 1)
        row = np.clip((0.5 * pixels * (1 + down / length)).astype(np.intp), 0, pixels - 1)
        colours: NDArray[np.float64] = side[(2 * axis + ~ahead) * pixels + row, column] / _WHITE
        return colours

    def _extent(self, geom: int) -> NDArray[np.float64]:
        """Half the sizes of a geom along its axes, shape (3,)."""
        model = self._model
        first, second, third = model.geom_size[geom]
        kind = model.geom_type[geom]
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return np.array([first, first, first])
        if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
            return np.array([first, first, second])
        if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            return np.array([first, first, first + second])
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            half: NDArray[np.float64] = model.geom_aabb[geom, 3:]
            return half
        return np.array([first, second, third])

    def _sums(self, texture: int, level: int) -> _Sums:
        """A mipmap level: a texture halved ``level`` times, shape (height, width, 3).

        Values are sums of 4**level values from 0 to 255, so that large textures take little memory.
        """
        if (texture, level) not in self._levels:
            model = self._model
            if level == 0:
                shape = (model.tex_height[texture], model.tex_width[texture], model.tex_nchannel[texture])
                start = model.tex_adr[texture]
                image = model.tex_data[start : start + int(np.prod(shape, dtype=np.int64))].reshape(shape)
                sums = image[..., :3] if shape[2] >= 3 else np.broadcast_to(image[..., :1], (*shape[:2], 3))
            else:
                sums = _halved(_halved(self._sums(texture, level - 1), 0), 1)
            self._levels[texture, level] = sums
        return self._levels[texture, level]


def _halved(sums: _Sums, axis: int) -> _Sums:
    """The sums with pairs of neighbouring pixels added."""
    pairs = sums.shape[axis] // 2
    if pairs == 0:
        return np.add(sums, sums, dtype=np.uint32)
    first, second = (sums[(slice(None),) * axis + (slice(start, 2 * pairs, 2),)] for start in (0, 1))
    return np.add(first, second, dtype=np.uint32)


def _between(image: _Sums, across: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear samples of a periodically repeated image, in coordinates where 1 is its width or height."""
    height, width = image.shape[:2]
    column, row = across * width - 0.5, down * height - 0.5
    left, top = np.floor(column).astype(np.intp), np.floor(row).astype(np.intp)
    right, below = (column - left)[:, None], (row - top)[:, None]
    upper = (1 - right) * image[top % height, left % width] + right * image[top % height, (left + 1) % width]
    bottom = (top + 1) % height
    lower = (1 - right) * image[bottom, left % width] + right * image[bottom, (left + 1) % width]
    mixed: NDArray[np.float64] = (1 - below) * upper + below * lower
    return mixed
