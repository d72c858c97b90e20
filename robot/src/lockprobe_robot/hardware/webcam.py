"""Driver of a webcam through OpenCV: the only importer of ``cv2`` for pictures."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from lockprobe.foundation.errors import Missing, PlantFault
from lockprobe_robot.hardware.camera import Shot

_STALE = 5
"""Frames that a driver may hold in its buffer; they are older than the question."""


class Webcam:
    """A webcam of this machine.

    Args:
        device: Number of the device.

    Raises:
        Missing: If OpenCV is not installed, or there is no such camera.
    """

    def __init__(self, device: int = 0) -> None:
        try:
            import cv2
        except ImportError:
            raise Missing("the webcam needs OpenCV", "pip install opencv-python-headless==4.14.0.94") from None
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails here is said by an exception
        self._cv2, self._device = cv2, device
        self._capture = cv2.VideoCapture(device)
        if not self._capture.isOpened():
            raise Missing(f"webcam {device} cannot be opened", "plug it in, or give a folder: --camera FOLDER")

    @property
    def facts(self) -> dict[str, str]:
        """The kind of camera, for the record."""
        return {"camera": f"webcam {self._device}"}

    def grab(self) -> Shot:
        """The scene now.

        Raises:
            PlantFault: If the camera gives no picture.
        """
        for _ in range(_STALE):
            self._capture.grab()
        there, picture = self._capture.read()
        if not there or picture is None:
            raise PlantFault(f"webcam {self._device} gives no picture")
        return Shot(rgb=np.ascontiguousarray(picture[..., ::-1], dtype=np.uint8))

    def close(self) -> None:
        """Release the camera."""
        with suppress(self._cv2.error):
            self._capture.release()
