"""Driver of Intel RealSense depth cameras, and a software device for rehearsals: the only importer of ``pyrealsense2``.

The software device (``pyrealsense2.software_device``) receives our pictures and delivers them as a camera does: colour
and depth together, depth in millimetres. It is not in the library's list of devices (2.59.1), so it is read without a
pipeline.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import Missing, PlantFault, needing
from lockprobe.foundation.plugins import ROBOT
from lockprobe_robot.hardware.camera import Shot

_MILLISECONDS = 2000
"""Longest wait for a picture."""

_WARM_UP = 15
"""Pictures after the start that are left out: exposure is still being set."""

_MILLIMETRE = 0.001
"""The unit of played depth, metres."""

_RATE = 30
"""Pictures per second that a played camera says it takes."""

_FOCAL = 512.0
"""Focal length that a played camera says it has, pixels. Colour and depth have the same, so aligning moves
nothing; rounding loses about 3 % of depth."""


class _Source(Protocol):
    """A source of synchronised frames: the library's pipeline, or the software device."""

    def wait_for_frames(self, milliseconds: int) -> Any: ...

    def stop(self) -> None: ...


class RealSense:
    """A depth camera whose depth is aligned with its colours.

    Args:
        serial: Its serial number; empty for the first one.
        width: Width of pictures, pixels.
        height: Height of pictures, pixels.
        rate: Pictures per second.

    Raises:
        Missing: If the library is not installed, or there is no such camera.
    """

    def __init__(self, serial: str = "", *, width: int = 640, height: int = 480, rate: int = 30) -> None:
        with needing("RealSense cameras", "realsense", ROBOT):
            import pyrealsense2 as rs
        found = [str(device.get_info(rs.camera_info.serial_number)) for device in rs.context().query_devices()]
        if not found or (serial and serial not in found):
            asked = f"RealSense camera {serial}" if serial else "a RealSense camera"
            raise Missing(f"{asked} is not connected (there are: {', '.join(found) or 'none'})", "plug it in")
        self._serial = serial or found[0]
        config = rs.config()
        config.enable_device(self._serial)
        config.enable_stream(rs.stream.color, width, height, rs.format.rgb8, rate)
        config.enable_stream(rs.stream.depth, width, height, rs.format.z16, rate)
        pipeline = rs.pipeline()
        profile = pipeline.start(config)
        self._source: _Source = pipeline
        self._metres = float(profile.get_device().first_depth_sensor().get_depth_scale())
        self._align: Any = rs.align(rs.stream.color)
        for _ in range(_WARM_UP):
            pipeline.wait_for_frames(_MILLISECONDS)

    @property
    def facts(self) -> Mapping[str, str]:
        """The kind of camera, for the record."""
        return {"camera": f"realsense {self._serial}"}

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


class PlayedRealSense(RealSense):
    """A RealSense without hardware: a function takes every picture, which passes through the library.

    Args:
        take: Takes the picture, with depth.
        width: Width of pictures, pixels.
        height: Height of pictures, pixels.

    Raises:
        Missing: If the library is not installed.
    """

    def __init__(self, take: Callable[[], Shot], *, width: int = 640, height: int = 480) -> None:
        with needing("RealSense cameras", "realsense", ROBOT):
            import pyrealsense2 as rs
        self._serial = "software_device"
        self._source = _SoftwareDevice(rs, take, width, height)
        self._metres = _MILLIMETRE
        self._align = rs.align(rs.stream.color)


class _SoftwareDevice:
    """The library's software device, whose pictures are taken on demand."""

    def __init__(self, rs: Any, take: Callable[[], Shot], width: int, height: int) -> None:
        self._rs, self._take, self._size, self._number = rs, take, (width, height), 0
        self._device, self._syncer = rs.software_device(), rs.syncer()
        self._colour = self._device.add_sensor("color")
        self._depth = self._device.add_sensor("depth")
        self._depth.add_read_only_option(rs.option.depth_units, _MILLIMETRE)
        self._profiles = (
            self._colour.add_video_stream(self._stream(rs.stream.color, 1, rs.format.rgb8, 3)),
            self._depth.add_video_stream(self._stream(rs.stream.depth, 0, rs.format.z16, 2)),
        )
        same = rs.extrinsics()
        same.rotation, same.translation = [1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, 0]
        self._profiles[1].register_extrinsics_to(self._profiles[0], same)
        self._device.create_matcher(rs.matchers.dlr_c)
        for sensor, profile in zip((self._colour, self._depth), self._profiles, strict=True):
            sensor.open(profile)
            sensor.start(self._syncer)

    def wait_for_frames(self, milliseconds: int) -> Any:
        shot = self._take()
        assert shot.depth is not None
        depth = np.rint(shot.depth / _MILLIMETRE).astype(np.uint16)
        for _ in range(2):  # the first colours after a start come without depth
            self._number += 1
            self._depth.on_video_frame(self._frame(depth, 2, self._profiles[1]))
            self._colour.on_video_frame(self._frame(np.ascontiguousarray(shot.rgb), 3, self._profiles[0]))
        return self._syncer.wait_for_frames(milliseconds)

    def stop(self) -> None:
        for sensor in (self._colour, self._depth):
            sensor.stop()
            sensor.close()

    def _stream(self, kind: Any, number: int, layout: Any, size: int) -> Any:
        stream = self._rs.video_stream()
        stream.type, stream.index, stream.uid, stream.fps = kind, 0, number, _RATE
        (stream.width, stream.height), stream.bpp, stream.fmt = self._size, size, layout
        lens = self._rs.intrinsics()
        (lens.width, lens.height), lens.fx, lens.fy = self._size, _FOCAL, _FOCAL
        lens.ppx, lens.ppy = self._size[0] / 2, self._size[1] / 2
        lens.model, lens.coeffs = self._rs.distortion.none, [0.0] * 5
        stream.intrinsics = lens
        return stream

    def _frame(self, pixels: NDArray[Any], size: int, profile: Any) -> Any:
        frame = self._rs.software_video_frame()
        frame.pixels, frame.bpp, frame.stride = pixels, size, size * self._size[0]
        frame.frame_number, frame.timestamp = self._number, 1000 * self._number / _RATE
        frame.domain, frame.profile = self._rs.timestamp_domain.hardware_clock, profile.as_video_stream_profile()
        return frame
