"""Pictures of printed AprilTags on a panel in MuJoCo, by a camera that can be placed anywhere, like one on a hand.

Tags are flat squares with a picture, as thin as paper. A face of a MuJoCo box does not show a picture as it was drawn,
so each tag is a mesh with texture coordinates. ``benchmarks/calibration.py`` uses this too.
"""

import math

import mujoco
import numpy as np
from lockprobe_robot.box_model.tag_layout import QUIET_ZONE
from lockprobe_robot.geom_groups import NOTHING
from lockprobe_robot.rendering.probe import open_renderer

PAPER = 0.0001
"""Height of a printed tag above the board, metres."""

_PIXELS = 32
"""Pixels of the texture along a cell."""

_WHITE = 235

_CAMERA = "hand-camera"
_FROM_OPENGL = np.diag([1.0, -1.0, -1.0])
"""MuJoCo's cameras look along -z with y up; cameras of pictures look along z with y down."""


def tag_bits(numbers):
    """The cells of AprilTags of the family 36h11, True for white, shape (tags, 8, 8), the upper row first."""
    import cv2

    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    return np.array([cv2.aruco.generateImageMarker(family, number, 8) > 0 for number in numbers])


def add_tag_prints(spec, tags, bits):
    """Put tags on the body ``panel``. They are only looked at and touch nothing.

    Args:
        spec: The scene; it is changed.
        tags: Where the tags are.
        bits: Cells of each tag, True for white, shape (tags, cells, cells), the upper row first.
    """
    panel = spec.body("panel")
    half = (0.5 + QUIET_ZONE) * tags.side
    square = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
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


class HandCamera:
    """A camera that can be placed at any pose in a scene.

    Args:
        spec: The scene before it is compiled; it is changed.
        width: Pixels.
        height: Pixels.
        fovy: Vertical field of view, degrees.
    """

    def __init__(self, spec, *, width=640, height=480, fovy=58.0):
        carrier = spec.worldbody.add_body(name=_CAMERA, mocap=True)
        carrier.add_camera(name=_CAMERA, fovy=fovy)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = open_renderer(self._model, width=width, height=height)
        self.focal = 0.5 * height / math.tan(0.5 * math.radians(fovy))
        """Focal length, pixels; the optical axis is in the middle of the picture."""

    def look(self, pose):
        """A picture, shape (height, width, 3).

        Args:
            pose: Pose of the camera in the world, shape (4, 4), metres: x to the right, y down, z away from it.
        """
        self._data.mocap_pos[0] = pose[:3, 3]
        mujoco.mju_mat2Quat(self._data.mocap_quat[0], np.ascontiguousarray(pose[:3, :3] @ _FROM_OPENGL).ravel())
        rgb, _ = self._renderer.render(self._data, _CAMERA)
        return rgb

    def close(self):
        """Release the renderer."""
        self._renderer.close()
