"""Driver of Intel RealSense depth cameras: the only importer of ``pyrealsense2``."""

from __future__ import annotations

from typing import Any

import numpy as np

from lockprobe.foundation.errors import Missing, PlantFault, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.hardware.sight import Shot

_MILLISECONDS = 2000
"""Longest wait for a picture."""

_SIZE, _RATE = (640, 480), 30
"""Pixels of a picture, and pictures per second."""

_WARM_UP = 15
"""Pictures after the start that are left out: exposure is still being set."""


class RealSense:
    """A depth camera whose depth is aligned with its colours.

    Args:
        serial: Its serial number; empty for the first one.

    Raises:
        Missing: If the library is not installed, or there is no such camera.
    """

    def __init__(self, serial: str = "") -> None:
        with needing("RealSense cameras", "realsense", ROBOT):
            import pyrealsense2 as rs
        found = [str(device.get_info(rs.camera_info.serial_number)) for device in rs.context().query_devices()]
        if not found or (serial and serial not in found):
            asked = f"RealSense camera {serial}" if serial else "a RealSense camera"
            raise Missing(f"{asked} is not connected (there are: {', '.join(found) or 'none'})", "plug it in")
        serial = serial or found[0]
        self.facts = {"camera": f"realsense {serial}"}
        config = rs.config()
        config.enable_device(serial)
        config.enable_stream(rs.stream.color, *_SIZE, rs.format.rgb8, _RATE)
        config.enable_stream(rs.stream.depth, *_SIZE, rs.format.z16, _RATE)
        self._source = rs.pipeline()
        profile = self._source.start(config)
        self._metres = float(profile.get_device().first_depth_sensor().get_depth_scale())
        self._align: Any = rs.align(rs.stream.color)
        for _ in range(_WARM_UP):
            self._source.wait_for_frames(_MILLISECONDS)

    def grab(self) -> Shot:
        """The scene now.

        Raises:
            PlantFault: If the camera gives no picture.
        """
        try:
            frames = self._align.process(self._source.wait_for_frames(_MILLISECONDS))
        except RuntimeError as error:
            raise PlantFault(f"the RealSense camera gives no picture ({error})") from None
        depth = np.asarray(frames.get_depth_frame().get_data(), dtype=np.float32) * np.float32(self._metres)
        return Shot(rgb=np.array(frames.get_color_frame().get_data(), dtype=np.uint8), depth=depth)

    def close(self) -> None:
        """Release the camera."""
        self._source.stop()
