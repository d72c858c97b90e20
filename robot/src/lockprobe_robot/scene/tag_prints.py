"""Printed AprilTags on a panel in MuJoCo: flat squares with a picture, as thin as paper.

A face of a MuJoCo box does not show a picture as it was drawn, so each tag is a mesh with texture coordinates.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe_robot.geom_groups import NOTHING
from lockprobe_robot.scene.tag_layout import QUIET_ZONE, TagLayout

__all__ = ["PAPER", "add_tag_prints"]

PAPER = 0.0001
"""Height of a printed tag above the board, metres."""

_PIXELS = 32
"""Pixels of the texture along a cell."""

_WHITE = 235


def add_tag_prints(spec: mujoco.MjSpec, tags: TagLayout, bits: NDArray[np.bool_]) -> None:
    """Put tags on the body ``panel``. They are only looked at and touch nothing.

    Args:
        spec: The scene; it is changed.
        tags: Where the tags are.
        bits: Cells of each tag, True for white, shape (tags, cells, cells), the upper row first.
    """
    panel = spec.body("panel")
    half = (0.5 + QUIET_ZONE) * tags.side
    square = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=np.float64)
    border = round(QUIET_ZONE * bits.shape[1])
    for number, middle in enumerate(tags.middles):
        name = f"tag-{number}"
        cells = np.pad(bits[number], border, constant_values=True)
        grey = np.kron(cells, np.full((_PIXELS, _PIXELS), _WHITE)).astype(np.uint8)
        texture = spec.add_texture(
            name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=len(grey), height=len(grey), nchannel=3
        )
        texture.data = np.repeat(grey[..., None], 3, axis=-1).tobytes()
        material = spec.add_material(name=name, specular=0.0, shininess=0.0)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        spec.add_mesh(
            name=name,
            uservert=square.ravel(),
            userface=[0, 3, 2, 0, 2, 1],
            usertexcoord=[0, 0, 1, 0, 1, 1, 0, 1],
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        panel.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            material=name,
            pos=[*middle, PAPER],
            mass=0.0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )
