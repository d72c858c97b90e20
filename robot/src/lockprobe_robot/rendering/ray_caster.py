"""The ray-casting renderer, which needs no graphics library: rays by MuJoCo, shading by NumPy.

It is here so that the twin has pictures on machines without OpenGL, such as containers, continuous integration and
laptops without EGL. MuJoCo itself renders through OpenGL alone.

MuJoCo's rays skip whatever lies outside the bounding box of a body's *colliding* geoms, so they miss geoms that are
only there to be looked at. The rays are therefore cast in a second model. It holds only the geoms that a camera shows,
each as a body that can collide.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe_robot.geom_groups import SHOWN_GROUPS
from lockprobe_robot.rendering.renderer import shown_state, title
from lockprobe_robot.rendering.textures import Textures
from lockprobe_robot.rendering.view_error import ViewError

__all__ = ["RayCaster", "Shader"]

_FAR = 1e3
"""Distance in metres from which the rays of a directional light are cast."""

_MOST_RAYS = 640 * 480
"""Rays that are cast at once: a larger picture is made in bands of rows, so that it takes no more memory."""

_GRAZE = 2e-3
"""Metres. A geom shades a point only if it is nearer to the light by more than this."""


class RayCaster:
    """A renderer that needs no graphics library.

    Args:
        model: What to draw. Sizes and colours of geoms are read once, here.
        width: Pixels.
        height: Pixels.

    Raises:
        BadValue: If the model shows height fields or signed distance fields.
    """

    detail = ""

    def __init__(self, model: mujoco.MjModel, *, width: int, height: int) -> None:
        self.name = title("rays", self.detail)
        self._model = model
        self._shape = (height, width)
        self._seen = mujoco.MjData(model)
        self._shown = _shown_geoms(model)
        self._copies = _shown_only(model, self._shown)
        self._cast = mujoco.MjData(self._copies)
        self._shader = Shader(model)

    def render(
        self, data: mujoco.MjData, camera: str, error: ViewError | None = None
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colours, and depth along the optical axis in metres, 0 where there is nothing."""
        seen = self._seen
        shown_state(self._model, data, seen)
        self._cast.mocap_pos[:] = seen.geom_xpos[self._shown]
        for copied, geom in enumerate(self._shown):
            mujoco.mju_mat2Quat(self._cast.mocap_quat[copied], seen.geom_xmat[geom])
        mujoco.mj_kinematics(self._copies, self._cast)
        eye = self._model.camera(camera).id
        if error is not None:
            error.move(seen, eye)
        height, width = self._shape
        rows = max(1, _MOST_RAYS // width)
        bands = [self._band(eye, range(first, min(first + rows, height))) for first in range(0, height, rows)]
        return np.concatenate([rgb for rgb, _ in bands]), np.concatenate([depth for _, depth in bands])

    def _band(self, eye: int, rows: range) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colours and depth in some rows of the picture."""
        seen, rays = self._seen, self._rays(eye, rows)
        geoms, depth, normals = self._first_hits(seen.cam_xpos[eye], rays)
        hit = geoms >= 0
        points = seen.cam_xpos[eye] + depth[hit, None] * rays[hit]
        colours = np.broadcast_to(self._shader.background, (len(rays), 3)).copy()
        if hit.any():
            colours[hit] = self._shader.shade(
                seen,
                eye=eye,
                geoms=self._shown[geoms[hit]],
                points=points,
                normals=normals[hit],
                pixel=depth[hit] / self._focal(eye),
                lit=[self._lit(light, points) for light in range(self._model.nlight)],
            )
        rgb = np.rint(255 * np.clip(colours, 0, 1)).astype(np.uint8).reshape(len(rows), -1, 3)
        return rgb, np.where(hit, depth, 0).astype(np.float32).reshape(len(rows), -1)

    def close(self) -> None:
        """Do nothing: there are no resources to release."""

    def _focal(self, eye: int) -> float:
        return float(0.5 * self._shape[0] / np.tan(0.5 * np.radians(self._model.cam_fovy[eye])))

    def _rays(self, eye: int, rows: range) -> NDArray[np.float64]:
        """One ray through the centre of every pixel of some rows, in the world, 1 m long along the optical axis."""
        height, width = self._shape
        right, up = np.meshgrid(np.arange(width) - (width - 1) / 2, (height - 1) / 2 - np.array(rows))
        away = np.full(right.shape, -self._focal(eye))
        rays = np.stack([right, up, away], axis=-1).reshape(-1, 3) / self._focal(eye)
        turned: NDArray[np.float64] = rays @ self._seen.cam_xmat[eye].reshape(3, 3).T
        return turned

    def _first_hits(
        self, origin: NDArray[np.float64], rays: NDArray[np.float64]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """Indices into ``shown`` (or -1), distances in ray lengths, normals."""
        geoms = np.empty(len(rays), np.int32)
        distances = np.empty(len(rays))
        normals = np.empty((len(rays), 3))
        flat = np.ascontiguousarray(rays).reshape(-1)
        mujoco.mj_multiRay(
            self._copies,
            self._cast,
            origin,
            flat,
            None,
            True,
            -1,
            geoms,
            distances,
            normals.reshape(-1),
            len(rays),
            _FAR * 2,
        )
        return geoms, distances, normals

    def _lit(self, light: int, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Shadow test: whether a light reaches each point."""
        if not (self._model.light_castshadow[light] and self._model.light_active[light]):
            return np.ones(len(points), dtype=bool)
        origin = self._seen.light_xpos[light]
        if self._model.light_type[light] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL:
            origin = points.mean(axis=0) - _FAR * self._seen.light_xdir[light]
        away = points - origin
        far = np.linalg.norm(away, axis=1, keepdims=True)
        _, distances, _ = self._first_hits(np.array(origin), away / far)
        reached: NDArray[np.bool_] = (distances < 0) | (distances > far[:, 0] - _GRAZE)
        return reached


def _shown_geoms(model: mujoco.MjModel) -> NDArray[np.intp]:
    groups = np.array(SHOWN_GROUPS)[np.clip(model.geom_group, 0, len(SHOWN_GROUPS) - 1)]
    materials = model.geom_matid
    solid = np.where(materials >= 0, model.mat_rgba[materials, 3] if model.nmat else 1, model.geom_rgba[:, 3]) > 0
    shown = np.flatnonzero(groups & solid)
    for kind in (mujoco.mjtGeom.mjGEOM_HFIELD, mujoco.mjtGeom.mjGEOM_SDF):
        if (model.geom_type[shown] == kind).any():
            raise BadValue("renderer", "rays", f"another one for a model that shows {kind.name}")
    return shown


def _shown_only(model: mujoco.MjModel, shown: NDArray[np.intp]) -> mujoco.MjModel:
    """A model of the shown geoms alone, each on a separate body that can be moved anywhere."""
    spec = mujoco.MjSpec()
    meshes = {int(model.geom_dataid[i]) for i in shown if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH}
    for mesh in meshes:
        vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
        faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
        added = spec.add_mesh(name=f"mesh-{mesh}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        added.uservert = model.mesh_vert[vertices].reshape(-1)
        added.userface = model.mesh_face[faces].reshape(-1)
    for geom in shown:
        body = spec.worldbody.add_body(mocap=True)
        kind = mujoco.mjtGeom(int(model.geom_type[geom]))
        copied = body.add_geom(type=kind, size=model.geom_size[geom], contype=1, conaffinity=1)
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            copied.meshname = f"mesh-{model.geom_dataid[geom]}"
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    return spec.compile()


_SHININESS = 128.0
"""Exponent for a material's shininess of 1, as in MuJoCo."""

_DRAWN = (int(mujoco.mjtLightType.mjLIGHT_SPOT), int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL))
"""Kinds of light that MuJoCo draws with OpenGL."""


class Shader:
    """Computes colours from MuJoCo's lights and materials, as OpenGL shows them, without transparency and mirrors.

    Args:
        model: The source of lights, materials and textures.
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
            seen: The poses of everything.
            eye: Id of the camera.
            geoms: The geom on which each point lies, shape (points,).
            points: In the world, shape (points, 3), metres.
            normals: At them, of length 1, outwards, shape (points, 3).
            pixel: Size of a pixel at each point, shape (points,), metres.
            lit: For each light, whether it reaches each point; each of shape (points,).

        Returns:
            Shape (points, 3); 1 is full brightness, more is possible.
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
        # A geom's colour overrides its material's. The compiler leaves this default where the geom has none.
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
        """Directions towards a light, and its strength outside shadows."""
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
