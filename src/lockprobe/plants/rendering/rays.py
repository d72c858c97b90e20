"""Pictures without any graphics library: rays cast by MuJoCo, light and colours by numpy.

MuJoCo's rays leave out whatever lies outside the box around a body's *colliding* geoms, so that they do not see geoms
which are there only to be looked at. They are therefore cast in a model of its own, which holds nothing but the geoms
that a camera shows, each as a body that can collide.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue
from lockprobe.plants.rendering.probing import title
from lockprobe.plants.rendering.shading import Shader
from lockprobe.plants.rendering.visible import SHOWN_GROUPS, shown_state

__all__ = ["RayCaster"]

_FAR = 1e3
"""Metres from which a light's rays are cast if it shines from infinitely far away."""

_GRAZE = 2e-3
"""Metres by which something has to be nearer to a light than a point for the point to lie in its shadow."""


class RayCaster:
    """A renderer that needs no graphics library.

    Args:
        model: What is to be seen. Geoms are as large and as coloured as they are when this is made.
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

    def render(self, data: mujoco.MjData, camera: str) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """What a camera sees: colours, and depth along the optical axis in metres, 0 where there is nothing."""
        seen = self._seen
        shown_state(self._model, data, seen)
        self._cast.mocap_pos[:] = seen.geom_xpos[self._shown]
        for place, geom in enumerate(self._shown):
            mujoco.mju_mat2Quat(self._cast.mocap_quat[place], seen.geom_xmat[geom])
        mujoco.mj_kinematics(self._copies, self._cast)
        eye = self._model.camera(camera).id
        rays = self._rays(eye)
        geoms, depth, normals = self._first_hits(seen.cam_xpos[eye], rays)
        hit = geoms >= 0
        points = seen.cam_xpos[eye] + depth[hit, None] * rays[hit]
        colours = np.broadcast_to(self._shader.background, (len(rays), 3)).copy()
        colours[hit] = self._shader.shade(
            seen,
            eye=eye,
            geoms=self._shown[geoms[hit]],
            points=points,
            normals=normals[hit],
            pixel=depth[hit] / self._focal(eye),
            lit=[self._lit(light, points) for light in range(self._model.nlight)],
        )
        height, width = self._shape
        rgb = np.rint(255 * np.clip(colours, 0, 1)).astype(np.uint8).reshape(height, width, 3)
        return rgb, np.where(hit, depth, 0).astype(np.float32).reshape(height, width)

    def close(self) -> None:
        """Nothing is held but memory."""

    def _focal(self, eye: int) -> float:
        return float(0.5 * self._shape[0] / np.tan(0.5 * np.radians(self._model.cam_fovy[eye])))

    def _rays(self, eye: int) -> NDArray[np.float64]:
        """One ray through the middle of every pixel, in the world, one metre long along the optical axis."""
        height, width = self._shape
        right, up = np.meshgrid(np.arange(width) - (width - 1) / 2, (height - 1) / 2 - np.arange(height))
        away = np.full(right.shape, -self._focal(eye))
        rays = np.stack([right, up, away], axis=-1).reshape(-1, 3) / self._focal(eye)
        turned: NDArray[np.float64] = rays @ self._seen.cam_xmat[eye].reshape(3, 3).T
        return turned

    def _first_hits(
        self, origin: NDArray[np.float64], rays: NDArray[np.float64]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """Places in ``shown`` (or -1), distances in lengths of a ray, normals."""
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
        """Which points a light reaches."""
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
    """The shown geoms and nothing else, each on a body of its own that can be placed anywhere."""
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
