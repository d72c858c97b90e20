"""Light, colours and textures at the points that rays have hit, as OpenGL would show them."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.plants.rendering.textures import Textures

__all__ = ["Shader"]

_SHININESS = 128.0
"""What a material's shininess of 1 is as an exponent, as in MuJoCo."""

_DRAWN = (int(mujoco.mjtLightType.mjLIGHT_SPOT), int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL))
"""Kinds of light that MuJoCo draws with OpenGL."""


class Shader:
    """Computes colours by MuJoCo's lights and materials; transparency and mirrors are left out.

    Args:
        model: Where lights, materials and textures come from.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._textures = Textures(model)
        self.background = self._textures.background

    def shade(
        self,
        seen: mujoco.MjData,
        *,
        eye: int,
        geoms: NDArray[np.intp],
        points: NDArray[np.float64],
        normals: NDArray[np.float64],
        pixel: NDArray[np.float64],
        lit: list[NDArray[np.bool_]],
    ) -> NDArray[np.float64]:
        """Colours of points.

        Args:
            seen: Where everything is.
            eye: Number of the camera that looks.
            geoms: On which geom of the model each point lies, shape (points,).
            points: In the world, shape (points, 3), metres.
            normals: At them, of length 1, outwards, shape (points, 3).
            pixel: Size of a pixel at each point, shape (points,), metres.
            lit: For each light of the model which points it reaches, each of shape (points,).

        Returns:
            Shape (points, 3); 1 is full, more is possible.
        """
        model = self._model
        texture = self._texture(seen, geoms, points, pixel)
        specular, shininess, emission = self._gloss(geoms)
        watched = seen.cam_xpos[eye] - points
        watched /= np.linalg.norm(watched, axis=1, keepdims=True)
        light = np.repeat(emission[:, None], 3, axis=1)
        gloss = np.zeros_like(light)
        head = model.vis.headlight
        if head.active:
            towards = np.broadcast_to(seen.cam_xmat[eye].reshape(3, 3)[:, 2], points.shape)
            facing = np.clip(np.einsum("ij,ij->i", normals, towards), 0, None)
            light += head.ambient + facing[:, None] * head.diffuse
            gloss += self._glint(normals, towards, watched, shininess)[:, None] * head.specular
        for number, reached in enumerate(lit):
            if not model.light_active[number] or model.light_type[number] not in _DRAWN:
                continue
            towards, strength = self._beam(seen, number, points)
            facing = np.clip(np.einsum("ij,ij->i", normals, towards), 0, None)
            light += strength[:, None] * model.light_ambient[number]
            strength = strength * reached
            light += (facing * strength)[:, None] * model.light_diffuse[number]
            glint = self._glint(normals, towards, watched, shininess) * strength * (facing > 0)
            gloss += glint[:, None] * model.light_specular[number]
        colours: NDArray[np.float64] = texture * (self._paint(geoms) * light + specular[:, None] * gloss)
        return colours

    def _paint(self, geoms: NDArray[np.intp]) -> NDArray[np.float64]:
        model = self._model
        rgba = model.geom_rgba.astype(np.float64)
        dressed = model.geom_matid >= 0
        # A colour of the geom itself goes before its material's; the compiler leaves this one where there is none.
        plain = dressed & (rgba == (0.5, 0.5, 0.5, 1)).all(axis=1)
        rgba[plain] = model.mat_rgba[model.geom_matid[plain]]
        paint: NDArray[np.float64] = rgba[geoms, :3]
        return paint

    def _texture(
        self, seen: mujoco.MjData, geoms: NDArray[np.intp], points: NDArray[np.float64], pixel: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        texture = np.ones_like(points)
        for geom in np.unique(geoms):
            if self._textures.of(int(geom)) is None:
                continue
            here = geoms == geom
            local = (points[here] - seen.geom_xpos[geom]) @ seen.geom_xmat[geom].reshape(3, 3)
            texture[here] = self._textures.sample(int(geom), local, float(np.median(pixel[here])))
        return texture

    def _gloss(self, geoms: NDArray[np.intp]) -> tuple[NDArray[np.float64], ...]:
        """Specular reflection, exponent and emission at each point; without a material MuJoCo takes 0.5, 0.5, 0."""
        model = self._model
        columns = []
        for values, default in ((model.mat_specular, 0.5), (model.mat_shininess, 0.5), (model.mat_emission, 0.0)):
            of_geoms = np.full(model.ngeom, default)
            dressed = model.geom_matid >= 0
            of_geoms[dressed] = values[model.geom_matid[dressed]]
            columns.append(of_geoms[geoms])
        return columns[0], columns[1] * _SHININESS, columns[2]

    def _beam(
        self, seen: mujoco.MjData, number: int, points: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Directions towards a light, and how strong it is where it is not in shadow."""
        model = self._model
        along = seen.light_xdir[number]
        kind = model.light_type[number]
        if kind == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL:
            return np.broadcast_to(-along, points.shape), np.ones(len(points))
        towards = seen.light_xpos[number] - points
        far = np.linalg.norm(towards, axis=1)
        towards /= far[:, None]
        constant, linear, square = model.light_attenuation[number]
        strength = 1 / (constant + linear * far + square * far**2)
        if kind == mujoco.mjtLightType.mjLIGHT_SPOT:
            middle = np.clip(-towards @ along, 0, 1)
            cone = middle >= np.cos(np.radians(min(model.light_cutoff[number], 90.0)))
            strength = strength * cone * middle ** model.light_exponent[number]
        return towards, strength

    @staticmethod
    def _glint(
        normals: NDArray[np.float64],
        towards: NDArray[np.float64],
        watched: NDArray[np.float64],
        shininess: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        between = towards + watched
        between /= np.linalg.norm(between, axis=1, keepdims=True)
        glint: NDArray[np.float64] = np.clip(np.einsum("ij,ij->i", normals, between), 0, 1) ** shininess
        return glint
