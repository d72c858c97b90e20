"""An RGB-D frame with the pinhole camera that took it, and the handles' positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """A pinhole camera that looks at a panel: its picture in pixels, its focal length in pixels, and its place.

    ``panel`` is the pose of the panel in the frame of the camera, shape (4, 4), metres. The frame of the panel: x to
    the right and y up as seen from the front, z out of the board; the origin is the middle of the board's front. The
    frame of the camera: x to the right, y down, z away from it.
    """

    width: int
    height: int
    focal: float
    panel: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points of the panel's frame, shape (..., 3), metres, are in the image, of the same shape.

        Column and row are in pixels, from the middle of the top left pixel; the depth behind them is in metres.
        """
        seen = points @ self.panel[:3, :3].T + self.panel[:3, 3]
        middle = np.array([(self.width - 1) / 2, (self.height - 1) / 2])
        return np.concatenate([middle + self.focal * seen[..., :2] / seen[..., 2:], seen[..., 2:]], axis=-1)

    def heights(self, depth: NDArray[np.floating]) -> NDArray[np.float64]:
        """Heights above the board's front, metres; undefined where ``depth`` is 0.

        ``depth`` is along the optical axis, metres; it and the heights have the shape (height, width).
        """
        z = self.panel[:3, 2]
        right = (np.arange(self.width) - (self.width - 1) / 2) / self.focal
        down = (np.arange(self.height) - (self.height - 1) / 2) / self.focal
        height_per_metre: NDArray[np.float64] = z[0] * right + z[1] * down[:, None] + z[2]
        return depth * height_per_metre - float(z @ self.panel[:3, 3])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """An aligned pair of a colour and a depth image.

    Attributes:
        rgb: Shape (height, width, 3), 0 to 255.
        depth: Shape (height, width), metres along the optical axis; 0 where there is no reading.
        handles: Top of each joint's handle at position 0 and at position 1, whatever the joint's position is now,
            shape (joints, 2, 3), metres in the frame of the panel.
        renderer: Name and version of the renderer.
        labelled: Whether the labels of the joints can be seen.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    camera: Camera
    handles: NDArray[np.float64]
    renderer: str
    labelled: bool = True
